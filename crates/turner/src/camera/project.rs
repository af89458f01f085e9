//! Projection of scene points to picture positions, for light paths that connect to the camera.
//!
//! A light path that reaches a point p contributes to the pixel in which the camera sees p. The contribution needs
//! the density of camera rays at p: one ray per pixel, per area perpendicular to the ray. For a flat screen at unit
//! distance with half sizes hx, hy and W × H pixels, rays have a density per solid angle of W H / (4 hx hy cos³ θ),
//! and a density per area smaller by the squared distance:
//!
//! ```text
//!                     screen
//!                    |    _,-o p           density = rays per solid angle / |p − camera|²
//!                    |_,-'
//!      camera  o_,-' ) θ
//!               -----+---------> forward
//! ```

use super::Camera;
use super::clip::Clip;
use super::frame::CameraFrame;
use super::pinhole::Screen;
use crate::film::FilmDesc;
use crate::math::elementary::{acos, sin};
use crate::math::{DVec2, DVec3};

/// Where the camera sees a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Position in the picture, in pixels from its top left corner.
    pub place: DVec2,
    /// From the point to the origin of the camera ray through it.
    pub to_camera: DVec3,
    /// Fraction of that segment beyond the camera's `near` distance, 0..=1: only there can the view be blocked.
    pub free: f64,
    /// Density of camera rays at the point: pixels per area perpendicular to the ray.
    pub density: f64,
}

/// What each camera computes: the screen position, (−1, −1) the lower left and (1, 1) the upper right corner; the
/// vector to the camera; its fraction beyond `near`.
struct OnScreen {
    at: DVec2,
    to_camera: DVec3,
    free: f64,
}

impl Camera {
    /// The density of camera rays, one per pixel, per solid angle around a unit direction. For parallel rays it is
    /// per perpendicular area, and the second value is `false`.
    pub fn ray_density(&self, film: &FilmDesc, direction: DVec3) -> (f64, bool) {
        let flat = |frame: &CameraFrame, half: DVec2| {
            let cos = direction.dot(frame.forward);
            1.0 / (half.x * half.y * cos * cos * cos)
        };
        let (screens, angular) = match self {
            Camera::Pinhole(c) => (flat(&c.frame, c.screen.half / c.screen.distance), true),
            Camera::ThinLens(c) => (flat(&c.frame, c.screen.half / c.screen.distance), true),
            Camera::Orthographic(c) => (1.0 / (c.half.x * c.half.y), false),
            Camera::Equirectangular(c) => (c.stretch(direction.dot(c.frame.up)), true),
            Camera::Fisheye(c) => {
                let angle = acos(direction.dot(c.frame.forward).clamp(-1.0, 1.0));
                // Circle area r dr dφ per solid angle sin θ dθ dφ, with r = θ/rim.
                let stretch = if angle > 1e-9 { angle / sin(angle) } else { 1.0 };
                (stretch / (c.rim * c.rim * c.half.x * c.half.y), true)
            }
            Camera::Realistic(c) => (c.screens(direction), true),
        };
        (0.25 * f64::from(film.width) * f64::from(film.height) * screens, angular)
    }

