//! Rays in blocks of eight, with what they left and room to work on them.

use turner_bvh::lanes::{Block, LANES};
use turner_bvh::{NearestBlock, RayBlock};

use crate::math::{DVec3, Ray};
use crate::scene::scene::{Bits, ObjectTransform};
use crate::scene::{Hit, SurfaceInteraction};
use crate::shape::{MeshRays, ShapeHit};

/// Rays in blocks of eight, and room to work on them. Blocks are kept when they are taken out: what an empty place
/// holds beside a `t_max` of NaN is of no account.
#[derive(Default)]
pub struct RayBatch {
    pub(crate) blocks: Vec<RayBlock>,
    /// Their moments, if anything moves; those beyond the end are 0.
    times: Vec<f32>,
    /// Places of which some may be empty: those of the first `used()` blocks, but for the end of the last one.
    pub(crate) len: usize,
    /// The primitive and the part of it that each ray leaves: it does not meet a flat one again. Empty if no ray says so.
    pub(crate) from: Vec<RayOrigin>,
    pub(crate) nearest: Vec<NearestBlock>,
    pub(crate) blocked: Vec<u8>,
    /// Those that something tinted is before.
    pub(crate) tinted: Vec<u8>,
    /// For meshes: how far each ray goes, and the rays in an object's space.
    pub(crate) ends: Vec<Block>,
    pub(crate) moved: Vec<RayBlock>,
    pub(crate) room: MeshRays,
    pub(crate) found: Vec<(u32, ShapeHit)>,
}

/// The primitive that a ray leaves, and the part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayOrigin {
    pub(crate) primitive: u32,
    pub(crate) part: u32,
}

impl RayOrigin {
    const NOWHERE: RayOrigin = RayOrigin { primitive: u32::MAX, part: 0 };
}

impl Hit {
    /// What a ray leaves that begins here.
    #[inline]
    pub fn origin(&self) -> RayOrigin {
        RayOrigin { primitive: self.primitive, part: self.shape.part }
    }
}

impl RayBatch {
    /// Takes all rays out.
    pub fn clear(&mut self) {
        self.len = 0;
        self.from.clear();
        self.times.clear();
    }

    /// How many places for rays there are; some may be empty.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Adds a ray, without its moment: see [`RayBatch::set_time`].
    #[inline]
    pub fn push(&mut self, ray: &Ray) {
        let lane = self.len % LANES;
        let block = if lane == 0 { self.add_block(1) } else { self.last_block() };
        block.set(lane, ray.origin.to_array(), ray.direction.to_array(), ray.t_min, ray.t_max);
        if lane != 0 {
            self.len += 1;
        }
    }

    /// Adds a ray that leaves a surface. What it hits is the same as if that were not known, but found sooner.
    #[inline]
    pub fn push_from(&mut self, ray: &Ray, surface: &SurfaceInteraction) {
        self.push_leaving(ray, surface.hit.origin());
    }

    /// The same for what [`Hit::origin`] says of the surface.
    #[inline]
    pub fn push_leaving(&mut self, ray: &Ray, from: RayOrigin) {
        self.push(ray);
        if self.from.len() + 1 < self.len {
            self.from.resize(self.len - 1, RayOrigin::NOWHERE);
        }
        self.from.push(from);
    }

    /// Adds `count` places, at most eight, to be filled by the caller; all of the block's are empty. What was pushed
    /// before must have filled its block.
    #[inline]
    pub fn add_block(&mut self, count: usize) -> &mut RayBlock {
        debug_assert!(self.len.is_multiple_of(LANES) && count <= LANES);
        let index = self.len / LANES;
        if index == self.blocks.len() {
            self.blocks.push(RayBlock::NOTHING);
        }
        self.len += count;
        let block = &mut self.blocks[index];
        block.t_max.0 = [f64::NAN; LANES];
        block
    }

    /// Empties the place of a ray.
    pub fn remove(&mut self, i: usize) {
        if let Some(block) = self.blocks.get_mut(i / LANES) {
            block.t_max.0[i % LANES] = f64::NAN;
        }
    }

