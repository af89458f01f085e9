//! Axis-aligned boxes in single precision.

/// An axis-aligned box: all points `p` with `min[i] <= p[i] <= max[i]`.
///
/// Faces belong to the box, so flat boxes and single points are boxes like any other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The lowest corner.
    pub min: [f32; 3],
    /// The highest corner.
    pub max: [f32; 3],
}

impl Aabb {
    /// The empty box: the neutral element of [`union`](Self::union).
    pub const EMPTY: Aabb = Aabb { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The box between two corners, without checks.
    #[inline]
    pub const fn new(min: [f32; 3], max: [f32; 3]) -> Aabb {
        Aabb { min, max }
    }

    /// The smallest single-precision box that contains double-precision bounds.
    ///
    /// Each bound is rounded outwards. Bounds beyond the range of `f32` become infinite, because no finite box contains
    /// them. Then the box is not [valid](Self::is_valid), and a BVH lists it as dropped instead of silently missing it.
    /// NaN stays NaN.
    ///
    /// ```
    /// use turner_bvh::Aabb;
    /// let b = Aabb::outward([0.1; 3], [0.2; 3]);
    /// assert!(f64::from(b.min[0]) <= 0.1 && f64::from(b.max[0]) >= 0.2);
    /// ```
    #[inline]
    pub fn outward(min: [f64; 3], max: [f64; 3]) -> Aabb {
        Aabb { min: min.map(round_down), max: max.map(|x| -round_down(-x)) }
    }

    /// The smallest box that contains this one and the point `p`.
    #[inline]
    #[must_use]
    pub fn grow(self, p: [f32; 3]) -> Aabb {
        self.union(Aabb { min: p, max: p })
    }

    /// The smallest box that contains both. If a bound is NaN, the other box's bound is used.
    #[inline]
    #[must_use]
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb {
            min: std::array::from_fn(|i| self.min[i].min(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].max(other.max[i])),
        }
    }

    /// The centre; it does not overflow.
    #[inline]
    pub fn center(self) -> [f32; 3] {
        std::array::from_fn(|i| 0.5 * self.min[i] + 0.5 * self.max[i])
    }

    /// Half the surface area; 0 for the empty box. In double precision, so that the largest box does not overflow.
    #[inline]
    pub fn half_area(self) -> f64 {
        let [x, y, z]: [f64; 3] =
            std::array::from_fn(|i| (f64::from(self.max[i]) - f64::from(self.min[i])).max(0.0));
        x * y + y * z + z * x
    }

    /// Whether all six bounds are finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.min.iter().chain(&self.max).all(|x| x.is_finite())
    }

    /// Whether a BVH accepts this box: finite, and `min <= max` on every axis.
    #[inline]
    pub fn is_valid(self) -> bool {
        self.is_finite() && (0..3).all(|i| self.min[i] <= self.max[i])
    }

    /// Whether this box contains `other`, including the faces. Every box contains the empty box.
    #[inline]
    pub fn contains(self, other: Aabb) -> bool {
        other == Aabb::EMPTY || (0..3).all(|i| self.min[i] <= other.min[i] && other.max[i] <= self.max[i])
    }

    /// Whether this box contains the point, including the faces.
    #[inline]
    pub fn contains_point(self, p: [f32; 3]) -> bool {
        (0..3).all(|i| self.min[i] <= p[i] && p[i] <= self.max[i])
    }
}

impl Default for Aabb {
    /// The empty box.
    fn default() -> Aabb {
        Aabb::EMPTY
    }
}

/// The largest `f32` that is not above `x`, or -inf; NaN stays NaN.
#[inline]
fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outward_is_the_tightest_enclosing_box() {
        for x in [0.1, -0.1, 1.0, 16777217.0, -16777217.0, 1e-50, -1e-50, 0.0, 3.4028235e38, 1e-45] {
            let b = Aabb::outward([x; 3], [x; 3]);
            assert!(f64::from(b.min[0]) <= x && x <= f64::from(b.max[1]), "{x}: {b:?}");
            assert!(f64::from(b.min[0].next_up()) > x && f64::from(b.max[0].next_down()) < x, "{x}: {b:?}");
        }
        assert_eq!(Aabb::outward([1.5; 3], [2.5; 3]), Aabb::new([1.5; 3], [2.5; 3]));
    }

    #[test]
    fn outward_beyond_single_precision_is_infinite_on_that_side_only() {
        let b = Aabb::outward([-1e39, 1e39, -1e300], [0.0, 1e40, 1e300]);
        assert_eq!(b.min, [f32::NEG_INFINITY, f32::MAX, f32::NEG_INFINITY]);
        assert_eq!(b.max, [0.0, f32::INFINITY, f32::INFINITY]);
        assert!(!b.is_valid());
        assert!(Aabb::outward([f64::NAN; 3], [1.0; 3]).min[0].is_nan());
    }

    #[test]
    fn empty_is_neutral_and_has_no_area() {
        let b = Aabb::new([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]);
        assert_eq!(Aabb::EMPTY.union(b), b);
        assert_eq!(Aabb::EMPTY.grow([1.0; 3]), Aabb::new([1.0; 3], [1.0; 3]));
        assert_eq!(Aabb::EMPTY.half_area(), 0.0);
        assert_eq!(b.half_area(), 2.0 + 6.0 + 3.0);
        assert_eq!(b.center(), [1.5, 3.0, 4.5]);
        assert!(!Aabb::EMPTY.is_valid() && b.is_valid());
        assert!(b.contains(Aabb::EMPTY) && b.contains(b) && !b.contains(b.grow([0.0; 3])));
        assert!(b.contains_point([1.0, 4.0, 5.0]) && !b.contains_point([0.9, 4.0, 5.0]));
    }

    #[test]
    fn the_largest_box_overflows_nowhere() {
        let b = Aabb::new([f32::MIN; 3], [f32::MAX; 3]);
        assert_eq!(b.center(), [0.0; 3]);
        assert!(b.half_area().is_finite() && b.is_valid());
    }
}
