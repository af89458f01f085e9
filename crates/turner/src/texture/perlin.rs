//! Gradient noise (Perlin 2002, "Improving noise"), and sums of it.
//!
//! Differs from the paper where a machine has changed since: lattice points are hashed by 64-bit arithmetic, so
//! that nothing repeats, and the gradients are 48 unit vectors (the corners of a truncated cuboctahedron), so
//! that no axis stands out. The same bits everywhere: only additions, multiplications and comparisons.

use crate::math::DVec3;

/// Coordinates of the 48 directions (±a, ±b, ±c) and their permutations: 1, 1 + √2, 1 + 2√2, to unit length.
const A: f64 = 0.215_739_405_272_266_48;
const B: f64 = 0.520_840_998_146_611_3;
const C: f64 = 0.825_942_591_020_956_2;

/// The 48 gradients.
const GRADIENTS: [DVec3; 48] = {
    let orders = [[A, B, C], [A, C, B], [B, A, C], [B, C, A], [C, A, B], [C, B, A]];
    let mut list = [DVec3::ZERO; 48];
    let mut i = 0;
    while i < 48 {
        let [x, y, z] = orders[i / 8];
        list[i] = DVec3::new(
            if i & 1 == 0 { x } else { -x },
            if i & 2 == 0 { y } else { -y },
            if i & 4 == 0 { z } else { -z },
        );
        i += 1;
    }
    list
};

/// Unit gradients reach √3/2 at most: the weights w of the corners at distances d give
/// |Σ w g·d| ≤ √(Σ w d²), and Σ w d² ≤ 1/4 per axis.
const TO_UNIT: f64 = 1.154_700_538_379_251_7;

/// Gradient noise: values in −1..1 with mean 0, two continuous derivatives, 0 at all whole coordinates, features
/// about one unit across.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Perlin {
    seed: u64,
}

impl Perlin {
    /// The noise of a seed.
    pub fn new(seed: u64) -> Perlin {
        Perlin { seed: mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) }
    }

    /// The value at a point; 0 where a coordinate is not finite, or so large (2^53) that it has no fraction.
    pub fn at(&self, p: DVec3) -> f64 {
        if !p.is_finite() {
            return 0.0;
        }
        let floor = p.floor();
        let d = p - floor;
        // Saturates beyond ±2^63, where d = 0 and every corner's share is 0.
        let (x, y, z) = (floor.x as i64, floor.y as i64, floor.z as i64);
        let (x0, x1) = (key(x, KX), key(x.wrapping_add(1), KX));
        let (y0, y1) = (key(y, KY), key(y.wrapping_add(1), KY));
        let (z0, z1) = (key(z, KZ), key(z.wrapping_add(1), KZ));
        let (e, w) = (d - DVec3::ONE, DVec3::new(fade(d.x), fade(d.y), fade(d.z)));
        let corner = |x: u64, y: u64, z: u64, dx: f64, dy: f64, dz: f64| {
            let h = mix(self.seed.wrapping_add(x).wrapping_add(y).wrapping_add(z));
            GRADIENTS[((h >> 32) * 48 >> 32) as usize].dot(DVec3::new(dx, dy, dz))
        };
        let near = lerp(
            lerp(corner(x0, y0, z0, d.x, d.y, d.z), corner(x1, y0, z0, e.x, d.y, d.z), w.x),
            lerp(corner(x0, y1, z0, d.x, e.y, d.z), corner(x1, y1, z0, e.x, e.y, d.z), w.x),
            w.y,
        );
        let far = lerp(
            lerp(corner(x0, y0, z1, d.x, d.y, e.z), corner(x1, y0, z1, e.x, d.y, e.z), w.x),
            lerp(corner(x0, y1, z1, d.x, e.y, e.z), corner(x1, y1, z1, e.x, e.y, e.z), w.x),
            w.y,
        );
        (TO_UNIT * lerp(near, far, w.z)).clamp(-1.0, 1.0)
    }
}

const KX: u64 = 0x9e37_79b9_7f4a_7c15;
const KY: u64 = 0xc2b2_ae3d_27d4_eb4f;
const KZ: u64 = 0x1656_67b1_9e37_79f9;

fn key(i: i64, k: u64) -> u64 {
    (i as u64).wrapping_mul(k)
}

/// Well-mixed bits (the finaliser of SplitMix64, Steele et al. 2014).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// 6t⁵ − 15t⁴ + 10t³: first and second derivative are 0 at both ends.
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// Octaves of noise, each finer and fainter than the one before. Between octaves the lattice is turned and
/// shifted, so that their zeros do not meet: summed over one lattice they show as a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fractal {
    seed: u64,
    octaves: u32,
    lacunarity: f64,
    gain: f64,
    /// One over the sum of the amplitudes.
    scale: f64,
}

impl Fractal {
    /// `octaves` (at least 1) of noise, each `lacunarity` times finer and `gain` times fainter.
    pub fn new(seed: u64, octaves: u32, lacunarity: f64, gain: f64) -> Fractal {
        let octaves = octaves.max(1);
        let (mut sum, mut amplitude) = (0.0, 1.0);
        for _ in 0..octaves {
            sum += amplitude;
            amplitude *= gain;
        }
        Fractal {
            seed: seed.wrapping_mul(0x2545_f491_4f6c_dd1d),
            octaves,
            lacunarity,
            gain,
            scale: 1.0 / sum,
        }
    }

    /// The sum of the octaves, in −1..1, mean 0.
    pub fn fbm(&self, p: DVec3) -> f64 {
        self.sum(p, |n| n)
    }

    /// The sum of the octaves' sizes, in 0..1: creased where one passes through 0.
    pub fn turbulence(&self, p: DVec3) -> f64 {
        self.sum(p, f64::abs)
    }

    #[inline]
    fn sum(&self, mut p: DVec3, f: impl Fn(f64) -> f64) -> f64 {
        let (mut sum, mut amplitude) = (0.0, self.scale);
        for octave in 0..self.octaves {
            p = turn(p);
            sum += amplitude * f(Perlin::new(self.seed.wrapping_add(u64::from(octave))).at(p));
            p *= self.lacunarity;
            amplitude *= self.gain;
        }
        sum.clamp(-1.0, 1.0)
    }
}

/// A rotation by a quaternion of whole numbers, (1, 2, 3, 4)/√30, so that it is exact to the last bit or so, and
/// a shift: no axis, diagonal or coordinate plane comes to lie in the lattice.
#[inline]
fn turn(p: DVec3) -> DVec3 {
    DVec3::new(
        (-20.0 * p.x + 4.0 * p.y + 22.0 * p.z) / 30.0 + 0.419_38,
        (20.0 * p.x - 10.0 * p.y + 20.0 * p.z) / 30.0 + 7.217_51,
        (10.0 * p.x + 28.0 * p.y + 4.0 * p.z) / 30.0 - 3.641_97,
    )
}