    #[inline]
    fn last_block(&mut self) -> &mut RayBlock {
        let index = self.len / LANES;
        &mut self.blocks[index]
    }

    /// Takes over the rays of another batch.
    pub fn copy(&mut self, other: &RayBatch) {
        self.blocks.clear();
        self.blocks.extend_from_slice(other.blocks());
        self.len = other.len;
        self.from.clone_from(&other.from);
        self.times.clone_from(&other.times);
    }

    /// Sets the moment of the ray at a place; those of rays before it that have none are 0.
    pub fn set_time(&mut self, i: usize, time: f32) {
        if self.times.len() <= i {
            self.times.resize(i + 1, 0.0);
        }
        self.times[i] = time;
    }

    /// The moment of the ray at a place.
    #[inline]
    pub fn time(&self, i: usize) -> f32 {
        self.times.get(i).copied().unwrap_or(0.0)
    }

    /// The ray at a place; `None` if it is empty.
    #[inline]
    pub fn get(&self, i: usize) -> Option<Ray> {
        let (block, lane) = (&self.blocks[i / LANES], i % LANES);
        let vector = |v: &[turner_bvh::lanes::Block; 3]| DVec3::new(v[0].0[lane], v[1].0[lane], v[2].0[lane]);
        let ray = Ray {
            t_min: block.t_min.0[lane],
            t_max: block.t_max.0[lane],
            time: self.time(i),
            ..Ray::new(vector(&block.origin), vector(&block.direction))
        };
        (!ray.t_max.is_nan()).then_some(ray)
    }

    /// The ray at a place, up to its end.
    #[inline]
    pub(crate) fn get_to_end(&self, place: u32) -> Option<Ray> {
        let place = place as usize;
        let ray = self.get(place)?;
        Some(Ray { t_max: self.ends[place / LANES].0[place % LANES], ..ray })
    }

    /// Where the ray at a place ends.
    #[inline]
    pub(crate) fn end(&self, place: u32) -> f64 {
        self.ends[place as usize / LANES].0[place as usize % LANES]
    }

    #[inline]
    pub(crate) fn end_ray(&mut self, place: u32, t: f64) {
        self.ends[place as usize / LANES].0[place as usize % LANES] = t;
    }

    pub(crate) fn note(&mut self, place: usize, blocked: bool, tinted: bool) {
        self.blocked[place / LANES] |= u8::from(blocked) << (place % LANES);
        self.tinted[place / LANES] |= u8::from(tinted) << (place % LANES);
    }

    /// Lets rays end where they do, or nowhere where they are blocked.
    pub(crate) fn end_unblocked(&mut self) {
        self.ends.clear();
        self.ends.extend(self.blocks[..self.len.div_ceil(LANES)].iter().map(|block| block.t_max));
        for (end, blocked) in self.ends.iter_mut().zip(&self.blocked) {
            for lane in Bits(u64::from(*blocked)) {
                end.0[lane as usize] = f64::NAN;
            }
        }
    }

    /// Lets rays end at their hits.
    pub(crate) fn end_at(&mut self, hits: &[Option<Hit>]) {
        self.ends.clear();
        self.ends.extend(self.blocks[..self.len.div_ceil(LANES)].iter().map(|block| block.t_max));
        for (place, hit) in hits.iter().enumerate() {
            if let Some(hit) = hit {
                self.ends[place / LANES].0[place % LANES] = hit.shape.t;
            }
        }
    }

    /// Moves all rays into an object's space.
    pub(crate) fn move_into(&mut self, placed: &ObjectTransform) {
        self.moved.clear();
        self.moved.resize(self.len.div_ceil(LANES), RayBlock::NOTHING);
        for place in 0..self.len {
            if let Some(ray) = self.get(place) {
                let moved = placed.ray_to_object(&ray);
                self.moved[place / LANES].set(
                    place % LANES,
                    moved.origin.to_array(),
                    moved.direction.to_array(),
                    moved.t_min,
                    moved.t_max,
                );
            }
        }
    }

    /// The blocks.
    #[inline]
    pub fn blocks(&self) -> &[RayBlock] {
        &self.blocks[..self.len.div_ceil(LANES)]
    }
}
