//! Many rays through meshes: each mesh once for all of them.

use std::cell::Cell;

use turner_bvh::lanes::LANES;

use crate::math::DVec3;
use crate::scene::alpha_test::NO_FACES;
use crate::scene::ray_batch::RayBatch;
use crate::scene::scene::{NO_TRANSFORM, Primitive};
use crate::scene::world_mesh::StaticWorldMesh;
use crate::scene::{Hit, Scene};
use crate::shape::{BlockRays, NO_TRIANGLE, Shape, ShapeHit, TriangleMesh};

/// What is asked about rays and a mesh.
#[derive(Clone, Copy)]
enum MeshQuery {
    /// The nearest hit of each.
    Nearest,
    /// Whether there is one.
    Any,
}

impl Scene {
    /// Takes the hits of meshes that are nearer than those so far.
    pub(crate) fn through_meshes(&self, meshes: &[u32], rays: &mut RayBatch, hits: &mut [Option<Hit>]) {
        rays.end_at(hits);
        if let Some(world_mesh) = &self.world_mesh {
            let own = |p, part| world_mesh.triangle(p, part);
            self.through_mesh(world_mesh.mesh(), None, world_mesh.offset(), own, MeshQuery::Nearest, rays);
            let found = std::mem::take(&mut rays.found);
            for &(place, found) in &found {
                let mut hit = world_mesh.owned(&found);
                if world_mesh.is_checked() {
                    let Some(ray) = rays.get_to_end(place) else { continue };
                    if !self.world_mesh_hit_counts(&ray, &hit) {
                        match self.intersect_world_mesh_behind(world_mesh, &ray) {
                            Some(behind) => hit = behind,
                            None => continue,
                        }
                    }
                }
                let mut end = rays.end(place);
                self.keep_nearer_before(hit, &mut end, &mut hits[place as usize]);
                rays.end_ray(place, end);
            }
            rays.found = found;
        }
        for &index in meshes {
            let primitive = &self.primitives[index as usize];
            let Shape::Mesh(mesh) = &primitive.shape else { continue };
            let own = |p, part| if p == index { part } else { NO_TRIANGLE };
            self.through_mesh(mesh, Some(primitive), DVec3::ZERO, own, MeshQuery::Nearest, rays);
            let checked = primitive.faces != NO_FACES && self.faces[primitive.faces as usize].are_checked();
            let found = std::mem::take(&mut rays.found);
            for &(place, mut found) in &found {
                let Some(mut ray) = rays.get_to_end(place) else { continue };
                if checked && !self.is_there(primitive, &self.to_object(primitive, &ray), &found) {
                    // Something is behind the hole, perhaps.
                    match self.intersect_faces(primitive, &ray) {
                        Some(hit) => found = hit,
                        None => continue,
                    }
                }
                self.keep_nearer(index, found, &mut ray, &mut hits[place as usize]);
                rays.end_ray(place, ray.t_max);
            }
            rays.found = found;
        }
    }

    /// Finds the hits of a mesh that are not beyond the ends; with `Asked::Any` only which rays have one.
    fn through_mesh(
        &self,
        mesh: &TriangleMesh,
        primitive: Option<&Primitive>,
        offset: DVec3,
        own: impl Fn(u32, u32) -> u32,
        asked: MeshQuery,
        rays: &mut RayBatch,
    ) {
        self.move_to(primitive, rays);
        rays.found.clear();
        let used = rays.len.div_ceil(LANES);
        let RayBatch { blocks, moved, ends, from, room, found, .. } = rays;
        let blocks = if self.is_moved(primitive) { &moved[..] } else { &blocks[..used] };
        let own = |place: usize| from.get(place).map_or(NO_TRIANGLE, |o| own(o.primitive, o.part));
        let searched = BlockRays { offset, blocks, ends, own };
        match asked {
            MeshQuery::Nearest => {
                mesh.intersect_blocks(&searched, room, |place, hit| found.push((place as u32, hit)))
            }
            MeshQuery::Any => {
                let hit = ShapeHit { t: 0.0, part: 0, u: 0.0, v: 0.0 };
                mesh.occluded_blocks(&searched, room, |place| found.push((place as u32, hit)));
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

    /// Marks rays that the gathered meshes stop or tint, besides those that are stopped already.
    pub(crate) fn behind_world_mesh(&self, world_mesh: &StaticWorldMesh, rays: &mut RayBatch) {
        rays.end_unblocked();
        // Where not all are opaque, the nearest triangle decides for most rays.
        let asked = if world_mesh.is_opaque() { MeshQuery::Any } else { MeshQuery::Nearest };
        self.through_mesh(
            world_mesh.mesh(),
            None,
            world_mesh.offset(),
            |p, i| world_mesh.triangle(p, i),
            asked,
            rays,
        );
        let found = std::mem::take(&mut rays.found);
        for &(place, hit) in &found {
            let tinted = Cell::new(false);
            let blocked = world_mesh.is_opaque()
                || rays.get(place as usize).is_some_and(|ray| {
                    self.world_mesh_stops(&ray, &world_mesh.owned(&hit), &tinted)
                        || self.world_mesh_blocks(world_mesh, &ray, &tinted)
                });
            rays.note(place as usize, blocked, tinted.get());
        }
        rays.found = found;
    }

    /// The same for a mesh of its own, `opaque` or not.
    pub(crate) fn behind_single(&self, index: u32, opaque: bool, rays: &mut RayBatch) {
        let primitive = &self.primitives[index as usize];
        let Shape::Mesh(mesh) = &primitive.shape else { return };
        rays.end_unblocked();
        let own = |p, part| if p == index { part } else { NO_TRIANGLE };
        self.through_mesh(mesh, Some(primitive), DVec3::ZERO, own, MeshQuery::Any, rays);
        let found = std::mem::take(&mut rays.found);
        for &(place, _) in &found {
            let tinted = Cell::new(false);
            let blocked = opaque
                || rays.get(place as usize).is_some_and(|ray| self.primitive_blocks(index, &ray, &tinted));
            rays.note(place as usize, blocked, tinted.get());
        }
        rays.found = found;
    }
}
