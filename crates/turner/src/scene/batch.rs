//! Intersection of ray batches. Every result equals that of [`Scene::intersect`] and [`Scene::transmittance`] for the
//! ray alone.
//!
//! ```text
//!   nearest hit:  spheres → planes → rectangles → rest → meshes → BVH
//!                 each pass shortens the rays, so later passes skip what lies behind
//!   shadow rays:  opaque shapes first (they block without a lookup of the material), then shapes with
//!                 cut-outs or tints; rays that only tinted shapes attenuate are traced once more in order
//! ```
//!
//! Spheres, planes and rectangles in world space ([`Shape::in_world`]) are tested eight rays at a time. A mesh is traversed once by
//! all rays, which keeps its nodes in cache. The rest is tested ray by ray. Ties are broken by primitive ID in every
//! pass, so the order of the passes does not matter.

use std::cell::Cell;

use turner_bvh::Spheres;
use turner_bvh::lanes::{Block32, LANES};

use crate::material::{Material, ShadowKind};
use crate::math::Ray;
use crate::scene::alpha_test::{Faces, NO_FACES};
use crate::scene::planes::crossings;
use crate::scene::ray_batch::RayBatch;
use crate::scene::rectangles::BatchRectangle;
use crate::scene::scene::{Bits, NO_TRANSFORM, ObjectTransform, Primitive};
use crate::scene::spectrum_block::SpectrumBlock;
use crate::scene::{Hit, Scene};
use crate::shape::{Plane, Shape, ShapeHit};

/// The shapes of a scene, sorted by how batches test them.
#[derive(Clone, Debug, Default)]
pub(crate) struct BatchShapes {
    /// Spheres in world space, in the order of their IDs.
    spheres: Spheres,
    /// Primitive indices of the spheres.
    primitives: Vec<u32>,
    /// Spheres with an opaque shadow.
    opaque: Spheres,
    /// Planes in world space, with their primitive indices.
    planes: Vec<(Plane, u32)>,
    /// Planes with an opaque shadow.
    opaque_planes: Vec<Plane>,
    /// Rectangles in world space.
    rectangles: Vec<BatchRectangle>,
    /// Rectangles with an opaque shadow.
    opaque_rectangles: Vec<BatchRectangle>,
    /// Primitives in none of these lists.
    rest: Rest,
    /// Primitives that cast a shadow and are in none of the opaque lists.
    shadow_rest: Rest,
    /// Meshes, traversed by all rays together.
    meshes: Vec<u32>,
    /// Meshes with an opaque shadow.
    opaque_meshes: Vec<u32>,
    /// Meshes with another shadow: all rays traverse them together, and rays with a hit are then traced alone.
    transparent_meshes: Vec<u32>,
    /// Whether the other bounded primitives are in a BVH.
    tree: bool,
}

/// Primitives that are tested ray by ray.
#[derive(Clone, Debug, Default)]
struct Rest {
    /// Primitives that are always tested.
    always: Vec<u32>,
    /// Bits of the primitives that the sphere culler can exclude.
    culled: u64,
}

impl Rest {
    fn add(&mut self, index: usize, bounded: usize) {
        if index < bounded { self.culled |= 1 << index } else { self.always.push(index as u32) }
    }

    #[inline]
    fn is_empty(&self) -> bool {
        self.always.is_empty() && self.culled == 0
    }
}