    /// Where the camera sees `p`, through the point of its lens given by `lens` in the unit square. `None` if `p` is
    /// behind the camera or not visible in its projection; the position may be outside the picture. Occlusion is not
    /// tested. The lens of many surfaces of [`Camera::Realistic`] is replaced by the ray through the centre of its pupil.
    pub fn project(&self, film: &FilmDesc, p: DVec3, lens: DVec2) -> Option<Projection> {
        let s = match self {
            Camera::Pinhole(c) => flat(&c.frame, &c.screen, &c.clip, DVec3::ZERO, f64::INFINITY, p)?,
            Camera::ThinLens(c) => flat(&c.frame, &c.screen, &c.clip, c.offset(lens), c.focus_distance, p)?,
            Camera::Orthographic(c) => {
                let v = p - c.frame.position;
                let depth = v.dot(c.frame.forward);
                OnScreen {
                    at: DVec2::new(v.dot(c.frame.right), v.dot(c.frame.up)) / c.half,
                    to_camera: -depth * c.frame.forward,
                    free: c.clip.free(depth)?,
                }
            }
            Camera::Equirectangular(c) => {
                let (v, d, distance) = seen_from(&c.frame, p)?;
                OnScreen { at: c.place(d), to_camera: -v, free: c.clip.free(distance)? }
            }
            Camera::Fisheye(c) => {
                let (v, d, distance) = seen_from(&c.frame, p)?;
                let angle = acos(d.z.clamp(-1.0, 1.0));
                let r = angle / c.rim;
                if r.is_nan() || r > 1.0 {
                    return None;
                }
                let across = DVec2::new(d.x, d.y);
                let out = across.length();
                let at = if out > 0.0 { across * (r / out) } else { DVec2::ZERO };
                OnScreen { at: at / c.half, to_camera: -v, free: c.clip.free(distance)? }
            }
            Camera::Realistic(c) => {
                let place = c.place(p)?;
                OnScreen { at: place.at, to_camera: place.to_camera, free: place.free }
            }
        };
        let size = DVec2::new(f64::from(film.width), f64::from(film.height));
        let place = 0.5 * size * DVec2::new(s.at.x + 1.0, 1.0 - s.at.y);
        let distance2 = s.to_camera.length_squared();
        let (rays, angular) = self.ray_density(film, -s.to_camera / distance2.sqrt());
        let density = if angular { rays / distance2 } else { rays };
        let seen = s.free > 0.0 && place.is_finite() && density > 0.0 && density.is_finite();
        seen.then_some(Projection { place, to_camera: s.to_camera, free: s.free.min(1.0), density })
    }
}

/// The vector to a point, its direction in (right, up, forward), and its length.
fn seen_from(frame: &CameraFrame, p: DVec3) -> Option<(DVec3, DVec3, f64)> {
    let v = p - frame.position;
    let distance = v.length();
    let d = DVec3::new(v.dot(frame.right), v.dot(frame.up), v.dot(frame.forward)) / distance;
    d.is_finite().then_some((v, d, distance))
}

/// Projection for a flat screen, from a lens point `offset` from its centre, with the plane of focus at a depth.
fn flat(
    frame: &CameraFrame,
    screen: &Screen,
    clip: &Clip,
    offset: DVec3,
    focus: f64,
    p: DVec3,
) -> Option<OnScreen> {
    let v = p - frame.position - offset;
    let depth = v.dot(frame.forward);
    let free = clip.free(depth)?;
    // The direction to the point at which the ray crosses the plane of focus, per unit of depth.
    let direction = v / depth + offset / focus;
    let half = screen.half / screen.distance;
    let at = DVec2::new(direction.dot(frame.right), direction.dot(frame.up)) / half - screen.shift;
    Some(OnScreen { at, to_camera: -v, free })
}

#[cfg(test)]
mod tests {
    use super::super::{
        CameraDesc, EquirectangularDesc, FisheyeDesc, Handedness, OrthographicDesc, PanoramaMapping,
        PinholeDesc, ThinLensDesc, Viewport,
    };
    use super::*;

