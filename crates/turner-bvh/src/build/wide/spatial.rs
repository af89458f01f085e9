//! Spatial splits (Stich, Friedrich, Dietrich 2009, "Spatial splits in bounding volume hierarchies").
//!
//! An object split of long or overlapping triangles leaves two boxes that overlap, and rays in the overlap visit both.
//! A spatial split cuts space at a plane. A triangle that straddles the plane is referenced on both sides, each time
//! with the bounds of its part there:
//!
//! ```text
//!        |plane                  left: bounds of a and of the left part of b
//!   __a__|                       right: bounds of c and of the right part of b
//!     ___|_____b____             The boxes do not overlap; b is referenced twice.
//!        |   ___c___
//! ```
//!
//! To find the plane, each axis is divided into slabs of equal width. Each triangle is clipped to every slab it
//! touches, and slabs count the triangles that begin and end there. A sweep then evaluates the SAH cost
//! `area_l * n_l + area_r * n_r` at each plane, as for bins; `n_l + n_r` exceeds `n` by the straddling triangles.
//!
//! A straddling triangle goes to one side only if enlarging that box is cheaper than a second reference
//! (reference unsplitting).

use super::clip::clipped_bounds;
use super::lanes::F4;
use super::prims::{Bounds, Costs, Prim};
use crate::Aabb;

const BINS: usize = 16;

/// Scaled triangles by ID.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangles<'a> {
    pub(super) positions: &'a [[f32; 3]],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) scale: f32,
}

impl Triangles<'_> {
    #[inline(always)]
    fn corners(&self, id: u32) -> [[f32; 3]; 3] {
        self.triangles[id as usize].map(|v| self.positions[v as usize].map(|x| x * self.scale))
    }
}

/// For each axis and slab: the bounds of the clipped primitives, and how many primitives begin and end there.
#[derive(Debug)]
pub(super) struct SpatialBins {
    boxes: [[Bounds; BINS]; 3],
    first: [[u32; BINS]; 3],
    last: [[u32; BINS]; 3],
}

/// A split plane, its cost, and the counts and bounds of both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    axis: usize,
    at: f32,
    pub(super) cost: f32,
    pub(super) counts: [usize; 2],
    bounds: [Bounds; 2],
}

impl SpatialBins {
    pub(super) fn new() -> SpatialBins {
        SpatialBins { boxes: [[Bounds::empty(); BINS]; 3], first: [[0; BINS]; 3], last: [[0; BINS]; 3] }
    }

    /// The cheapest plane with primitives on both sides.
    pub(super) fn best_plane(
        &mut self,
        prims: &[Prim],
        bounds: Bounds,
        triangles: &Triangles<'_>,
        costs: &Costs,
    ) -> Option<Plane> {
        *self = SpatialBins::new();
        let set_box = bounds.aabb();
        let extents: [f32; 3] = std::array::from_fn(|i| set_box.max[i] - set_box.min[i]);
        let widths = extents.map(|e| e / BINS as f32);
        let largest = extents.iter().fold(0.0_f32, |a, &b| a.max(b));
        // Do not split an axis on which the box is almost flat.
        let axes = [0, 1, 2]
            .map(|i| extents[i] > 1e-4 * largest && widths[i] > f32::MIN_POSITIVE && widths[i].is_finite());
        let inverse: [f32; 3] = std::array::from_fn(|i| if axes[i] { 1.0 / widths[i] } else { 0.0 });
        let [scale, start] = [inverse, set_box.min].map(|[x, y, z]| F4::new([x, y, z, 0.0]));
        let (zero, top) = (F4::splat(0.0), F4::splat((BINS - 1) as f32));
        let slab_of = |p: F4| p.sub(start).mul(scale).max(zero).min(top).truncated();
        for prim in prims {
            let (low, high) = (slab_of(prim.bounds.lo), slab_of(zero.sub(prim.bounds.hi)));
            let mut corners = None;
            for axis in 0..3 {
                let (from, to) = (low[axis] as usize % BINS, high[axis] as usize % BINS);
                self.first[axis][from] += 1;
                self.last[axis][to] += 1;
                if from == to {
                    let b = &mut self.boxes[axis][from];
                    *b = b.union(prim.bounds);
                } else {
                    let corners = *corners.get_or_insert_with(|| triangles.corners(prim.id()));
                    self.spread(axis, [from, to], prim.bounds, corners, set_box.min[axis], inverse[axis]);
                }
            }
        }
        let mut best: Option<Plane> = None;
        for axis in (0..3).filter(|&i| axes[i]) {
            let mut right = [(Bounds::empty(), 0); BINS + 1];
            for bin in (1..BINS).rev() {
                let (b, count) = right[bin + 1];
                right[bin] = (b.union(self.boxes[axis][bin]), count + self.last[axis][bin] as usize);
            }
            let (mut left, mut left_count) = (Bounds::empty(), 0);
            for bin in 0..BINS - 1 {
                left = left.union(self.boxes[axis][bin]);
                left_count += self.first[axis][bin] as usize;
                let (right, right_count) = right[bin + 1];
                if left_count == 0 || right_count == 0 {
                    continue;
                }
                let cost = costs.leaf(left, left_count) + costs.leaf(right, right_count);
                if best.is_none_or(|best| cost < best.cost) {
                    let at = set_box.min[axis] + widths[axis] * (bin + 1) as f32;
                    let (counts, bounds) = ([left_count, right_count], [left, right]);
                    best = Some(Plane { axis, at, cost, counts, bounds });
                }
            }
        }
        best
    }

