//! Constructive solid geometry (Roth 1982, "Ray Casting for Modeling Solids"): union, intersection and difference of
//! closed shapes, and shapes clipped by others.
//!
//! Nested operations become one expression over all leaves (`expression`). A ray walks from crossing to crossing of
//! the leaves and stops where the value of the expression changes (`walk`):
//!
//! ```text
//!   leaf a        ├───────────────────┤
//!   leaf b                 ├──────────────────┤
//!   a without b   ├────────┤                         hits: a from outside, b from inside
//!   t ───────────────────────────────────────────►
//! ```
//!
//! A leaf needs only what [`Shape`](crate::shape::Shape) promises: the nearest hit after a given t, and the normal there. A ray is inside a
//! leaf if it leaves the leaf at the next crossing. Nothing is counted, so a crossing that is found twice or missed at
//! an edge does no harm beyond that edge.
//!
//! The part of a hit has the leaf in its upper eight bits and the part of the leaf's shape below.

mod build;
mod closed;
mod desc;
mod expression;
mod leaf;
#[cfg(test)]
mod tests;
mod walk;

pub use desc::{ClippedDesc, CsgPart, DifferenceDesc, IntersectionDesc, UnionDesc};

#[cfg(test)]
pub(in crate::shape) use closed::open_edges;
use expression::Expression;
use leaf::Leaf;

use super::SolidGeometry;
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::MaterialId;
use crate::shape::{ShapeHit, SurfacePoint, TriangleMesh};

/// The largest number of shapes, and of operations, in one expression.
pub const MAX_LEAVES: usize = 256;

/// Bits of a hit's part that belong to the leaf's shape.
const PART_BITS: u32 = 24;

/// How parts are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Inside at least one part.
    Union,
    /// Inside all parts.
    Intersection,
    /// Inside the first part and outside all others.
    Difference,
    /// The surface of the first part, inside all others.
    Clipped,
}

impl Operation {
    /// Its name in a scene file.
    pub fn word(self) -> &'static str {
        match self {
            Operation::Union => UnionDesc::DOC.name,
            Operation::Intersection => IntersectionDesc::DOC.name,
            Operation::Difference => DifferenceDesc::DOC.name,
            Operation::Clipped => ClippedDesc::DOC.name,
        }
    }
}

/// Constructive solid geometry, ready for rays.
#[derive(Clone, Debug)]
pub struct Csg {
    operation: Operation,
    leaves: Vec<Leaf>,
    expression: Expression,
    /// The number of leaves, first in the list, whose surfaces are hit: those of the first part if it is clipped, or
    /// all.
    surface_leaves: usize,
    bounds: Option<Bounds>,
    /// Materials of the leaves; a mesh has one for each of its own. Empty if no part has a material.
    materials: Vec<Option<MaterialId>>,
}

impl Csg {
    /// Its name in a scene file.
    pub fn word(&self) -> &'static str {
        self.operation.word()
    }

    /// The leaf that was hit, and the hit on its shape.
    fn leaf_of(&self, hit: &ShapeHit) -> (&Leaf, ShapeHit) {
        let leaf = (hit.part >> PART_BITS) as usize;
        let inner = ShapeHit { part: hit.part & ((1 << PART_BITS) - 1), ..*hit };
        (&self.leaves[leaf.min(self.leaves.len() - 1)], inner)
    }
}

impl SolidGeometry for Csg {
    fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        // Arrays on the stack in few sizes: the small ones are the usual ones.
        match self.leaves.len().max(self.expression.nodes()) {
            0..=4 => self.walk::<4>(ray),
            5..=16 => self.walk::<16>(ray),
            17..=64 => self.walk::<64>(ray),
            _ => self.walk::<MAX_LEAVES>(ray),
        }
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let (leaf, inner) = self.leaf_of(hit);
        leaf.surface(ray, &inner)
    }

    fn uv(&self, hit: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        let (leaf, inner) = self.leaf_of(hit);
        leaf.shape().uv(&inner, &leaf.local_point(point))
    }

    fn curvature(&self, hit: &ShapeHit) -> f64 {
        let (leaf, inner) = self.leaf_of(hit);
        leaf.curvature(&inner)
    }

    fn is_closed(&self) -> bool {
        self.operation != Operation::Clipped
    }

    fn hull_points(&self) -> Vec<DVec3> {
        let Some(bounds) = self.bounds else { return Vec::new() };
        let within = |p: &DVec3| p.cmpge(bounds.min).all() && p.cmple(bounds.max).all();
        let points: Vec<DVec3> = self.leaves.iter().flat_map(Leaf::hull_points).filter(within).collect();
        if points.is_empty() { bounds.corners().to_vec() } else { points }
    }

    fn memory(&self) -> usize {
        size_of_val(&self.leaves[..]) + self.leaves.iter().map(Leaf::memory).sum::<usize>()
    }

    fn tests_per_ray(&self) -> f64 {
        self.leaves.iter().map(|leaf| leaf.shape().tests_per_ray()).sum()
    }

    fn materials(&self) -> &[Option<MaterialId>] {
        &self.materials
    }

    fn material_slot(&self, hit: &ShapeHit) -> usize {
        let (leaf, inner) = self.leaf_of(hit);
        leaf.material_slot(&inner)
    }

    fn mesh_at(&self, hit: &ShapeHit) -> Option<(&TriangleMesh, ShapeHit)> {
        let (leaf, inner) = self.leaf_of(hit);
        leaf.mesh().map(|mesh| (mesh, inner))
    }
}
