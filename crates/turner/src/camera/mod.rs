//! Cameras: they map positions in the picture to rays. Each camera has its own file; [`CameraDesc`] lists their names
//! in a scene.
//!
//! ```text
//!                 (-1, 1) +-------------+ (1, 1)
//!                         |   screen    |
//!      camera  o----------|------+------|---->  forward
//!                         |             |
//!                (-1, -1) +-------------+ (1, -1)
//! ```
//!
//! Every [`Camera`] keeps this contract:
//!
//! - Screen positions run from (−1, −1), the lower left corner, to (1, 1), the upper right corner, for any aspect
//!   ratio. The film's rows run downwards from the top. Filters may ask for positions slightly outside.
//! - [`Camera::ray`] returns a ray in world space. Its direction goes from the camera to the screen or to the plane
//!   of focus and is not normalized: its length is that of the classic documents. [`camera_rays`] makes eight rays of
//!   unit direction and returns those lengths in addition.
//! - `t_min` is where the ray crosses the `near` distance, `t_max` where it crosses `far`; flat screens measure
//!   both along the viewing direction.
//! - Where a camera has no picture (outside a fisheye's circle) the ray is empty: `t_max` is negative and it hits
//!   nothing. The renderer makes the sample black, or transparent if the background is. [`Camera::is_outside_field`] says
//!   whether that can happen.
//! - `lens` is a uniform random point of the unit square that chooses the point on the lens. Cameras without a lens
//!   ignore it ([`Camera::has_lens`]). A ray depends on its arguments only.
//! - The rays of a screen position have the same weight: the camera's importance is in the density of its rays. The light
//!   of a picture position may have a factor, [`Camera::weight`], by which a lens darkens corners.
//! - `project` is the inverse: from a point to its position in the picture, for light paths. Its density is in pixels
//!   per area perpendicular to the camera ray. `None` means that the camera does not see the point.
//! - Time is not a matter of the camera: the view sets it on the ray.

mod aperture;
mod clip;
mod equirectangular;
mod fisheye;
mod frame;
mod model;
mod orthographic;
mod pinhole;
mod pixel_cone;
mod project;
mod rays;
mod realistic;
mod thin_lens;

pub use equirectangular::{Equirectangular, EquirectangularDesc, PanoramaMapping};
pub use fisheye::{Fisheye, FisheyeDesc};
pub use frame::{CameraFrame, Handedness};
pub use model::{CameraModel, ProjectionKind};
pub use orthographic::{Orthographic, OrthographicDesc};
pub use pinhole::{MAX_SHIFT, Pinhole, PinholeDesc, Viewport};
pub use pixel_cone::PixelCone;
pub use project::Projection;
pub use rays::camera_rays;
pub use realistic::{LensBrightness, Realistic, RealisticDesc};
pub use thin_lens::{ThinLens, ThinLensDesc};

use crate::schema::family;

family! {
    /// Cameras: the section `[camera]`. The default `type` is "pinhole".
    pub enum CameraDesc as "camera", "cameras" {
        Pinhole(PinholeDesc),
        Orthographic(OrthographicDesc),
        ThinLens(ThinLensDesc),
        Equirectangular(EquirectangularDesc),
        Fisheye(FisheyeDesc),
        Realistic(RealisticDesc),
    }
}

use crate::math::{Bounds, DVec2, DVec3, Ray, elementary::sin, radians};
use crate::schema::{SceneError, Transform};

/// A prepared camera, which generates rays.
#[derive(Clone, Debug, PartialEq)]
pub enum Camera {
    /// Pinhole.
    Pinhole(pinhole::Pinhole),
    /// Orthographic.
    Orthographic(orthographic::Orthographic),
    /// Thin lens.
    ThinLens(thin_lens::ThinLens),
    /// Panorama of all directions.
    Equirectangular(equirectangular::Equirectangular),
    /// Circular panorama.
    Fisheye(fisheye::Fisheye),
    /// A lens of spherical surfaces.
    Realistic(realistic::Realistic),
}

/// The vertical field of view of cameras that name none, degrees.
pub(crate) const DEFAULT_FOV: f64 = 40.0;

impl CameraDesc {
    /// Prepares it for a picture of the given aspect ratio (width over height).
    pub fn prepare(&self, aspect: f64) -> Result<Camera, SceneError> {
        Ok(match self {
            CameraDesc::Pinhole(c) => Camera::Pinhole(c.prepare(aspect)?),
            CameraDesc::Orthographic(c) => Camera::Orthographic(c.prepare(aspect)?),
            CameraDesc::ThinLens(c) => Camera::ThinLens(c.prepare(aspect)?),
            CameraDesc::Equirectangular(c) => Camera::Equirectangular(c.prepare()?),
            CameraDesc::Fisheye(c) => Camera::Fisheye(c.prepare(aspect)?),
            CameraDesc::Realistic(c) => Camera::Realistic(c.prepare(aspect)?),
        })
    }

