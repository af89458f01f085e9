//! Batches of rays through one mesh, eight at a time.
//!
//! The results are those of [`TriangleMesh::intersect`] and [`TriangleMesh::occludes`] for each ray, bit for bit:
//!
//! 1. `Collect` converts blocks of eight f64 rays to the tree's f32 space, as [`MeshSpace::ray`] does, and
//!    drops rays that miss the mesh's bounding sphere.
//! 2. The tree finds, in f32, which triangle each ray hits.
//! 3. `Finish` computes in f64 where the ray hits that triangle, as `TriangleMesh::finish_ray` does.
//! 4. Hits that f64 does not confirm, because they lie within rounding of an edge or of `t_min`, are redone one
//!    ray at a time by `TriangleMesh::finish_ray`.

use turner_bvh::lanes::{Block, Block32, F64x8, LANES, Mask8, Simd, Vec3x8, Work, dispatch};
use turner_bvh::{Hit, InstructionSet, RayBlock};

use super::mesh_search::{MeshSpace, PAD_STEPS};
use super::triangle_x8::{Corners, intersect_triangles};
use super::{ShapeHit, TriangleMesh};
use crate::math::{DVec3, Ray};

/// Scratch memory for rays through meshes; reused from batch to batch.
#[derive(Default)]
pub struct MeshRays {
    rays: Vec<turner_bvh::Ray>,
    slots: Vec<u32>,
    /// Hits with t in (`safe_min`, `safe_max`) are within the ray's range in f64, too; others may not be.
    safe_min: Vec<f32>,
    safe_max: Vec<f32>,
    hits: Vec<Hit>,
    occluded: Vec<bool>,
    hit_blocks: Vec<HitBlock>,
}

/// Hits of one block of rays in double precision.
struct HitBlock {
    /// Index of the block's first search ray.
    first: u32,
    /// Lane masks: hits of the tree; hits confirmed in f64; hits to check again one by one.
    hit: u8,
    confirmed: u8,
    recheck: u8,
    t: Block,
    u: Block,
    v: Block,
}

/// Stands for "no triangle".
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Rays in blocks of eight, translated by a vector.
#[derive(Clone, Copy)]
pub struct BlockRays<'a, O> {
    /// Subtracted from the origins.
    pub offset: DVec3,
    /// The rays.
    pub blocks: &'a [RayBlock],
    /// Replaces the rays' `t_max`; NaN for rays to ignore.
    pub ends: &'a [Block],
    /// The triangles that the ray in a slot starts on and ends before, or [`NO_TRIANGLE`]. The ray cannot hit them.
    pub skipped: O,
}

impl<O: Fn(usize) -> [u32; 2]> BlockRays<'_, O> {
    /// The ray in a slot, in the space of the mesh.
    #[inline]
    pub fn get(&self, slot: usize) -> Ray {
        let (block, lane) = (&self.blocks[slot / LANES], slot % LANES);
        let vector = |v: &[Block; 3]| DVec3::new(v[0].0[lane], v[1].0[lane], v[2].0[lane]);
        Ray {
            t_min: block.t_min.0[lane],
            t_max: self.ends[slot / LANES].0[lane],
            ..Ray::new(vector(&block.origin) - self.offset, vector(&block.direction))
        }
    }
}