impl BatchShapes {
    /// The first `bounded` primitives, at most 64, are in the sphere culler; or the first `in_tree` are in the BVH
    /// and are omitted here.
    pub(crate) fn new(
        primitives: &[Primitive],
        bounded: usize,
        in_tree: usize,
        materials: &[Material],
        transforms: &[ObjectTransform],
        faces: &[Faces],
    ) -> BatchShapes {
        let mut shapes = BatchShapes { tree: in_tree > 0, ..BatchShapes::default() };
        for (i, primitive) in primitives.iter().enumerate().skip(in_tree) {
            let shadow = materials[primitive.material.index()].shadow();
            let one_sided = faces.get(primitive.faces as usize).map(Faces::are_only_one_sided);
            // The shape in world space; with faces, hits of a shape with a transform are tested in object space.
            let shape = match (primitive.transform, one_sided) {
                (NO_TRANSFORM, _) => Some(&primitive.shape),
                (i, None) => transforms[i as usize].in_world.as_deref(),
                (_, Some(_)) => None,
            };
            let sphere = match shape {
                Some(Shape::Sphere(s)) if one_sided.is_none() => Some(s),
                _ => None,
            };
            let plane = match shape {
                Some(Shape::Plane(p)) if one_sided.is_none() => Some(p),
                _ => None,
            };
            let rectangle = match shape {
                Some(Shape::Rectangle(r)) if one_sided != Some(false) => {
                    Some(BatchRectangle::new(r, i as u32, one_sided.is_some()))
                }
                _ => None,
            };
            if let Some(r) = rectangle {
                match shadow {
                    ShadowKind::None => {}
                    ShadowKind::Opaque => shapes.opaque_rectangles.push(r.clone()),
                    ShadowKind::Tinted => shapes.shadow_rest.add(i, bounded),
                }
                shapes.rectangles.push(r);
                continue;
            }
            let is_mesh = matches!(primitive.shape, Shape::Mesh(_));
            match sphere {
                Some(s) => {
                    shapes.spheres.push(s.center.to_array(), s.radius);
                    shapes.primitives.push(i as u32);
                }
                None if is_mesh => shapes.meshes.push(i as u32),
                None if let Some(p) = plane => shapes.planes.push((*p, i as u32)),
                None => shapes.rest.add(i, bounded),
            }
            // With several materials, each has its own shadow.
            let own =
                (primitive.faces != NO_FACES).then(|| faces[primitive.faces as usize].are_opaque(materials));
            match (sphere, own, shadow) {
                (_, Some(true), _) | (None, None, ShadowKind::Opaque) if is_mesh => {
                    shapes.opaque_meshes.push(i as u32);
                }
                (_, None, ShadowKind::None) => {}
                _ if is_mesh => shapes.transparent_meshes.push(i as u32),
                (Some(s), None, ShadowKind::Opaque) => shapes.opaque.push(s.center.to_array(), s.radius),
                _ => match plane {
                    Some(p) if shadow == ShadowKind::Opaque => shapes.opaque_planes.push(*p),
                    _ => shapes.shadow_rest.add(i, bounded),
                },
            }
        }
        shapes
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> usize {
        self.spheres.bytes() + self.opaque.bytes() + self.primitives.len() * size_of::<u32>()
    }
}

impl Scene {
    /// For each ray the result of [`Scene::intersect`]; `None` for empty slots. Replaces the contents of `hits`.
    pub fn intersect_batch(&self, rays: &mut RayBatch, hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.reserve(rays.len);
        let shapes = &self.batch;
        let used = rays.len.div_ceil(LANES);
        if shapes.spheres.is_empty() {
            hits.resize(rays.len, None);
        } else {
            self.intersect_spheres(rays, hits);
        }
        for (plane, index) in &shapes.planes {
            for (i, block) in rays.blocks[..used].iter().enumerate() {
                let (t, crossed) = crossings(plane, block);
                for lane in Bits(u64::from(crossed)).map(|lane| lane as usize) {
                    let slot = i * LANES + lane;
                    let (Some(hit), Some(mut ray)) = (hits.get_mut(slot), rays.get(slot)) else { continue };
                    if let Some(hit) = hit {
                        ray.t_max = hit.shape.t;
                    }
                    if t[lane] <= ray.t_max && ray.at(t[lane]).is_finite() {
                        let found = ShapeHit { t: t[lane], part: 0, u: 0.0, v: 0.0 };
                        self.keep_nearer(*index, found, &mut ray, hit);
                    }
                }
            }
        }
        // Whether the ends of the rays are those of the hits so far.
        let mut are_ended = false;
        if !shapes.rectangles.is_empty() {
            rays.end_at(hits);
            are_ended = shapes.rest.is_empty();
            for rectangle in &shapes.rectangles {
                let mut found = std::mem::take(&mut rays.found);
                found.clear();
                rectangle.intersect(self.instruction_set, &rays.blocks[..used], &rays.ends, |slot, hit| {
                    found.push((slot as u32, hit));
                });
                for &(slot, shape) in &found {
                    let mut end = rays.end(slot);
                    let hit = Hit { shape, primitive: rectangle.index };
                    self.keep_nearer_before(hit, &mut end, &mut hits[slot as usize]);
                    rays.end_ray(slot, end);
                }
                rays.found = found;
            }
        }
        if !shapes.rest.is_empty() {
            for (i, hit) in hits.iter_mut().enumerate() {
                let Some(mut ray) = rays.get(i) else { continue };
                if let Some(hit) = hit {
                    ray.t_max = hit.shape.t;
                }
                let search = ray;
                self.any_of(&shapes.rest, &search, |i| {
                    self.try_primitive(i, &mut ray, hit);
                    false
                });
            }
        }
        if !shapes.meshes.is_empty() || self.world_mesh.is_some() {
            if !are_ended {
                rays.end_at(hits);
            }
            self.intersect_meshes(&shapes.meshes, rays, hits);
        }
        if shapes.tree {
            for (i, hit) in hits.iter_mut().enumerate() {
                let Some(mut ray) = rays.get(i) else { continue };
                if let Some(hit) = hit {
                    ray.t_max = hit.shape.t;
                }
                self.intersect_bounded(&mut ray, hit);
            }
        }
    }

