//! Ray cones along a path: the footprints by which textures are filtered.

use turner_bvh::lanes::LANES;

use crate::bsdf::BsdfSample;
use crate::camera::PixelCone;
use crate::math::{DVec3, RayCone};
use crate::scene::{Scene, SurfaceInteraction};
use crate::view::{CameraSamples, View};

/// The cone of a camera ray; its width is 0 where textures are not filtered.
#[inline]
pub(super) fn of_camera(view: &View, samples: &CameraSamples, i: usize) -> RayCone {
    match &view.pixel_cone {
        Some(pixel) => pixel.cone(samples.lengths[i / LANES].0[i % LANES]),
        None => RayCone::default(),
    }
}

/// Advances the cone to the hit of a ray with unit direction and length `t`, and stores the footprint in the
/// surface.
#[inline]
pub(super) fn arrive(cone: &mut RayCone, surface: &mut SurfaceInteraction, direction: DVec3, t: f64) {
    *cone = cone.advanced(t);
    surface.see(direction, cone.width);
}

/// The same after non-specular scattering. The footprint is isotropic, a circle with the area of the ellipse, so that
/// image textures need one lookup.
#[inline]
pub(super) fn arrive_isotropic(
    cone: &mut RayCone,
    surface: &mut SurfaceInteraction,
    direction: DVec3,
    t: f64,
) {
    *cone = cone.advanced(t);
    see_isotropic(surface, direction, cone.width);
}

/// Stores the footprint of a cone after non-specular scattering.
#[inline]
pub(super) fn see_isotropic(surface: &mut SurfaceInteraction, direction: DVec3, width: f32) {
    /// At more grazing angles footprints do not grow further.
    const MIN_COSINE: f64 = 0.01;
    let cosine = direction.dot(surface.ng).abs().max(MIN_COSINE);
    surface.see(DVec3::ZERO, width / cosine.sqrt() as f32);
}

/// The cone of the ray scattered at a surface. `wo` points to the previous vertex; `crosses` says whether the ray
/// is transmitted.
pub(super) fn leave(
    scene: &Scene,
    pixel: &PixelCone,
    cone: RayCone,
    surface: &SurfaceInteraction,
    wo: DVec3,
    s: &BsdfSample,
    crosses: bool,
) -> RayCone {
    let curvature = curvature(scene, surface, wo);
    let next = if crosses { cone.refracted(s.eta, curvature) } else { cone.reflected(curvature) };
    if s.lobe.is_delta { next } else { next.scattered(s.pdf, pixel.share) }
}

/// The same for reflection at a surface of this curvature on the side of the ray, with `pdf` per solid angle.
#[inline]
pub(super) fn leave_reflected(
    pixel: &PixelCone,
    cone: RayCone,
    curvature: f64,
    pdf: f64,
    is_delta: bool,
) -> RayCone {
    let next = cone.reflected(curvature);
    if is_delta { next } else { next.scattered(pdf, pixel.share) }
}

/// Curvature of a surface on the side of wo.
#[inline]
fn curvature(scene: &Scene, surface: &SurfaceInteraction, wo: DVec3) -> f64 {
    let side = if wo.dot(surface.ng) >= 0.0 { 1.0 } else { -1.0 };
    side * scene.curvature(&surface.hit)
}