impl TriangleMesh {
    /// Calls `found` with the slot and the nearest hit of each ray that hits something.
    pub fn intersect_blocks<O: Fn(usize) -> [u32; 2]>(
        &self,
        rays: &BlockRays<'_, O>,
        scratch: &mut MeshRays,
        mut found: impl FnMut(usize, ShapeHit),
    ) {
        scratch.collect(self.tree().instruction_set(), self.space(), rays);
        let MeshRays { rays: search, slots, safe_min, hits, hit_blocks, .. } = scratch;
        hits.clear();
        hits.resize(search.len(), Hit::MISS);
        let check = |i: u32, hit: &Hit| {
            let i = i as usize;
            let slot = slots[i] as usize;
            hit.t > safe_min[i]
                || !(rays.skipped)(slot).contains(&hit.primitive) && self.is_exact(&rays.get(slot), hit)
        };
        self.tree().intersect_batch_filtered(search, hits, check);
        hit_blocks.clear();
        dispatch(
            self.tree().instruction_set(),
            Finish {
                mesh: self,
                offset: rays.offset,
                blocks: rays.blocks,
                ends: rays.ends,
                slots,
                hits,
                hit_blocks,
            },
        );
        for block in hit_blocks {
            let mut lanes = block.hit;
            let mut i = block.first as usize;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                while !hits[i].is_hit() {
                    i += 1;
                }
                let (hit, slot) = (&hits[i], slots[i] as usize);
                i += 1;
                if block.confirmed >> lane & 1 == 1 {
                    let (t, u, v) = (block.t.0[lane], block.u.0[lane], block.v.0[lane]);
                    found(slot, ShapeHit { t, part: hit.primitive, u, v });
                } else if block.recheck >> lane & 1 == 1
                    && let Some(hit) = self.finish_ray(&rays.get(slot), hit)
                {
                    found(slot, hit);
                }
            }
        }
    }

    /// Calls `found` with the slot of each ray that hits anything.
    pub fn occluded_blocks<O: Fn(usize) -> [u32; 2]>(
        &self,
        rays: &BlockRays<'_, O>,
        scratch: &mut MeshRays,
        mut found: impl FnMut(usize),
    ) {
        scratch.collect(self.tree().instruction_set(), self.space(), rays);
        let MeshRays { rays: search, slots, safe_min, safe_max, occluded, .. } = scratch;
        occluded.clear();
        occluded.resize(search.len(), false);
        self.tree().occluded_batch_filtered(search, occluded, |i, hit| {
            let i = i as usize;
            let slot = slots[i] as usize;
            hit.t > safe_min[i] && hit.t < safe_max[i]
                || !(rays.skipped)(slot).contains(&hit.primitive) && self.is_within(&rays.get(slot), hit)
        });
        for (&occluded, &slot) in occluded.iter().zip(&*slots) {
            if occluded {
                found(slot as usize);
            }
        }
    }
}

impl MeshRays {
    /// Collects the rays that pass the bounding sphere of a mesh.
    fn collect<O>(&mut self, set: InstructionSet, space: &MeshSpace, rays: &BlockRays<'_, O>) {
        self.rays.clear();
        self.slots.clear();
        self.safe_min.clear();
        self.safe_max.clear();
        if space.is_empty() {
            return;
        }
        let count = rays.blocks.len() * LANES;
        self.rays.reserve(count);
        self.slots.reserve(count);
        self.safe_min.reserve(count);
        self.safe_max.reserve(count);
        let &BlockRays { offset, blocks, ends, .. } = rays;
        dispatch(set, Collect { to: self, space, offset, blocks, ends });
    }
}

struct Collect<'a> {
    to: &'a mut MeshRays,
    space: &'a MeshSpace,
    offset: DVec3,
    blocks: &'a [RayBlock],
    ends: &'a [Block],
}

