//! Meshes joined from several objects, some of which change between preparations.

use std::sync::Arc;

use turner_bvh::{Aabb, ChangedMesh, Kept};

use super::TriangleMesh;
use super::extent::{Extent, is_hittable};
use crate::math::{Bounds, DVec3};
use crate::schema::{MeshData, PrepareOptions, SceneError};

impl TriangleMesh {
    /// A faceted mesh from checked data, with the known extent of its triangles. Call
    /// [`TriangleMesh::build_tree`] or [`TriangleMesh::share_tree`] before tracing rays.
    pub(crate) fn joined(data: Arc<MeshData>, extent: &Extent) -> TriangleMesh {
        TriangleMesh::of(data, extent, false, Vec::new())
    }

    /// Reuses the tree of `base`, with which this mesh has the triangles `kept` in common. Triangles that
    /// differ go into a small additional tree; `gone` bounds the triangles of `base` that this mesh lacks.
    /// Returns whether the tree could be reused.
    ///
    /// Errors: the memory limit.
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
        // A copy of the nodes, plus the new triangles.
        options.limits.memory.need(base.tree_bytes() as u64 / 4, || self.tree_name())?;
        let to_tree = |p: [f32; 3]| match shift == DVec3::ZERO {
            true => p,
            false => [0, 1, 2].map(|i| (f64::from(p[i]) - shift[i]) as f32),
        };
        let positions = self.data().positions.iter().map(|p| to_tree(*p));
        let finite = positions.filter(|p| p.iter().all(|x| x.is_finite()));
        let corners = |i: u32| {
            let corners = self.corners(i);
            is_hittable(&corners).then(|| corners.map(to_tree))
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