    /// Fills the empty `hits` with the nearest hits on spheres.
    fn intersect_spheres(&self, rays: &mut RayBatch, hits: &mut Vec<Option<Hit>>) {
        let shapes = &self.batch;
        let used = rays.len.div_ceil(LANES);
        shapes.spheres.closest(self.instruction_set, &rays.blocks[..used], &mut rays.nearest);
        for (i, nearest) in rays.nearest.iter().enumerate() {
            let lanes = LANES.min(rays.len - i * LANES);
            hits.extend((0..lanes).map(|lane| {
                let sphere = nearest.sphere.0[lane];
                (sphere >= 0.0).then(|| Hit {
                    shape: ShapeHit { t: nearest.t.0[lane], part: 0, u: 0.0, v: 0.0 },
                    primitive: shapes.primitives[sphere as usize],
                })
            }));
        }
    }

    /// For each ray the result of [`Scene::transmittance`]; empty slots hold any value. Replaces the contents of
    /// `through`.
    pub fn transmittance_batch(&self, rays: &mut RayBatch, through: &mut Vec<SpectrumBlock>) {
        through.clear();
        let shapes = &self.batch;
        let used = rays.len.div_ceil(LANES);
        shapes.opaque.any(self.instruction_set, &rays.blocks[..used], &mut rays.blocked);
        rays.tinted.clear();
        rays.tinted.resize(used, 0);
        for plane in &shapes.opaque_planes {
            for (i, blocked) in rays.blocked.iter_mut().enumerate() {
                let (t, crossed) = crossings(plane, &rays.blocks[i]);
                for lane in Bits(u64::from(crossed & !*blocked)) {
                    let (block, lane) = (&rays.blocks[i], lane as usize);
                    let at =
                        |axis: usize| block.origin[axis].0[lane] + t[lane] * block.direction[axis].0[lane];
                    let finite = (0..3).all(|axis| at(axis).is_finite());
                    *blocked |= u8::from(finite) << lane;
                }
            }
        }
        if !shapes.opaque_rectangles.is_empty() {
            rays.end_unblocked();
            let RayBatch { blocks, ends, blocked, .. } = &mut *rays;
            for rectangle in &shapes.opaque_rectangles {
                rectangle.intersect(self.instruction_set, &blocks[..used], ends, |slot, _| {
                    blocked[slot / LANES] |= 1 << (slot % LANES);
                });
            }
        }
        if let Some(world_mesh) = &self.world_mesh {
            self.occlude_by_world_mesh(world_mesh, rays);
        }
        for &index in &shapes.opaque_meshes {
            self.occlude_by_mesh(index, true, rays);
        }
        for &index in &shapes.transparent_meshes {
            self.occlude_by_mesh(index, false, rays);
        }
        if !shapes.shadow_rest.is_empty() || shapes.tree {
            for i in 0..rays.len {
                if rays.blocked[i / LANES] >> (i % LANES) & 1 == 1 {
                    continue;
                }
                let Some(ray) = rays.get(i) else { continue };
                let tinted = Cell::new(false);
                let blocked = self
                    .any_of(&shapes.shadow_rest, &ray, |i| self.primitive_blocks(i, &ray, &tinted))
                    || shapes.tree && self.bounded_block(&ray, &tinted);
                rays.mark(i, blocked, tinted.get());
            }
        }
        through.extend(rays.blocked.iter().map(|blocked| {
            let lanes = std::array::from_fn(|lane| if blocked >> lane & 1 == 1 { 0.0 } else { 1.0 });
            SpectrumBlock([Block32(lanes); 3])
        }));
        for (i, through) in through.iter_mut().enumerate() {
            let tinted = rays.tinted[i] & !rays.blocked[i];
            for lane in (0..LANES).filter(|lane| tinted >> lane & 1 == 1) {
                if let Some(ray) = rays.get(i * LANES + lane) {
                    through.set(lane, self.tinted_transmittance(&ray));
                }
            }
        }
    }

    /// Whether `test` is true for any of the primitives that the ray may hit; stops at the first.
    #[inline]
    fn any_of(&self, rest: &Rest, ray: &Ray, mut test: impl FnMut(u32) -> bool) -> bool {
        if rest.always.iter().any(|i| test(*i)) {
            return true;
        }
        let (Some(culler), true) = (&self.culler, rest.culled != 0) else { return false };
        let Some(search) = self.frame.ray(ray) else { return false };
        Bits(culler.candidates(&search.ray) & rest.culled).any(test)
    }
}

#[cfg(test)]
#[path = "batch_tests.rs"]
mod tests;