impl Work for Collect<'_> {
    type Output = ();

    /// The same operations as [`MeshSpace::ray`], in the same order.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Collect { to, space, .. } = self;
        let splat = |v: f64| F64x8::splat(simd, v);
        let vector = |v: DVec3| Vec3x8::splat(simd, v.to_array());
        let (offset, center, back) =
            (vector(self.offset), vector(space.center()), vector(space.center() - space.shift()));
        let moved = self.offset != DVec3::ZERO;
        let (pad, reach) = (splat(space.pad()), splat(space.reach()));
        let two = splat(2.0);
        let mut out = [[0.0; LANES]; 9].map(Block32);
        for (i, (block, end)) in self.blocks.iter().zip(self.ends).enumerate() {
            let mut origin = Vec3x8::load(simd, &block.origin);
            if moved {
                origin = origin - offset;
            }
            let direction = Vec3x8::load(simd, &block.direction);
            let (t_min, t_max) = (F64x8::load(simd, &block.t_min), F64x8::load(simd, end));
            let o = origin - center;
            let speed = direction.dot(direction).sqrt();
            let inv = splat(1.0) / speed;
            let direction = direction * inv;
            let nearest = -o.dot(direction);
            let first = t_min * speed;
            let begin = nearest - two * reach;
            let start = first - two * pad;
            let start = begin.gt(start).select(begin, start);
            let closest = o + direction * nearest;
            let near_sphere: Mask8<S> = inv.gt(splat(0.0))
                & inv.lt(splat(f64::INFINITY))
                & closest.dot(closest).le(reach * reach)
                & start.le(nearest + two * reach)
                & t_max.eq(t_max);
            let mut lanes = near_sphere.bits();
            if lanes == 0 {
                continue;
            }
            let rounding = splat(1e-10) * pad + splat(4.0 * f64::EPSILON) * nearest.abs();
            let pad = pad + rounding;
            let p = o + direction * start + back;
            let last = t_max * speed - start;
            let parts = [
                p.x,
                p.y,
                p.z,
                direction.x,
                direction.y,
                direction.z,
                last + two * pad,
                first - start + two * pad,
                last - splat(PAD_STEPS) * pad,
            ];
            for (out, part) in out.iter_mut().zip(parts) {
                part.narrow().store(out);
            }
            let [px, py, pz, dx, dy, dz, t_max, safe_min, safe_max] = &out;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                to.rays.push(turner_bvh::Ray {
                    origin: [px.0[lane], py.0[lane], pz.0[lane]],
                    direction: [dx.0[lane], dy.0[lane], dz.0[lane]],
                    t_min: 0.0,
                    t_max: t_max.0[lane],
                });
                to.slots.push((i * LANES + lane) as u32);
                to.safe_min.push(safe_min.0[lane]);
                to.safe_max.push(safe_max.0[lane]);
            }
        }
    }
}

/// The same operations as the first half of [`TriangleMesh::finish_ray`], in the same order.
struct Finish<'a> {
    mesh: &'a TriangleMesh,
    offset: DVec3,
    blocks: &'a [RayBlock],
    ends: &'a [Block],
    slots: &'a [u32],
    hits: &'a [Hit],
    hit_blocks: &'a mut Vec<HitBlock>,
}

impl Work for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Finish { mesh, blocks, ends, slots, hits, hit_blocks, .. } = self;
        let offset = Vec3x8::splat(simd, self.offset.to_array());
        let mut corners: Corners = Default::default();
        let mut first = 0;
        while first < hits.len() {
            let index = slots[first] as usize / LANES;
            let mut hit = 0u8;
            let mut next = first;
            while next < hits.len() && slots[next] as usize / LANES == index {
                if hits[next].is_hit() {
                    let lane = slots[next] as usize % LANES;
                    hit |= 1 << lane;
                    for (to, corner) in corners.iter_mut().zip(mesh.corners(hits[next].primitive)) {
                        for (to, v) in to.iter_mut().zip(corner) {
                            to.0[lane] = v;
                        }
                    }
                }
                next += 1;
            }
            if hit != 0 {
                let block = &blocks[index];
                let origin = Vec3x8::load(simd, &block.origin) - offset;
                let hits = intersect_triangles(simd, origin, Vec3x8::load(simd, &block.direction), &corners);
                let counts = hits.hit & hits.t.ge(F64x8::load(simd, &block.t_min));
                let ends_after = hits.t.le(F64x8::load(simd, &ends[index]));
                let mut out = HitBlock {
                    first: first as u32,
                    hit,
                    confirmed: (counts & ends_after).bits() & hit,
                    recheck: hit & !counts.bits(),
                    t: Block::default(),
                    u: Block::default(),
                    v: Block::default(),
                };
                hits.t.store(&mut out.t);
                hits.u.store(&mut out.u);
                hits.v.store(&mut out.v);
                hit_blocks.push(out);
            }
            first = next;
        }
    }
}
