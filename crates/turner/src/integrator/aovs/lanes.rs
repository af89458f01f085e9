//! AOVs of the point and its normals, eight samples at a time. Each has the bits of [`value`](super::value).

use turner_bvh::RayBlock;
use turner_bvh::lanes::{Block32, F64x8, Simd, Vec3x8, Work};

use crate::camera::CameraFrame;
use crate::film::Aov;
use crate::math::DVec3;
use crate::scene::{FlatBlock, SurfaceBlock};

/// Whether [`Points`] computes an AOV. The camera's axes are those at the ray's time, so a moving camera needs scalar code.
pub(super) fn is_in_lanes(aov: Aov, camera_moves: bool) -> bool {
    match aov {
        Aov::Normal | Aov::GeometricNormal | Aov::Distance | Aov::Position => true,
        Aov::CameraNormal | Aov::Depth => !camera_moves,
        _ => false,
    }
}

/// Computes the points and normals of a block, and from them AOVs.
pub(super) struct Points<'a> {
    pub(super) surfaces: &'a mut SurfaceBlock,
    /// If all hits are on one flat shape, those; `surfaces` does not have them.
    pub(super) flat: Option<FlatBlock>,
    pub(super) rays: &'a RayBlock,
    pub(super) frame: &'a CameraFrame,
    pub(super) aovs: &'a [Aov],
    /// For each AOV its channels; those that are not computed here stay as they are.
    pub(super) out: &'a mut [[Block32; 3]],
}

impl Work for Points<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Points { surfaces, flat, rays, frame, aovs, out } = self;
        match flat {
            Some(flat) => surfaces.set_flat(simd, rays, &flat),
            None => surfaces.compute_points(simd),
        }
        let (p, ng, ns) = surfaces.points(simd);
        let direction = Vec3x8::load(simd, &rays.direction);
        let from = p - Vec3x8::load(simd, &rays.origin);
        let behind = ng.dot(direction).gt(F64x8::splat(simd, 0.0));
        let normal = Vec3x8::select(behind, -ns, ns);
        let along = |v: Vec3x8<S>, axis: DVec3| v.dot(Vec3x8::splat(simd, axis.to_array()));
        for (aov, out) in aovs.iter().zip(out) {
            let values = match aov {
                Aov::Normal => normal,
                Aov::GeometricNormal => ng,
                Aov::Position => p,
                Aov::CameraNormal => Vec3x8 {
                    x: along(normal, frame.right),
                    y: along(normal, frame.up),
                    z: -along(normal, frame.forward),
                },
                Aov::Depth => splat(along(from, frame.forward)),
                Aov::Distance => splat(from.dot(from).sqrt()),
                _ => continue,
            };
            for (to, v) in out.iter_mut().zip([values.x, values.y, values.z]) {
                v.narrow().store(to);
            }
        }
    }
}

#[inline(always)]
fn splat<S: Simd>(v: F64x8<S>) -> Vec3x8<S> {
    Vec3x8 { x: v, y: v, z: v }
}