    fn cameras() -> Vec<Camera> {
        let (position, look_at, up) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, 1.0, -2.0), DVec3::Y);
        let handedness = Handedness::Left;
        let (viewport, distance, fov) = (None, None, None);
        let pinhole = PinholeDesc {
            motion: None,
            position,
            look_at,
            up,
            handedness,
            fov,
            viewport,
            distance,
            shift: DVec2::new(0.2, -0.7),
            near: 0.3,
            far: Some(9.0),
        };
        let lens = ThinLensDesc {
            position,
            look_at,
            up,
            fov: Some(60.0),
            viewport,
            distance,
            shift: DVec2::new(-0.3, 0.1),
            far: Some(9.5),
            lens_radius: 0.4,
            blades: 5,
            blade_rotation: 10.0,
            ..ThinLensDesc::default()
        };
        let viewport = Viewport::Height(3.0);
        let descs = [
            CameraDesc::Pinhole(pinhole),
            CameraDesc::ThinLens(lens),
            CameraDesc::Orthographic(OrthographicDesc {
                motion: None,
                position,
                look_at,
                up,
                handedness,
                viewport,
                near: 0.2,
                far: Some(8.0),
            }),
            CameraDesc::Equirectangular(EquirectangularDesc {
                position,
                look_at,
                up,
                handedness,
                near: 0.1,
                far: Some(10.0),
                ..EquirectangularDesc::default()
            }),
            CameraDesc::Equirectangular(EquirectangularDesc {
                position,
                look_at,
                up,
                handedness,
                mapping: PanoramaMapping::EqualArea,
                ..EquirectangularDesc::default()
            }),
            CameraDesc::Fisheye(FisheyeDesc {
                position,
                look_at,
                up,
                handedness,
                fov: 250.0,
                near: 0.0,
                far: Some(7.5),
                motion: None,
            }),
        ];
        descs.iter().map(|c| c.prepare(1.5).unwrap()).collect()
    }

    /// The hit point of a camera ray projects back to the ray's screen position, and the density is that of
    /// neighbouring rays.
    #[test]
    fn points_of_camera_rays_project_back() {
        let film = FilmDesc { width: 300, height: 200, ..crate::description::SceneDesc::default().film };
        for camera in cameras() {
            for (x, y) in [(150.0, 100.0), (40.3, 71.9), (222.2, 150.0), (160.0, 33.0)] {
                let lens = DVec2::new(0.8, 0.3);
                let ray = |x: f64, y: f64| camera.ray(DVec2::new(x / 150.0 - 1.0, 1.0 - y / 100.0), lens);
                let (r, t) = (ray(x, y), 7.3);
                if r.t_max < 0.0 {
                    // Outside the fisheye's circle.
                    continue;
                }
                let unit = r.direction.normalize();
                let p = r.origin + t * unit;
                let s = camera.project(&film, p, lens).unwrap();
                assert!((s.place - DVec2::new(x, y)).length() < 1e-6, "{camera:?}: {} for {x} {y}", s.place);
                assert!((s.to_camera + t * unit).length() < 1e-9);
                let near = r.t_min * r.direction.length() / t;
                assert!((1.0 - s.free - near).abs() < 1e-9, "{camera:?} {} {near}", s.free);
                // The ends of the ray are what the camera sees last.
                let end = |scale: f64| {
                    let p = r.origin + scale * r.t_max * r.direction;
                    camera.project(&film, p, lens).is_some()
                };
                if r.t_max.is_finite() {
                    assert!(end(0.9999) && !end(1.0001), "{camera:?} {}", r.t_max);
                }
                // At its centre the square has no derivative: four triangles meet.
                if matches!(&camera, Camera::Equirectangular(c) if c.mapping == PanoramaMapping::EqualArea)
                    && (x, y) == (150.0, 100.0)
                {
                    continue;
                }
                // Where neighbouring rays hit the perpendicular plane.
                let hit_plane = |x: f64, y: f64| {
                    let n = ray(x, y);
                    n.origin + n.direction * ((p - n.origin).dot(unit) / n.direction.dot(unit))
                };
                let h = 1e-3;
                let area = (hit_plane(x + h, y) - hit_plane(x - h, y))
                    .cross(hit_plane(x, y + h) - hit_plane(x, y - h))
                    .length()
                    / (4.0 * h * h);
                assert!((area * s.density - 1.0).abs() < 1e-4, "{camera:?}: {} {}", 1.0 / area, s.density);
            }
            // Behind cameras with a limited field of view.
            let behind = camera.project(&film, DVec3::new(1.3, 2.5, 9.0), DVec2::splat(0.5));
            assert_eq!(behind.is_some(), matches!(camera, Camera::Equirectangular(_)), "{camera:?}");
        }
    }
}