    /// Adds a triangle to the slabs it touches: to each slab its vertices there and the points where edges cross the
    /// slab's planes.
    fn spread(
        &mut self,
        axis: usize,
        [from, to]: [usize; 2],
        bounds: Bounds,
        corners: [[f32; 3]; 3],
        min: f32,
        inverse: f32,
    ) {
        let mut parts = [Bounds::empty(); BINS];
        let p = corners.map(|p| F4::new([p[0], p[1], p[2], 0.0]));
        let width = 1.0 / inverse;
        let slab = |x: f32| (((x - min) * inverse) as usize).clamp(from, to);
        for i in 0..3 {
            let (mut a, mut b) = (i, (i + 1) % 3);
            if corners[a][axis] > corners[b][axis] {
                (a, b) = (b, a);
            }
            let (x, y) = (corners[a][axis], corners[b][axis]);
            let (first, last) = (slab(x), slab(y));
            parts[first] = parts[first].union(Bounds::point(p[a]));
            parts[last] = parts[last].union(Bounds::point(p[b]));
            let edge = p[b].sub(p[a]);
            let per_length = if first < last { 1.0 / (y - x) } else { 0.0 };
            for bin in first..last {
                let plane = min + width * (bin + 1) as f32;
                let t = ((plane - x) * per_length).clamp(0.0, 1.0);
                let point = Bounds::point(p[a].add(edge.mul(F4::splat(t))));
                parts[bin] = parts[bin].union(point);
                parts[bin + 1] = parts[bin + 1].union(point);
            }
        }
        for (part, in_slab) in parts[from..=to].iter().zip(&mut self.boxes[axis][from..=to]) {
            // Clip to the primitive's own bounds, which may already be those of a part.
            let part = Bounds { lo: part.lo.max(bounds.lo), hi: part.hi.max(bounds.hi) };
            let sum = part.lo.add(part.hi).array();
            if sum[0] <= 0.0 && sum[1] <= 0.0 && sum[2] <= 0.0 {
                *in_slab = in_slab.union(part);
            }
        }
    }
}

/// Appends the primitives and parts left of the plane to `left`, those right of it to `right`.
pub(super) fn cut(
    prims: &[Prim],
    plane: &Plane,
    triangles: &Triangles<'_>,
    costs: &Costs,
    left: &mut Vec<Prim>,
    right: &mut Vec<Prim>,
) {
    let axis = plane.axis;
    let areas = plane.bounds.map(|b| b.area(costs.pad));
    let counts = plane.counts.map(|n| n as f32);
    for prim in prims {
        let b = prim.bounds.aabb();
        if b.max[axis] <= plane.at {
            left.push(*prim);
            continue;
        }
        if b.min[axis] >= plane.at {
            right.push(*prim);
            continue;
        }
        // Unsplit: keep the primitive on one side if that is cheaper than two references.
        let [with_left, with_right] = plane.bounds.map(|side| side.union(prim.bounds).area(costs.pad));
        let split = areas[0] * counts[0] + areas[1] * counts[1];
        let unsplit_left = with_left * counts[0] + areas[1] * (counts[1] - 1.0);
        let unsplit_right = areas[0] * (counts[0] - 1.0) + with_right * counts[1];
        if unsplit_left < split && unsplit_left <= unsplit_right {
            left.push(*prim);
            continue;
        }
        if unsplit_right < split {
            right.push(*prim);
            continue;
        }
        let corners = triangles.corners(prim.id());
        let (mut below, mut above) = (b, b);
        below.max[axis] = plane.at;
        above.min[axis] = plane.at;
        let parts: [Option<Bounds>; 2] = [below, above].map(|side: Aabb| clipped_bounds(corners, side));
        if let Some(part) = parts[0] {
            left.push(prim.with_bounds(part));
        }
        if let Some(part) = parts[1] {
            right.push(prim.with_bounds(part));
        }
        if parts[0].is_none() && parts[1].is_none() {
            left.push(*prim);
        }
    }
}
