//! The walk of a ray from crossing to crossing.
//!
//! Crossings of several leaves at the same t, within the rounding of both, count as one: first all these leaves
//! change, then the expression is evaluated. So two faces that coincide leave neither a skin (a difference) nor a wall
//! (a union). The hit belongs to the first of these leaves, in the order of the file, through which the ray enters or
//! leaves in the same sense as through the whole.

use super::leaf::Crossing;
use super::{Csg, Operation, PART_BITS};
use crate::math::{DVec3, Ray};
use crate::shape::ShapeHit;

/// Most steps of a walk: far more than rays have, so that no input takes forever.
const MAX_STEPS: usize = 1 << 16;

/// The root of the expression, and its first part if that is an operation.
const ROOT: u16 = 0;
const FIRST_PART: u16 = 1;

/// The state of a walk.
struct Walk<const N: usize> {
    /// The reciprocals of the ray's direction.
    inverse: DVec3,
    /// The next crossing of each leaf.
    next: [Option<Crossing>; N],
    /// Whether the ray is inside each leaf.
    inside: [bool; N],
    /// The counts of the expression.
    counts: [u16; N],
}

impl Csg {
    /// The nearest hit in the range of the ray. `N` is at least the number of leaves and of nodes.
    pub(super) fn walk<const N: usize>(&self, ray: &Ray) -> Option<ShapeHit> {
        if !(ray.is_finite() && ray.t_min <= ray.t_max && ray.direction.length_squared() > 0.0) {
            return None;
        }
        let inverse = ray.direction.recip();
        let mut walk = Walk { inverse, next: [None; N], inside: [false; N], counts: self.expression.start() };
        for i in 0..self.leaves.len() {
            self.advance(&mut walk, i, ray, ray.t_min);
        }
        for _ in 0..MAX_STEPS {
            let nearest = |a: &Crossing, b: &Crossing| a.hit.t.total_cmp(&b.hit.t);
            let first = walk.next[..self.leaves.len()].iter().flatten().copied().min_by(nearest)?;
            if first.hit.t > ray.t_max {
                return None;
            }
            let hit = self.step(&mut walk, ray, &first);
            if let Some(hit) = hit.filter(|hit| ray.contains(hit.t)) {
                return Some(hit);
            }
        }
        None
    }

    /// Crosses all leaves that are crossed together with the first one; returns the hit if the surface is there.
    fn step<const N: usize>(&self, walk: &mut Walk<N>, ray: &Ray, first: &Crossing) -> Option<ShapeHit> {
        let before = self.encloses(walk);
        // The first leaves through which the ray enters and leaves, as seen from the whole.
        let (mut entered, mut left) = (None, None);
        for i in 0..self.leaves.len() {
            let Some(crossing) = walk.next[i] else { continue };
            if crossing.hit.t - first.hit.t > crossing.error + first.error {
                continue;
            }
            if i < self.surface_leaves {
                let hit = ShapeHit { part: crossing.hit.part | (i as u32) << PART_BITS, ..crossing.hit };
                let enters = crossing.exits == self.leaves[i].flipped;
                let slot = if enters { &mut entered } else { &mut left };
                slot.get_or_insert(hit);
            }
            self.advance(walk, i, ray, (crossing.hit.t + crossing.error).max(crossing.hit.t.next_up()));
        }
        let after = self.encloses(walk);
        if self.operation == Operation::Clipped && !self.expression.others_are_true(&walk.counts, after) {
            return None;
        }
        match (before, after) {
            (false, true) => entered.or(left),
            (true, false) => left.or(entered),
            // A shape that is clipped may be open: each crossing is a hit.
            _ if self.operation == Operation::Clipped && self.surface_leaves == 1 => entered.or(left),
            _ => None,
        }
    }

    /// Whether the ray is inside the solid whose surface it may hit: the whole, or what is clipped.
    fn encloses<const N: usize>(&self, walk: &Walk<N>) -> bool {
        match self.operation {
            Operation::Clipped if self.surface_leaves == 1 => walk.inside[0] != self.leaves[0].inverted,
            Operation::Clipped => self.expression.effective(&walk.counts, FIRST_PART),
            _ => self.expression.value(&walk.counts, ROOT),
        }
    }

    /// Finds the next crossing of a leaf and whether the ray is inside until then.
    fn advance<const N: usize>(&self, walk: &mut Walk<N>, i: usize, ray: &Ray, t_min: f64) {
        let leaf = &self.leaves[i];
        let next = if leaf.may_be_hit(ray, walk.inverse, t_min) { leaf.next(ray, t_min) } else { None };
        let inside = match &next {
            Some(crossing) => crossing.exits,
            None => leaf.contains_far_end(ray),
        };
        walk.next[i] = next;
        if inside != walk.inside[i] {
            walk.inside[i] = inside;
            self.expression.change(&mut walk.counts, leaf.node, inside != leaf.inverted);
        }
    }
}
