//! Pseudo-random numbers for tests, equal on every machine.

use crate::math::DVec3;
use crate::math::elementary::sin_cos;

/// A small pseudo-random generator (SplitMix64, Steele et al. 2014). Renders use counter-based samplers instead.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Independent numbers in 0..1.
    pub fn units<const N: usize>(&mut self) -> [f64; N] {
        [0; N].map(|_| self.unit())
    }

    /// A point with coordinates in −1..1.
    pub fn in_cube(&mut self) -> DVec3 {
        DVec3::from([0; 3].map(|_| 2.0 * self.unit() - 1.0))
    }

    /// A unit vector.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.in_cube();
            if v.length() > 0.01 && v.length() <= 1.0 {
                return v.normalize();
            }
        }
    }
}

/// The k-th of a sequence of well distributed points in the unit cube (Halton 1960, bases 2, 3 and 5).
pub fn spread(k: u32) -> [f64; 3] {
    [2u32, 3, 5].map(|base| {
        let (mut k, mut digit, mut u) = (k + 1, 1.0, 0.0);
        while k > 0 {
            digit /= f64::from(base);
            u += f64::from(k % base) * digit;
            k /= base;
        }
        u
    })
}

/// The unit vector with the given `z` (−1 to 1) at the azimuth `phi`, radians from x.
pub fn direction(z: f64, phi: f64) -> DVec3 {
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = sin_cos(phi);
    DVec3::new(r * c, r * s, z)
}
