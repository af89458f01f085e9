//! Meshes that are joined of others, some of which change.

use std::sync::Arc;

use turner_bvh::{Aabb, ChangedMesh, Kept};

use super::TriangleMesh;
use super::extent::{Extent, is_shown};
use crate::math::{Bounds, DVec3};
use crate::schema::{MeshData, PrepareOptions, SceneError};

impl TriangleMesh {
    /// A faceted mesh of data that were checked, with the extent of all its triangles. [`TriangleMesh::build_tree`] or [`TriangleMesh::share_tree`] must follow.
    pub(crate) fn joined(data: Arc<MeshData>, extent: &Extent) -> TriangleMesh {
        TriangleMesh::of(data, extent, false, Vec::new())
    }

    /// Takes over the tree of a mesh that has the triangles `kept` in common with this one, with what differs in a small tree of its own; `gone` holds those that this
    /// mesh lacks. Says whether that could be done.
    ///
    /// Errors: memory that there is not.
    pub(crate) fn share_tree(
        &self,
        base: &TriangleMesh,
        kept: &[Kept],
        gone: &Bounds,
        options: &PrepareOptions,
    ) -> Result<bool, SceneError> {
        let shift = self.space().shift();
        if base.space().shift() != shift {
            return Ok(false);
        }
        // A copy of the nodes, and what is new.
        options.limits.memory.need(base.tree_bytes() as u64 / 4, || self.tree_name())?;
        let to_tree = |p: [f32; 3]| match shift == DVec3::ZERO {
            true => p,
            false => [0, 1, 2].map(|i| (f64::from(p[i]) - shift[i]) as f32),
        };
        let positions = self.data().positions.iter().map(|p| to_tree(*p));
        let finite = positions.filter(|p| p.iter().all(|x| x.is_finite()));
        let corners = |i: u32| {
            let corners = self.corners(i);
            is_shown(&corners).then(|| corners.map(to_tree))
        };
        let mesh = ChangedMesh {
            count: self.data().triangles.len() as u32,
            kept,
            gone: Aabb::outward((gone.min - shift).to_array(), (gone.max - shift).to_array()),
            farthest: finite.flatten().fold(0.0_f32, |most, x| most.max(x.abs())),
            corners: &corners,
        };
        let build = self.build_options(options);
        let tree = base.tree().changed(&mesh, &build).map_err(|e| self.refused(&e, options))?;
        Ok(tree.is_some_and(|tree| self.set_tree(tree)))
    }
}
