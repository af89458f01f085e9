//! Ray batches through meshes: all rays traverse each mesh together.

use std::cell::Cell;

use turner_bvh::lanes::LANES;

use crate::math::DVec3;
use crate::scene::alpha_test::NO_FACES;
use crate::scene::ray_batch::RayBatch;
use crate::scene::scene::{NO_TRANSFORM, Primitive};
use crate::scene::world_mesh::StaticWorldMesh;
use crate::scene::{Hit, RayOrigin, Scene};
use crate::shape::{BlockRays, NO_TRIANGLE, Shape, ShapeHit, TriangleMesh};

/// The query for rays and a mesh.
#[derive(Clone, Copy)]
enum MeshQuery {
    /// The nearest hit of each ray.
    Nearest,
    /// Whether each ray has a hit.
    Any,
}

impl Scene {
    /// Keeps the hits of meshes that are nearer than the hits so far, at which the rays end.
    pub(crate) fn intersect_meshes(&self, meshes: &[u32], rays: &mut RayBatch, hits: &mut [Option<Hit>]) {
        if let Some(world_mesh) = &self.world_mesh {
            let own = |p, part| world_mesh.triangle(p, part);
            self.intersect_mesh(world_mesh.mesh(), None, world_mesh.offset(), own, MeshQuery::Nearest, rays);
            let found = std::mem::take(&mut rays.found);
            for &(slot, found) in &found {
                let mut hit = world_mesh.owned(&found);
                if world_mesh.is_alpha_tested() {
                    let Some(ray) = rays.get_to_end(slot) else { continue };
                    if !self.accepts_world_mesh_hit(&ray, &hit) {
                        match self.intersect_world_mesh_behind(world_mesh, &ray) {
                            Some(behind) => hit = behind,
                            None => continue,
                        }
                    }
                }
                let mut end = rays.end(slot);
                self.keep_nearer_before(hit, &mut end, &mut hits[slot as usize]);
                rays.end_ray(slot, end);
            }
            rays.found = found;
        }
        for &index in meshes {
            let primitive = &self.primitives[index as usize];
            let Shape::Mesh(mesh) = &primitive.shape else { continue };
            let own = |p, part| if p == index { part } else { NO_TRIANGLE };
            self.intersect_mesh(mesh, Some(primitive), DVec3::ZERO, own, MeshQuery::Nearest, rays);
            let alpha_tested =
                primitive.faces != NO_FACES && self.faces[primitive.faces as usize].need_test();
            let found = std::mem::take(&mut rays.found);
            for &(slot, mut found) in &found {
                let Some(mut ray) = rays.get_to_end(slot) else { continue };
                if alpha_tested && !self.accepts_hit(primitive, &self.to_object(primitive, &ray), &found) {
                    // The alpha test failed; search behind this hit.
                    match self.intersect_faces(primitive, &ray) {
                        Some(hit) => found = hit,
                        None => continue,
                    }
                }
                self.keep_nearer(index, found, &mut ray, &mut hits[slot as usize]);
                rays.end_ray(slot, ray.t_max);
            }
            rays.found = found;
        }
    }

    /// Finds the hits of a mesh up to the rays' ends; with [`MeshQuery::Any`] only which rays have one.
    fn intersect_mesh(
        &self,
        mesh: &TriangleMesh,
        primitive: Option<&Primitive>,
        offset: DVec3,
        own: impl Fn(u32, u32) -> u32,
        query: MeshQuery,
        rays: &mut RayBatch,
    ) {
        self.move_to(primitive, rays);
        rays.found.clear();
        let used = rays.len.div_ceil(LANES);
        let RayBatch { blocks, moved, ends, from, to, scratch, found, .. } = rays;
        let blocks = if self.is_moved(primitive) { &moved[..] } else { &blocks[..used] };
        let triangle = |of: &RayOrigin| own(of.primitive, of.part);
        let skipped = |slot: usize| [from.get(slot), to.get(slot)].map(|of| of.map_or(NO_TRIANGLE, triangle));
        let searched = BlockRays { offset, blocks, ends, skipped };
        match query {
            MeshQuery::Nearest => {
                mesh.intersect_blocks(&searched, scratch, |slot, hit| found.push((slot as u32, hit)))
            }
            MeshQuery::Any => {
                let hit = ShapeHit { t: 0.0, part: 0, u: 0.0, v: 0.0 };
                mesh.occluded_blocks(&searched, scratch, |slot| found.push((slot as u32, hit)));
            }
        }
    }

    fn is_moved(&self, primitive: Option<&Primitive>) -> bool {
        primitive.is_some_and(|p| p.transform != NO_TRANSFORM)
    }

    fn move_to(&self, primitive: Option<&Primitive>, rays: &mut RayBatch) {
        if let Some(p) = primitive
            && p.transform != NO_TRANSFORM
        {
            rays.move_into(&self.transforms[p.transform as usize]);
        }
    }

    /// Marks rays that the static world mesh blocks or tints; rays already blocked are skipped.
    pub(crate) fn occlude_by_world_mesh(&self, world_mesh: &StaticWorldMesh, rays: &mut RayBatch) {
        rays.end_unblocked();
        // If some members are not opaque, the nearest triangle decides for most rays.
        let query = if world_mesh.is_opaque() { MeshQuery::Any } else { MeshQuery::Nearest };
        self.intersect_mesh(
            world_mesh.mesh(),
            None,
            world_mesh.offset(),
            |p, i| world_mesh.triangle(p, i),
            query,
            rays,
        );
        let found = std::mem::take(&mut rays.found);
        for &(slot, hit) in &found {
            let tinted = Cell::new(false);
            let blocked = world_mesh.is_opaque()
                || rays.get(slot as usize).is_some_and(|ray| {
                    self.world_mesh_hit_blocks(&ray, &world_mesh.owned(&hit), &tinted)
                        || self.world_mesh_blocks(world_mesh, &ray, &tinted)
                });
            rays.mark(slot as usize, blocked, tinted.get());
        }
        rays.found = found;
    }

    /// The same for a mesh with its own BVH; `opaque` says whether it casts an opaque shadow.
    pub(crate) fn occlude_by_mesh(&self, index: u32, opaque: bool, rays: &mut RayBatch) {
        let primitive = &self.primitives[index as usize];
        let Shape::Mesh(mesh) = &primitive.shape else { return };
        rays.end_unblocked();
        let own = |p, part| if p == index { part } else { NO_TRIANGLE };
        self.intersect_mesh(mesh, Some(primitive), DVec3::ZERO, own, MeshQuery::Any, rays);
        let found = std::mem::take(&mut rays.found);
        for &(slot, _) in &found {
            let tinted = Cell::new(false);
            let blocked = opaque
                || rays.get(slot as usize).is_some_and(|ray| self.primitive_blocks(index, &ray, &tinted));
            rays.mark(slot as usize, blocked, tinted.get());
        }
        rays.found = found;
    }
}
