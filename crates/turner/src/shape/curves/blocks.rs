//! Blocks of eight parts of curves: what a ray is tested against first.
//!
//! A part lies in a capsule, whatever its direction: the chord of its control points, as thick as the tube and the farthest
//! control point. Most boxes of thin slanted parts that a ray meets are left at once by this test, which costs the same for
//! one part and for eight.
//!
//! ```text
//!      ,- - - - - - - - -.
//!     (  a-----.____----b )       radius: widest radius + distance of the control points from the chord ab
//!      ` - - - - - - - - '
//! ```

use turner_bvh::lanes::{Block32, F32x8, F64x8, Simd, Vec3x8, Work, dispatch};
use turner_bvh::{BlockBvh, InstructionSet};

use super::cubic::Cubic;
use crate::math::{DVec3, Frame};
use crate::shape::traversal::TraversalFrame;

/// Eight capsules in the coordinates of the BVH, and the parts that they contain.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Block {
    /// The ends of the chords, by coordinate.
    a: [Block32; 3],
    b: [Block32; 3],
    /// NaN for unused lanes.
    radius: Block32,
    pub(super) parts: [u32; 8],
}

const _: () = assert!(size_of::<Block>() == 256);

impl Block {
    /// The block of some parts. `part` returns the curve of a part.
    pub(super) fn new(parts: [u32; 8], frame: &TraversalFrame, part: impl Fn(u32) -> Option<Cubic>) -> Block {
        let mut block =
            Block { a: Default::default(), b: Default::default(), radius: Block32([f32::NAN; 8]), parts };
        for (lane, id) in parts.into_iter().enumerate() {
            let Some(cubic) = Some(id).filter(|id| *id != BlockBvh::NONE).and_then(&part) else { continue };
            // Padded by more than the rounding to f32 of the ends.
            let (a, radius) = frame.sphere(cubic.p[0], cubic.capsule());
            let (b, _) = frame.sphere(cubic.p[3], 0.0);
            for axis in 0..3 {
                block.a[axis].0[lane] = a[axis] as f32;
                block.b[axis].0[lane] = b[axis] as f32;
            }
            block.radius.0[lane] = (radius as f32).next_up();
        }
        block
    }

    /// The lanes whose capsules the ray meets at 0 <= t <= `t_max`, the first lane lowest.
    #[inline]
    pub(super) fn near(&self, set: InstructionSet, ray: &BlockRay, t_max: f32) -> u8 {
        dispatch(set, Near { block: self, ray, t_max })
    }
}

/// A ray as the z axis of a frame, in the coordinates of the BVH.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockRay {
    frame: Frame,
    origin: DVec3,
}

impl BlockRay {
    /// The ray's direction has the length 1.
    pub(super) fn new(ray: &turner_bvh::Ray) -> BlockRay {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        BlockRay { frame: Frame::from_z(wide(ray.direction)), origin: wide(ray.origin) }
    }
}

struct Near<'a> {
    block: &'a Block,
    ray: &'a BlockRay,
    t_max: f32,
}

impl Work for Near<'_> {
    type Output = u8;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u8 {
        let Near { block, ray, t_max } = self;
        let origin = Vec3x8::splat(simd, ray.origin.to_array());
        let [x, y, z] = [ray.frame.x, ray.frame.y, ray.frame.z].map(|v| Vec3x8::splat(simd, v.to_array()));
        let a = load(simd, &block.a) - origin;
        let along = load(simd, &block.b) - origin - a;
        let (zero, one) = (F64x8::splat(simd, 0.0), F64x8::splat(simd, 1.0));
        // The point of the chord that is nearest to the ray's line.
        let (ax, ay, lx, ly) = (a.dot(x), a.dot(y), along.dot(x), along.dot(y));
        let s = -(ax * lx + ay * ly) / (lx * lx + ly * ly);
        // A chord along the ray has NaN.
        let s = s.gt(zero).select(s, zero);
        let s = s.lt(one).select(s, one);
        let (px, py) = (ax + s * lx, ay + s * ly);
        let radius = F32x8::load(simd, &block.radius).widen();
        let (az, lz) = (a.dot(z), along.dot(z));
        let bz = az + lz;
        let (near, far) = (az.lt(bz).select(az, bz) - radius, az.lt(bz).select(bz, az) + radius);
        let meets = (px * px + py * py).le(radius * radius);
        (meets & near.le(F64x8::splat(simd, f64::from(t_max))) & far.ge(zero)).bits()
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, [x, y, z]: &[Block32; 3]) -> Vec3x8<S> {
    Vec3x8 {
        x: F32x8::load(simd, x).widen(),
        y: F32x8::load(simd, y).widen(),
        z: F32x8::load(simd, z).widen(),
    }
}
