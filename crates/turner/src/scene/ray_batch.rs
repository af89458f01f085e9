//! Rays in blocks of eight, with the surfaces that they leave and scratch memory.

use turner_bvh::lanes::{Block, LANES};
use turner_bvh::{NearestBlock, RayBlock};

use crate::math::{DVec3, Ray};
use crate::scene::scene::{Bits, ObjectTransform};
use crate::scene::{Hit, SurfaceInteraction};
use crate::shape::{MeshRays, ShapeHit};

/// Rays in blocks of eight, with scratch memory. Slots may be empty: a `t_max` of NaN marks them, and their other
/// values are ignored. Blocks are kept when the batch is cleared.
#[derive(Default)]
pub struct RayBatch {
    pub(crate) blocks: Vec<RayBlock>,
    /// Times of the rays, if anything moves; missing entries are 0.
    times: Vec<f32>,
    /// Number of slots; some may be empty.
    pub(crate) len: usize,
    /// The primitive and part that each ray leaves: it cannot hit a flat one again. Empty if unknown for all rays.
    pub(crate) from: Vec<RayOrigin>,
    /// The primitive and part that each ray ends before, so that it cannot hit it. Empty if unknown for all rays.
    pub(crate) to: Vec<RayOrigin>,
    pub(crate) nearest: Vec<NearestBlock>,
    pub(crate) blocked: Vec<u8>,
    /// Bits of rays that something tinted attenuates.
    pub(crate) tinted: Vec<u8>,
    /// For meshes: the current end of each ray, and the rays in object space.
    pub(crate) ends: Vec<Block>,
    pub(crate) moved: Vec<RayBlock>,
    pub(crate) scratch: MeshRays,
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
    /// The origin of a ray that begins here.
    #[inline]
    pub fn origin(&self) -> RayOrigin {
        RayOrigin { primitive: self.primitive, part: self.shape.part }
    }
}

impl RayBatch {
    /// Removes all rays.
    pub fn clear(&mut self) {
        self.len = 0;
        self.from.clear();
        self.to.clear();
        self.times.clear();
    }

    /// Number of slots; some may be empty.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no slots.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Adds a ray without its time: see [`RayBatch::set_time`].
    #[inline]
    pub fn push(&mut self, ray: &Ray) {
        let lane = self.len % LANES;
        let block = if lane == 0 { self.add_block(1) } else { self.last_block() };
        block.set(lane, ray.origin.to_array(), ray.direction.to_array(), ray.t_min, ray.t_max);
        if lane != 0 {
            self.len += 1;
        }
    }

    /// Adds a ray that leaves a surface. It finds the same hits as without this knowledge, but faster.
    #[inline]
    pub fn push_from(&mut self, ray: &Ray, surface: &SurfaceInteraction) {
        self.push_leaving(ray, surface.hit.origin());
    }

    /// The same with the origin from [`Hit::origin`].
    #[inline]
    pub fn push_leaving(&mut self, ray: &Ray, from: RayOrigin) {
        self.push(ray);
        if self.from.len() + 1 < self.len {
            self.from.resize(self.len - 1, RayOrigin::NOWHERE);
        }
        self.from.push(from);
    }

    /// The same for a ray that ends just before a light.
    #[inline]
    pub fn push_between(&mut self, ray: &Ray, from: RayOrigin, to: RayOrigin) {
        self.push_leaving(ray, from);
        if self.to.len() + 1 < self.len {
            self.to.resize(self.len - 1, RayOrigin::NOWHERE);
        }
        self.to.push(to);
    }

    /// Adds `count` slots, at most eight, for the caller to fill; all are empty at first. Earlier blocks must be
    /// full.
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

    /// Empties the slot of a ray.
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

    /// Copies the rays of another batch.
    pub fn copy(&mut self, other: &RayBatch) {
        self.blocks.clear();
        self.blocks.extend_from_slice(other.blocks());
        self.len = other.len;
        self.from.clone_from(&other.from);
        self.to.clone_from(&other.to);
        self.times.clone_from(&other.times);
    }

    /// Sets the time of a ray; earlier rays without a time get 0.
    pub fn set_time(&mut self, i: usize, time: f32) {
        if self.times.len() <= i {
            self.times.resize(i + 1, 0.0);
        }
        self.times[i] = time;
    }

    /// The time of a ray.
    #[inline]
    pub fn time(&self, i: usize) -> f32 {
        self.times.get(i).copied().unwrap_or(0.0)
    }

    /// Moves the ray in a slot to another origin and unit direction.
    pub(crate) fn place(&mut self, i: usize, origin: DVec3, direction: DVec3) {
        let (block, lane) = (&mut self.blocks[i / LANES], i % LANES);
        for axis in 0..3 {
            block.origin[axis].0[lane] = origin[axis];
            block.direction[axis].0[lane] = direction[axis];
        }
    }

    /// The ray in a slot; `None` if the slot is empty.
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

    /// The ray in a slot, shortened to its current end.
    #[inline]
    pub(crate) fn get_to_end(&self, slot: u32) -> Option<Ray> {
        let slot = slot as usize;
        let ray = self.get(slot)?;
        Some(Ray { t_max: self.ends[slot / LANES].0[slot % LANES], ..ray })
    }

    /// The current end of a ray.
    #[inline]
    pub(crate) fn end(&self, slot: u32) -> f64 {
        self.ends[slot as usize / LANES].0[slot as usize % LANES]
    }

    #[inline]
    pub(crate) fn end_ray(&mut self, slot: u32, t: f64) {
        self.ends[slot as usize / LANES].0[slot as usize % LANES] = t;
    }

    pub(crate) fn mark(&mut self, slot: usize, blocked: bool, tinted: bool) {
        self.blocked[slot / LANES] |= u8::from(blocked) << (slot % LANES);
        self.tinted[slot / LANES] |= u8::from(tinted) << (slot % LANES);
    }

    /// Resets the ends of rays to their `t_max`, or to NaN if they are blocked.
    pub(crate) fn end_unblocked(&mut self) {
        self.ends.clear();
        self.ends.extend(self.blocks[..self.len.div_ceil(LANES)].iter().map(|block| block.t_max));
        for (end, blocked) in self.ends.iter_mut().zip(&self.blocked) {
            for lane in Bits(u64::from(*blocked)) {
                end.0[lane as usize] = f64::NAN;
            }
        }
    }

    /// Ends rays at their hits.
    pub(crate) fn end_at(&mut self, hits: &[Option<Hit>]) {
        self.ends.clear();
        self.ends.extend(self.blocks[..self.len.div_ceil(LANES)].iter().map(|block| block.t_max));
        for (slot, hit) in hits.iter().enumerate() {
            if let Some(hit) = hit {
                self.ends[slot / LANES].0[slot % LANES] = hit.shape.t;
            }
        }
    }

    /// Transforms all rays to an object's space.
    pub(crate) fn move_into(&mut self, transform: &ObjectTransform) {
        self.moved.clear();
        self.moved.resize(self.len.div_ceil(LANES), RayBlock::NOTHING);
        for slot in 0..self.len {
            if let Some(ray) = self.get(slot) {
                let moved = transform.ray_to_object(&ray);
                self.moved[slot / LANES].set(
                    slot % LANES,
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
