//! Cameras: from a point of the picture to a ray. One file each; [`CameraDesc`] is the table of their names in a scene.
//!
//! The contract, which every [`Camera`] keeps:
//!
//! - Places on the screen run from (−1, −1), its lower left corner, to (1, 1), its upper right one, whatever the shape of the picture; the film's rows run downwards from the top.
//!   Filters may ask a little beyond.
//! - [`Camera::ray`] is in world space. Its direction leads from the eye to the screen, or to the plane in focus; its length is the one in which the classic documents form it.
//!   [`camera_rays`] makes eight rays of unit direction and returns those lengths beside them.
//! - Rays begin at `near`, which is measured along the direction of view: `t_min` says where that is on the ray. They have no end (`t_max` is infinite).
//! - Where a camera shows nothing (beyond a fisheye's circle) there is a ray all the same, which ends before it begins: `t_max` below 0. It meets nothing,
//!   and the renderer makes the sample black, transparent where the background is. [`Camera::leaves_out`] says whether that may happen.
//! - `lens` is a point of the unit square, spread evenly: it chooses the place on the lens. Cameras without a lens ignore it ([`Camera::has_lens`]). A ray depends on these numbers alone.
//! - Every ray carries the same weight: importance is not a factor of the camera but the spread of its rays.
//! - `project` goes the other way, from a point to its place in the picture, for light paths; its density is in pixels per area at right angles to the camera ray. `None` is a
//!   point that the camera does not see.
//! - A moment is not the camera's: the view gives it to the ray.

mod aperture;
mod equirectangular;
mod fisheye;
mod frame;
mod orthographic;
mod pinhole;
mod pixel_cone;
mod project;
mod rays;
mod thin_lens;

pub use equirectangular::{Equirectangular, EquirectangularDesc};
pub use fisheye::{Fisheye, FisheyeDesc};
pub use frame::{CameraFrame, Handedness};
pub use orthographic::{Orthographic, OrthographicDesc};
pub use pinhole::{MAX_SHIFT, Pinhole, PinholeDesc, Viewport};
pub use pixel_cone::PixelCone;
pub use project::Projection;
pub use rays::camera_rays;
pub use thin_lens::{ThinLens, ThinLensDesc};

use crate::schema::family;

family! {
    /// Cameras: `[camera]`. The `type` is "pinhole" unless given.
    pub enum CameraDesc as "camera", "cameras" {
        Pinhole(PinholeDesc),
        Orthographic(OrthographicDesc),
        ThinLens(ThinLensDesc),
        Equirectangular(EquirectangularDesc),
        Fisheye(FisheyeDesc),
    }
}

use crate::math::{Bounds, DVec2, DVec3, Ray, elementary::sin, radians};
use crate::schema::SceneError;

/// A camera ready to make rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// Pinhole.
    Pinhole(pinhole::Pinhole),
    /// Orthographic.
    Orthographic(orthographic::Orthographic),
    /// Thin lens.
    ThinLens(thin_lens::ThinLens),
    /// Panorama of all directions.
    Equirectangular(equirectangular::Equirectangular),
    /// Panorama in a circle.
    Fisheye(fisheye::Fisheye),
}

impl CameraDesc {
    /// Makes it ready for a picture of the given aspect (width over height).
    pub fn prepare(&self, aspect: f64) -> Result<Camera, SceneError> {
        Ok(match self {
            CameraDesc::Pinhole(c) => Camera::Pinhole(c.prepare(aspect)?),
            CameraDesc::Orthographic(c) => Camera::Orthographic(c.prepare(aspect)?),
            CameraDesc::ThinLens(c) => Camera::ThinLens(c.prepare(aspect)?),
            CameraDesc::Equirectangular(c) => Camera::Equirectangular(c.prepare()?),
            CameraDesc::Fisheye(c) => Camera::Fisheye(c.prepare(aspect)?),
        })
    }

    /// Position, the point looked at, and what is up: to move it with what it belongs to.
    pub fn placement_mut(&mut self) -> [&mut DVec3; 3] {
        match self {
            CameraDesc::Pinhole(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::Orthographic(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::ThinLens(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::Equirectangular(c) => [&mut c.position, &mut c.look_at, &mut c.up],
            CameraDesc::Fisheye(c) => [&mut c.position, &mut c.look_at, &mut c.up],
        }
    }

    /// A camera that shows all of a box from slightly above its front (+z), for scenes without one.
    pub fn framing(bounds: &Bounds, aspect: f64) -> CameraDesc {
        let fov = 40.0;
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
    /// Whether [`Camera::ray`] uses its `lens`.
    #[inline]
    pub fn has_lens(&self) -> bool {
        match self {
            Camera::ThinLens(_) => true,
            Camera::Pinhole(_)
            | Camera::Orthographic(_)
            | Camera::Equirectangular(_)
            | Camera::Fisheye(_) => false,
        }
    }

    /// Whether parts of the picture show nothing, see [`Camera::ray`].
    #[inline]
    pub fn leaves_out(&self) -> bool {
        match self {
            Camera::Fisheye(_) => true,
            Camera::Pinhole(_)
            | Camera::Orthographic(_)
            | Camera::ThinLens(_)
            | Camera::Equirectangular(_) => false,
        }
    }

    /// The ray through a point of the screen, (−1, −1) its lower left and (1, 1) its upper right corner; `lens` is
    /// a point of the unit square that chooses the point on the lens, if there is one. The direction leads to
    /// the screen (the plane in focus, for a lens), as the documents form it: it has no particular length. Where the camera
    /// shows nothing the ray ends before it begins (`t_max` below 0).
    #[inline]
    pub fn ray(&self, at: DVec2, lens: DVec2) -> Ray {
        match self {
            Camera::Pinhole(c) => c.ray(at),
            Camera::Orthographic(c) => c.ray(at),
            Camera::ThinLens(c) => c.ray(at, lens),
            Camera::Equirectangular(c) => c.ray(at),
            Camera::Fisheye(c) => c.ray(at),
        }
    }
}

#[cfg(test)]
mod tests;
