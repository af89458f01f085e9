//! Many rays through one mesh: made ready for its tree eight at a time.
//!
//! What comes out is that of [`TriangleMesh::intersect`] and [`TriangleMesh::occludes`], ray by ray.

use turner_bvh::lanes::{Block, Block32, F64x8, LANES, Mask8, Simd, Vec3x8, Work, dispatch};
use turner_bvh::{Hit, InstructionSet, RayBlock};

use super::mesh_search::{MeshSpace, PAD_STEPS};
use super::triangle_x8::{Corners, meet};
use super::{ShapeHit, TriangleMesh};
use crate::math::{DVec3, Ray};

/// Room for rays on their way through a mesh; kept from batch to batch.
#[derive(Default)]
pub struct MeshRays {
    rays: Vec<turner_bvh::Ray>,
    places: Vec<u32>,
    /// Hits up to here may lie before `t_min`, and from `certain` on beyond `t_max`.
    doubtful: Vec<f32>,
    certain: Vec<f32>,
    hits: Vec<Hit>,
    dark: Vec<bool>,
    met: Vec<HitBlock>,
}

/// What rays of one block meet, in double precision.
struct HitBlock {
    /// The number of the first of its hits.
    first: u32,
    /// Lanes with hits; those that count; and those that need a second look, one by one.
    hit: u8,
    met: u8,
    doubtful: u8,
    t: Block,
    u: Block,
    v: Block,
}

/// In place of a triangle's number.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Rays in blocks of eight, moved by a vector.
#[derive(Clone, Copy)]
pub struct BlockRays<'a, O> {
    /// What is taken from their origins.
    pub offset: DVec3,
    /// The rays.
    pub blocks: &'a [RayBlock],
    /// In place of their `t_max`: NaN for rays that are not asked about.
    pub ends: &'a [Block],
    /// The triangle that the ray at a place leaves, or [`NO_TRIANGLE`]: it does not meet it again.
    pub own: O,
}

impl<O: Fn(usize) -> u32> BlockRays<'_, O> {
    /// A ray, in the space of the mesh.
    #[inline]
    pub fn get(&self, place: usize) -> Ray {
        let (block, lane) = (&self.blocks[place / LANES], place % LANES);
        let vector = |v: &[Block; 3]| DVec3::new(v[0].0[lane], v[1].0[lane], v[2].0[lane]);
        Ray {
            t_min: block.t_min.0[lane],
            t_max: self.ends[place / LANES].0[lane],
            ..Ray::new(vector(&block.origin) - self.offset, vector(&block.direction))
        }
    }
}

impl TriangleMesh {
    /// Calls `found` with the place and the nearest hit of each ray that hits something.
    pub fn intersect_blocks<O: Fn(usize) -> u32>(
        &self,
        rays: &BlockRays<'_, O>,
        room: &mut MeshRays,
        mut found: impl FnMut(usize, ShapeHit),
    ) {
        room.collect(self.tree().instruction_set(), self.space(), rays);
        let MeshRays { rays: search, places, doubtful, hits, met, .. } = room;
        hits.clear();
        hits.resize(search.len(), Hit::MISS);
        let check = |i: u32, hit: &Hit| {
            let i = i as usize;
            let place = places[i] as usize;
            hit.t > doubtful[i] || (rays.own)(place) != hit.primitive && self.is_exact(&rays.get(place), hit)
        };
        self.tree().intersect_batch_filtered(search, hits, check);
        met.clear();
        dispatch(
            self.tree().instruction_set(),
            Finish {
                mesh: self,
                offset: rays.offset,
                blocks: rays.blocks,
                ends: rays.ends,
                places,
                hits,
                met,
            },
        );
        for block in met {
            let mut lanes = block.hit;
            let mut i = block.first as usize;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                while !hits[i].is_hit() {
                    i += 1;
                }
                let (hit, place) = (&hits[i], places[i] as usize);
                i += 1;
                if block.met >> lane & 1 == 1 {
                    let (t, u, v) = (block.t.0[lane], block.u.0[lane], block.v.0[lane]);
                    found(place, ShapeHit { t, part: hit.primitive, u, v });
                } else if block.doubtful >> lane & 1 == 1
                    && let Some(hit) = self.finish_ray(&rays.get(place), hit)
                {
                    found(place, hit);
                }
            }
        }
    }

    /// Calls `found` with the place of each ray that hits anything.
    pub fn occluded_blocks<O: Fn(usize) -> u32>(
        &self,
        rays: &BlockRays<'_, O>,
        room: &mut MeshRays,
        mut found: impl FnMut(usize),
    ) {
        room.collect(self.tree().instruction_set(), self.space(), rays);
        let MeshRays { rays: search, places, doubtful, certain, dark, .. } = room;
        dark.clear();
        dark.resize(search.len(), false);
        self.tree().occluded_batch_filtered(search, dark, |i, hit| {
            let i = i as usize;
            let place = places[i] as usize;
            hit.t > doubtful[i] && hit.t < certain[i]
                || (rays.own)(place) != hit.primitive && self.is_within(&rays.get(place), hit)
        });
        for (&dark, &place) in dark.iter().zip(&*places) {
            if dark {
                found(place as usize);
            }
        }
    }
}

