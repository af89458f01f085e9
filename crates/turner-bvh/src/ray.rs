//! Rays in single precision.

/// The segment `t_min <= t <= t_max` of the line `origin + t * direction`.
///
/// The direction need not be normalised: `t` is in units of its length.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// The point at `t = 0`.
    pub origin: [f32; 3],
    /// The vector from `t = 0` to `t = 1`.
    pub direction: [f32; 3],
    /// Start of the interval. Traversal starts at 0 if this is negative.
    pub t_min: f32,
    /// End of the interval; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// The ray from `origin` with `t` from 0 to infinity.
    #[inline]
    pub const fn new(origin: [f32; 3], direction: [f32; 3]) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The point at `t`.
    #[inline]
    pub fn at(&self, t: f32) -> [f32; 3] {
        std::array::from_fn(|i| self.origin[i] + t * self.direction[i])
    }

    /// Whether origin and direction are finite and the interval at `t >= 0` is not empty. False if any value is NaN.
    /// Traversal visits nothing for invalid rays.
    #[inline]
    pub fn is_valid(&self) -> bool {
        // One product per number instead of six classifications: x * 0 is 0 for finite x, NaN otherwise.
        let ([x, y, z], [u, v, w]) = (self.origin, self.direction);
        let zero = (x * 0.0 + y * 0.0) + (z * 0.0 + u * 0.0) + (v * 0.0 + w * 0.0);
        zero == 0.0 && self.t_min <= self.t_max && self.t_max >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_with_non_finite_parts_are_invalid() {
        let good = Ray::new([f32::MAX, f32::MIN, -0.0], [1e-45, f32::MAX, 0.0]);
        assert!(good.is_valid());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in 0..3 {
                let (mut a, mut b) = (good, good);
                a.origin[axis] = bad;
                b.direction[axis] = bad;
                assert!(!a.is_valid() && !b.is_valid(), "{bad} on axis {axis}");
            }
        }
        assert!(!Ray { t_min: f32::NAN, ..good }.is_valid());
        assert!(!Ray { t_max: f32::NAN, ..good }.is_valid());
        assert!(!Ray { t_min: 2.0, t_max: 1.0, ..good }.is_valid());
        assert!(!Ray { t_min: -2.0, t_max: -1.0, ..good }.is_valid());
        assert!(Ray { t_min: 1.0, t_max: 1.0, ..good }.is_valid());
    }

    #[test]
    fn at_walks_along_the_direction() {
        assert_eq!(Ray::new([1.0, 2.0, 3.0], [2.0, 0.0, -2.0]).at(0.5), [2.0, 2.0, 2.0]);
    }
}
