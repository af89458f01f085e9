//! The test of one ray against two boxes at once, without false misses.
//!
//! Between the planes of a box on one axis the ray runs from `t_near` to `t_far`; it meets the box when the largest
//! of `t_min` and the near values is not above the smallest of `t_max` and the far values. In floating point
//!
//! ```text
//! t = fl(fl(plane - origin) * inv),   |rounding of each step| <= u = 2^-24 relative
//! ```
//!
//! so with `inv = fl(1 / direction)` the value is off by at most three roundings. Padding `inv` once per ray makes
//! that one-sided at no cost per node (Ize 2013, "Robust BVH ray traversal", padded the far side only, which may
//! still prune a hit at exactly `t_max`):
//!
//! * near: `inv * (1 - 6u)`, four roundings with that product: `(1 + u)^4 (1 - 6u) < 1`, never above the true value;
//! * far: `inv * (1 + 6u)`, `(1 - u)^4 (1 + 6u) > 1`, never below it.
//!
//! This holds for `t >= 0`; a negative `t` keeps its sign, and the search starts at 0. Beyond relative errors:
//!
//! | case | near | far |
//! |---|---|---|
//! | `1 / direction` overflows, or direction 0 | `inv` clamped to `MAX`: lower, and never NaN | infinite; `0 * inf` is NaN, which constrains nothing: the ray runs within the plane |
//! | `1 / direction` is subnormal (imprecise) | 0: constrains nothing | raised to a normal number |
//! | `plane - origin` overflows | 0 for origins that far away | infinite: right |
//! | the product overflows | infinite: true `t` is above `f32::MAX` too | the same |
//! | the product underflows | off by at most 2^-150: `TINY` is subtracted from the entry | the same `TINY` covers it |
//!
//! The empty box has `far = -inf` on every axis and is missed by every ray.

use crate::Ray;

/// Six planes of two boxes: per axis the two lower planes, then the two upper ones.
pub(crate) type BoxPair = [[[f32; 2]; 2]; 3];

const PAD: f32 = 3.0 * f32::EPSILON;
const TINY: f32 = f32::MIN_POSITIVE;
/// From here on, products with the paddings are normal numbers.
const PRECISE: f32 = 2.0 * f32::MIN_POSITIVE;

/// What a ray needs for box tests, computed once per ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slabs {
    origin: [f32; 3],
    inv_near: [f32; 3],
    /// Negated, so that near and far values go through one maximum, four lanes at a time.
    inv_far_negated: [f32; 3],
    /// Which of the two planes the ray meets first: 0 the lower, 1 the upper.
    near_side: [usize; 3],
    t_min: f32,
}

impl Slabs {
    /// `reach` is the largest distance of any box plane from 0.
    #[inline]
    pub(crate) fn new(ray: &Ray, reach: f32) -> Slabs {
        let mut slabs = Slabs {
            origin: ray.origin,
            inv_near: [0.0; 3],
            inv_far_negated: [0.0; 3],
            near_side: [0; 3],
            t_min: if ray.t_min > 0.0 { ray.t_min } else { 0.0 },
        };
        for axis in 0..3 {
            let d = ray.direction[axis];
            let inv = 1.0 / d.abs();
            let usable = inv >= PRECISE && ray.origin[axis].abs() + reach <= f32::MAX;
            let near = if usable { inv.min(f32::MAX) * (1.0 - PAD) } else { 0.0 };
            let far = (inv * (1.0 + PAD)).max(PRECISE);
            slabs.inv_near[axis] = near.copysign(d);
            slabs.inv_far_negated[axis] = far.copysign(-d);
            slabs.near_side[axis] = usize::from(d.is_sign_negative());
        }
        slabs
    }

    /// For each box, a lower bound of the `t` where the ray enters it, and whether it meets it at or before `t_max`.
    #[inline(always)]
    pub(crate) fn test(&self, boxes: &BoxPair, t_max: f32) -> ([f32; 2], [bool; 2]) {
        // Lanes: near of both boxes, negated far of both boxes. A comparison with NaN keeps what was there.
        let mut latest = [self.t_min, self.t_min, -t_max, -t_max];
        for axis in 0..3 {
            let near = boxes[axis][self.near_side[axis] & 1];
            let far = boxes[axis][(self.near_side[axis] & 1) ^ 1];
            let o = self.origin[axis];
            let (n, f) = (self.inv_near[axis], self.inv_far_negated[axis]);
            let planes = [near[0], near[1], far[0], far[1]];
            let inv = [n, n, f, f];
            for lane in 0..4 {
                let t = (planes[lane] - o) * inv[lane];
                latest[lane] = if t > latest[lane] { t } else { latest[lane] };
            }
        }
        let entry = [latest[0] - TINY, latest[1] - TINY];
        (entry, [entry[0] <= -latest[2], entry[1] <= -latest[3]])
    }
}