    /// Position, look-at point and up direction, for moving the camera with the object it belongs to.
    pub fn placement_mut(&mut self) -> [&mut DVec3; 3] {
        match self {
            CameraDesc::Pinhole(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::Orthographic(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::ThinLens(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::Equirectangular(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::Fisheye(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::Realistic(c) => [&mut c.position, &mut c.look_at, &mut c.up],
        }
    }

    /// What moves it while the shutter is open.
    pub fn motion_mut(&mut self) -> &mut Option<Transform> {
        match self {
            CameraDesc::Pinhole(c) => &mut c.motion,
            CameraDesc::Orthographic(c) => &mut c.motion,
            CameraDesc::ThinLens(c) => &mut c.motion,
            CameraDesc::Equirectangular(c) => &mut c.motion,
            CameraDesc::Fisheye(c) => &mut c.motion,
            CameraDesc::Realistic(c) => &mut c.motion,
        }
    }

    /// What moves it while the shutter is open.
    pub fn motion(&self) -> Option<Transform> {
        match self {
            CameraDesc::Pinhole(c) => c.motion,
            CameraDesc::Orthographic(c) => c.motion,
            CameraDesc::ThinLens(c) => c.motion,
            CameraDesc::Equirectangular(c) => c.motion,
            CameraDesc::Fisheye(c) => c.motion,
            CameraDesc::Realistic(c) => c.motion,
        }
    }

    /// The default camera for scenes without one: it shows the complete box from slightly above its front (+z).
    pub fn framing(bounds: &Bounds, aspect: f64) -> CameraDesc {
        let fov = DEFAULT_FOV;
        let finite = !bounds.is_empty() && bounds.is_finite();
        let (center, radius) =
            if finite { (bounds.center(), 0.5 * bounds.size().length()) } else { (DVec3::Y, 2.0) };
        let half = 0.5 * radians(fov);
        let distance = radius.max(1e-6) / (sin(half) * aspect.min(1.0));
        CameraDesc::Pinhole(PinholeDesc {
            position: center + distance * DVec3::new(0.0, 0.3, 1.0).normalize(),
            look_at: center,
            fov: Some(fov),
            ..PinholeDesc::default()
        })
    }
}

impl Camera {
    /// Its position and unit axes.
    pub fn frame(&self) -> CameraFrame {
        match self {
            Camera::Pinhole(c) => c.frame,
            Camera::Orthographic(c) => c.frame,
            Camera::ThinLens(c) => c.frame,
            Camera::Equirectangular(c) => c.frame,
            Camera::Fisheye(c) => c.frame,
            Camera::Realistic(c) => c.frame,
        }
    }

    /// Whether [`Camera::ray`] uses its `lens`.
    #[inline]
    pub fn has_lens(&self) -> bool {
        match self {
            Camera::ThinLens(_) | Camera::Realistic(_) => true,
            Camera::Pinhole(_)
            | Camera::Orthographic(_)
            | Camera::Equirectangular(_)
            | Camera::Fisheye(_) => false,
        }
    }

    /// Whether parts of the picture may have no ray, see [`Camera::ray`].
    #[inline]
    pub fn is_outside_field(&self) -> bool {
        match self {
            Camera::Fisheye(_) | Camera::Realistic(_) => true,
            Camera::Pinhole(_)
            | Camera::Orthographic(_)
            | Camera::ThinLens(_)
            | Camera::Equirectangular(_) => false,
        }
    }

    /// Whether [`Camera::weight`] may differ from 1.
    #[inline]
    pub fn has_weights(&self) -> bool {
        match self {
            Camera::Realistic(_) => true,
            Camera::Pinhole(_)
            | Camera::Orthographic(_)
            | Camera::ThinLens(_)
            | Camera::Equirectangular(_)
            | Camera::Fisheye(_) => false,
        }
    }

    /// The factor of all light at a screen position.
    #[inline]
    pub fn weight(&self, at: DVec2) -> f32 {
        match self {
            Camera::Realistic(c) => c.weight(at),
            Camera::Pinhole(_)
            | Camera::Orthographic(_)
            | Camera::ThinLens(_)
            | Camera::Equirectangular(_)
            | Camera::Fisheye(_) => 1.0,
        }
    }

    /// Whether light paths may connect to it: [`Camera::project`] is the exact inverse of [`Camera::ray`], with every
    /// point of the lens. For a lens of many surfaces it is so for the ray through the centre of the pupil only.
    #[inline]
    pub fn receives_light_paths(&self) -> bool {
        match self {
            Camera::Realistic(_) => false,
            Camera::Pinhole(_)
            | Camera::Orthographic(_)
            | Camera::ThinLens(_)
            | Camera::Equirectangular(_)
            | Camera::Fisheye(_) => true,
        }
    }

    /// The ray through a screen position, (−1, −1) the lower left and (1, 1) the upper right corner. `lens` is a
    /// point of the unit square that chooses the point on the lens, if the camera has one. The direction leads to the
    /// screen, or to the plane of focus for a lens; it is not normalized. Where the camera has no picture the ray is
    /// empty (`t_max` < 0).
    #[inline]
    pub fn ray(&self, at: DVec2, lens: DVec2) -> Ray {
        match self {
            Camera::Pinhole(c) => c.ray(at),
            Camera::Orthographic(c) => c.ray(at),
            Camera::ThinLens(c) => c.ray(at, lens),
            Camera::Equirectangular(c) => c.ray(at),
            Camera::Fisheye(c) => c.ray(at),
            Camera::Realistic(c) => c.ray(at, lens),
        }
    }
}

#[cfg(test)]
mod tests;
