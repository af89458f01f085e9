//! Bounds of the part of a triangle inside a box, for spatial splits.
//!
//! ```text
//!             c
//!            / \              The triangle is clipped against the six planes of the box
//!    +------*---*------+      (Sutherland and Hodgman 1974). The polygon a b * * remains;
//!    |     /     \     |      its bounds are tighter than the intersection of both boxes
//!    |    a-------b    |      when the triangle is slanted.
//!    +-----------------+
//! ```

use super::prims::Bounds;
use crate::Aabb;

/// A triangle clipped by six planes has at most nine vertices.
const MAX_CORNERS: usize = 10;

/// Bounds of the part of the triangle inside `within`; `None` if that part is empty.
///
/// Conservative: works in double precision against planes that are moved outwards by far more than the rounding error,
/// and rounds the result outwards.
pub(super) fn clipped(triangle: [[f32; 3]; 3], within: Aabb) -> Option<Aabb> {
    let mut corners = [[0.0_f64; 3]; MAX_CORNERS];
    for (corner, p) in corners.iter_mut().zip(triangle) {
        *corner = p.map(f64::from);
    }
    let mut count = 3;
    let largest = triangle.iter().flatten().map(|x| x.abs()).fold(0.0, f32::max);
    let slack = f64::from(largest) * 1e-13;
    for axis in 0..3 {
        for (sign, plane) in [(1.0, f64::from(within.max[axis])), (-1.0, -f64::from(within.min[axis]))] {
            count = cut(&mut corners, count, axis, sign, plane + slack);
        }
    }
    let corners = &corners[..count];
    if corners.is_empty() {
        return None;
    }
    let min = std::array::from_fn(|i| corners.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min) - slack);
    let max = std::array::from_fn(|i| corners.iter().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max) + slack);
    let outer = Aabb::outward(min, max);
    let b = Aabb {
        min: std::array::from_fn(|i| outer.min[i].max(within.min[i])),
        max: std::array::from_fn(|i| outer.max[i].min(within.max[i])),
    };
    b.is_valid().then_some(b)
}

/// Clips a convex polygon to the half space `sign * p[axis] <= limit` (Sutherland and Hodgman 1974).
fn cut(corners: &mut [[f64; 3]; MAX_CORNERS], count: usize, axis: usize, sign: f64, limit: f64) -> usize {
    let height = |p: &[f64; 3]| sign * p[axis] - limit;
    if corners[..count].iter().all(|p| height(p) <= 0.0) {
        return count;
    }
    let old = *corners;
    let mut kept = 0;
    for i in 0..count {
        let (a, b) = (old[i], old[(i + 1) % count]);
        let (ha, hb) = (height(&a), height(&b));
        if ha <= 0.0 && kept < MAX_CORNERS {
            corners[kept] = a;
            kept += 1;
        }
        if (ha <= 0.0) != (hb <= 0.0) && kept < MAX_CORNERS {
            let t = ha / (ha - hb);
            corners[kept] = std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t);
            corners[kept][axis] = sign * limit;
            kept += 1;
        }
    }
    kept
}

/// [`clipped`] as the builders' [`Bounds`].
pub(super) fn clipped_bounds(triangle: [[f32; 3]; 3], within: Aabb) -> Option<Bounds> {
    clipped(triangle, within).map(|b| Bounds::from_corners(b.min, b.max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_is_cut_off() {
        let triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let b = clipped(triangle, Aabb::new([1.0, 0.0, -1.0], [4.0, 4.0, 1.0])).unwrap();
        assert_eq!((b.min, b.max[0]), ([1.0, 0.0, b.min[2]], 4.0));
        assert!(b.max[1] >= 3.0 && b.max[1] < 3.00001 && b.max[2] >= 0.0 && b.max[2] < 1e-6, "{b:?}");
        assert_eq!(clipped(triangle, Aabb::new([3.0, 3.0, -1.0], [4.0, 4.0, 1.0])), None);
    }
}
