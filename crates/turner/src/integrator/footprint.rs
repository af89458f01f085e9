//! The cones of a path's rays, where textures are filtered by them.

use turner_bvh::lanes::LANES;

use crate::bsdf::BsdfSample;
use crate::camera::PixelCone;
use crate::math::{DVec3, RayCone};
use crate::scene::{Scene, SurfaceInteraction};
use crate::view::{CameraSamples, View};

/// The cone of a camera ray; one without width where textures are looked up at points.
#[inline]
pub(super) fn of_camera(view: &View, samples: &CameraSamples, i: usize) -> RayCone {
    match &view.pixel_cone {
        Some(pixel) => pixel.cone(samples.lengths[i / LANES].0[i % LANES]),
        None => RayCone::default(),
    }
}

/// The cone at the end of a ray of unit direction and length `t`; the surface there learns of it.
#[inline]
pub(super) fn arrive(cone: &mut RayCone, surface: &mut SurfaceInteraction, direction: DVec3, t: f64) {
    *cone = cone.advanced(t);
    surface.see(direction, cone.width);
}

/// The cone of the ray that leaves a surface after scattering; `wo` leads to where the ray came from, `crosses` says whether it goes through.
pub(super) fn leave(
    scene: &Scene,
    pixel: &PixelCone,
    cone: RayCone,
    surface: &SurfaceInteraction,
    wo: DVec3,
    s: &BsdfSample,
    crosses: bool,
) -> RayCone {
    let side = if wo.dot(surface.ng) >= 0.0 { 1.0 } else { -1.0 };
    let curvature = side * scene.curvature(surface);
    let turned = if crosses { cone.refracted(s.eta, curvature) } else { cone.reflected(curvature) };
    if s.lobe.is_delta { turned } else { turned.scattered(s.pdf, pixel.share) }
}

/// The same for reflection by something flat, with the density `pdf`.
#[inline]
pub(super) fn leave_flat(pixel: &PixelCone, cone: RayCone, pdf: f64) -> RayCone {
    cone.reflected(0.0).scattered(pdf, pixel.share)
}