impl MeshRays {
    /// Takes the rays that come near a mesh.
    fn collect<O>(&mut self, set: InstructionSet, space: &MeshSpace, rays: &BlockRays<'_, O>) {
        self.rays.clear();
        self.places.clear();
        self.doubtful.clear();
        self.certain.clear();
        if space.is_empty() {
            return;
        }
        let room = rays.blocks.len() * LANES;
        self.rays.reserve(room);
        self.places.reserve(room);
        self.doubtful.reserve(room);
        self.certain.reserve(room);
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

    /// As [`MeshSpace::ray`], operation by operation.
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
            let beside = o + direction * nearest;
            let met: Mask8<S> = inv.gt(splat(0.0))
                & inv.lt(splat(f64::INFINITY))
                & beside.dot(beside).le(reach * reach)
                & start.le(nearest + two * reach)
                & t_max.eq(t_max);
            let mut met = met.bits();
            if met == 0 {
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
            let [px, py, pz, dx, dy, dz, t_max, doubtful, certain] = &out;
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                to.rays.push(turner_bvh::Ray {
                    origin: [px.0[lane], py.0[lane], pz.0[lane]],
                    direction: [dx.0[lane], dy.0[lane], dz.0[lane]],
                    t_min: 0.0,
                    t_max: t_max.0[lane],
                });
                to.places.push((i * LANES + lane) as u32);
                to.doubtful.push(doubtful.0[lane]);
                to.certain.push(certain.0[lane]);
            }
        }
    }
}

/// As [`TriangleMesh::finish_ray`] begins, operation by operation.
struct Finish<'a> {
    mesh: &'a TriangleMesh,
    offset: DVec3,
    blocks: &'a [RayBlock],
    ends: &'a [Block],
    places: &'a [u32],
    hits: &'a [Hit],
    met: &'a mut Vec<HitBlock>,
}

impl Work for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Finish { mesh, blocks, ends, places, hits, met, .. } = self;
        let offset = Vec3x8::splat(simd, self.offset.to_array());
        let mut corners: Corners = Default::default();
        let mut first = 0;
        while first < hits.len() {
            let index = places[first] as usize / LANES;
            let mut hit = 0u8;
            let mut next = first;
            while next < hits.len() && places[next] as usize / LANES == index {
                if hits[next].is_hit() {
                    let lane = places[next] as usize % LANES;
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
                let hits = meet(simd, origin, Vec3x8::load(simd, &block.direction), &corners);
                let counts = hits.met & hits.t.ge(F64x8::load(simd, &block.t_min));
                let ends_after = hits.t.le(F64x8::load(simd, &ends[index]));
                let mut out = HitBlock {
                    first: first as u32,
                    hit,
                    met: (counts & ends_after).bits() & hit,
                    doubtful: hit & !counts.bits(),
                    t: Block::default(),
                    u: Block::default(),
                    v: Block::default(),
                };
                hits.t.store(&mut out.t);
                hits.u.store(&mut out.u);
                hits.v.store(&mut out.v);
                met.push(out);
            }
            first = next;
        }
    }
}
