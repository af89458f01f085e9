//! Rectangle intersection, eight rays at a time.

use turner_bvh::lanes::{Block, F64x8, LANES, Simd, Vec3x8, Work, dispatch};
use turner_bvh::{InstructionSet, RayBlock};

use crate::scene::scene::Bits;
use crate::shape::{Rectangle, ShapeHit};

/// A rectangle in world space.
#[derive(Clone, Debug)]
pub(crate) struct BatchRectangle {
    shape: Rectangle,
    /// Index of the primitive.
    pub(crate) index: u32,
    /// Whether it is invisible from its back.
    one_sided: bool,
}

impl BatchRectangle {
    pub(crate) fn new(shape: &Rectangle, index: u32, one_sided: bool) -> BatchRectangle {
        BatchRectangle { shape: *shape, index, one_sided }
    }

    /// Calls `hit` with the index and the hit of each ray that hits the rectangle before the ray's end.
    pub(crate) fn intersect(
        &self,
        set: InstructionSet,
        blocks: &[RayBlock],
        ends: &[Block],
        mut hit: impl FnMut(usize, ShapeHit),
    ) {
        dispatch(set, Crossings { rectangle: self, blocks, ends, hit: &mut hit });
    }
}

struct Crossings<'a, F> {
    rectangle: &'a BatchRectangle,
    blocks: &'a [RayBlock],
    ends: &'a [Block],
    hit: &'a mut F,
}

impl<F: FnMut(usize, ShapeHit)> Work for Crossings<'_, F> {
    type Output = ();

    /// As [`Rectangle::intersect`], operation by operation.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let r = &self.rectangle.shape;
        let vector = |v: crate::math::DVec3| Vec3x8::splat(simd, v.to_array());
        let (center, normal) = (vector(r.center), vector(r.normal));
        let (to_u, to_v) = (vector(r.to_u), vector(r.to_v));
        let splat = |v: f64| F64x8::splat(simd, v);
        let (half, infinity) = (splat(0.5), splat(f64::INFINITY));
        let mut out = [Block([0.0; LANES]); 3];
        for (i, (block, end)) in self.blocks.iter().zip(self.ends).enumerate() {
            let (origin, direction) =
                (Vec3x8::load(simd, &block.origin), Vec3x8::load(simd, &block.direction));
            let speed = direction.dot(normal);
            let t = (center - origin).dot(normal) / speed;
            let f = (origin + direction * t) - center;
            let (u, v) = (f.dot(to_u), f.dot(to_v));
            let hit = t.ge(F64x8::load(simd, &block.t_min))
                & t.le(F64x8::load(simd, end))
                & t.lt(infinity)
                & speed.abs().lt(infinity)
                & u.abs().le(half)
                & v.abs().le(half);
            let mut hit = hit.bits();
            if self.rectangle.one_sided {
                hit &= speed.le(splat(0.0)).bits();
            }
            if hit == 0 {
                continue;
            }
            t.store(&mut out[0]);
            (u + half).store(&mut out[1]);
            (v + half).store(&mut out[2]);
            for lane in Bits(u64::from(hit)) {
                let lane = lane as usize;
                let hit = ShapeHit { t: out[0].0[lane], part: 0, u: out[1].0[lane], v: out[2].0[lane] };
                (self.hit)(i * LANES + lane, hit);
            }
        }
    }
}
