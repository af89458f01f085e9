//! Ray-box intersection in exact rational arithmetic.

use std::cmp::Ordering;

use turner_bvh::{Aabb, Ray};

/// `num / den` with `den > 0`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ratio {
    num: i128,
    den: i128,
}

impl Ratio {
    fn new(num: i128, den: i128) -> Ratio {
        if den < 0 { Ratio { num: -num, den: -den } } else { Ratio { num, den } }
    }

    /// The value of a float up to 2^40 that is a multiple of 2^-40.
    fn of(x: f32) -> Ratio {
        let scaled = f64::from(x) * (1_u64 << 40) as f64;
        assert!(scaled == scaled.trunc() && scaled.abs() <= (1_u128 << 80) as f64, "{x} is out of range");
        Ratio { num: scaled as i128, den: 1 << 40 }
    }

    pub(crate) fn cmp(&self, other: &Ratio) -> Ordering {
        (self.num * other.den).cmp(&(other.num * self.den))
    }

    fn min(self, other: Ratio) -> Ratio {
        if other.cmp(&self).is_lt() { other } else { self }
    }

    fn max(self, other: Ratio) -> Ratio {
        if other.cmp(&self).is_gt() { other } else { self }
    }

    /// A float next to the value.
    pub(crate) fn nearest(&self) -> f32 {
        (self.num as f64 / self.den as f64) as f32
    }
}

/// The exact t at which the ray enters the box with `0 <= t_min <= t <= t_max`. Coordinates are integers below 2^24.
pub(crate) fn enter(ray: &Ray, b: &Aabb) -> Option<Ratio> {
    let mut first = Ratio::of(ray.t_min);
    let mut last = if ray.t_max.is_finite() { Ratio::of(ray.t_max) } else { Ratio { num: 1 << 60, den: 1 } };
    for axis in 0..3 {
        let [lo, hi, o, d] =
            [b.min[axis], b.max[axis], ray.origin[axis], ray.direction[axis]].map(|x| i128::from(x as i64));
        if d == 0 {
            if o < lo || o > hi {
                return None;
            }
            continue;
        }
        let (near, far) = if d > 0 { (lo, hi) } else { (hi, lo) };
        first = first.max(Ratio::new(near - o, d));
        last = last.min(Ratio::new(far - o, d));
    }
    first.cmp(&last).is_le().then_some(first)
}

/// A splitmix64 generator for tests.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// An integer in `-n..=n`.
    pub(crate) fn integer(&mut self, n: u32) -> f32 {
        (self.bits() % (2 * u64::from(n) + 1)) as f32 - n as f32
    }

    pub(crate) fn integers(&mut self, n: u32) -> [f32; 3] {
        [0; 3].map(|_| self.integer(n))
    }

    pub(crate) fn point(&mut self) -> [f32; 3] {
        [0; 3].map(|_| 2.0 * self.unit() - 1.0)
    }
}
