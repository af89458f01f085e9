//! Eight orthonormal frames at a time, with the same bits as [`Frame`](super::Frame).

use turner_bvh::lanes::{F64x8, Mask8, Simd, Vec3x8};

/// Eight [`Frame`](super::Frame)s.
#[derive(Clone, Copy)]
pub struct FrameX8<S: Simd> {
    /// First tangents.
    pub x: Vec3x8<S>,
    /// Second tangents.
    pub y: Vec3x8<S>,
    /// Normals.
    pub z: Vec3x8<S>,
}

impl<S: Simd> FrameX8<S> {
    /// As [`Frame::from_z`](super::Frame::from_z).
    #[inline(always)]
    pub fn from_z(simd: S, z: Vec3x8<S>) -> Self {
        let one = F64x8::splat(simd, 1.0);
        let sign = one.copysign(z.z);
        let a = -one / (sign + z.z);
        let b = z.x * z.y * a;
        FrameX8 {
            x: Vec3x8 { x: one + sign * z.x * z.x * a, y: sign * b, z: -sign * z.x },
            y: Vec3x8 { x: b, y: sign + z.y * z.y * a, z: -z.y },
            z,
        }
    }

    /// Unchanged in the lanes of the mask; in the others rotated to the other side: y and z are negated.
    #[inline(always)]
    pub fn turned_unless(self, mask: Mask8<S>) -> Self {
        FrameX8 {
            x: self.x,
            y: Vec3x8::select(mask, self.y, -self.y),
            z: Vec3x8::select(mask, self.z, -self.z),
        }
    }

    /// `a` in the lanes of the mask, `b` elsewhere.
    #[inline(always)]
    pub fn select(mask: Mask8<S>, a: Self, b: Self) -> Self {
        FrameX8 {
            x: Vec3x8::select(mask, a.x, b.x),
            y: Vec3x8::select(mask, a.y, b.y),
            z: Vec3x8::select(mask, a.z, b.z),
        }
    }

    /// As [`Frame::to_world`](super::Frame::to_world).
    #[inline(always)]
    pub fn to_world(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// As [`Frame::to_local`](super::Frame::to_local).
    #[inline(always)]
    pub fn to_local(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        Vec3x8 { x: v.dot(self.x), y: v.dot(self.y), z: v.dot(self.z) }
    }
}
