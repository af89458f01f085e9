//! The default studio: the camera, lights and floor that Turner adds to a scene or model without them.
//!
//! An orbit camera looks at the centre of the scene's bounding box from a direction given by two angles:
//!
//! ```text
//!    from above                         from the side
//!
//!    centre ●────────► +x                         camera
//!           │╲                                  ╱
//!           │ ╲  azimuth                      ╱  elevation
//!           │  camera                centre ●──────────── horizontal plane
//!           ▼
//!          +z (front)
//! ```

use crate::camera::{CameraDesc, PinholeDesc};
use crate::math::elementary::{cos, sin, tan};
use crate::math::{Bounds, DVec3, radians};
use crate::schema::error::escape;
use crate::schema::{Range, params};

/// Vertical field of view of an orbit camera, degrees.
pub const FOV: f64 = 38.0;

params! {
    /// The default studio: a camera, lights and a floor. Each is added only if the scene has none of its own. A model
    /// that is rendered without a scene file (`turner model.glb`) is shown in this studio.
    pub struct StudioDesc as "studio" {
        /// The camera: the name or index of a camera of the scene's models and `[[view]]` sections, or
        /// "orbit:azimuth,elevation" or "orbit:azimuth,elevation,distance". An orbit camera looks at the centre of the
        /// scene, from `azimuth` degrees to the right of the front (+z) and `elevation` degrees above the horizon, at a
        /// distance in radii of the bounding sphere. Without this key: the scene's own camera, else the first camera of
        /// a model, else "orbit:35,22".
        camera: Option<String> = None;
        /// Vertical field of view of an orbit camera, degrees. In portrait format it is the horizontal field of view.
        fov: f64 = FOV, in Range::open(0.0, 180.0);
        /// Whether to add a floor below the scene. Without this key, a floor is added if the scene has no camera and
        /// the background is not transparent.
        ground: Option<bool> = None;
        /// Whether the built-in studio environment lights a scene without lights.
        lights: bool = true;
        /// Rotation of the studio environment about the vertical axis, degrees.
        rotation: f64 = 0.0;
        /// Factor of the radiance of the studio environment.
        strength: f64 = 1.0, in Range::NON_NEGATIVE;
    }
    example r##"[studio]
camera = "orbit:20,30"

[[object]]
type = "model"
file = "model.obj"
"##
}

/// An orbit camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Degrees to the right of +z.
    pub azimuth: f64,
    /// Degrees above the horizon.
    pub elevation: f64,
    /// Distance from the centre, in radii of the bounding sphere. `None` chooses a distance that shows the complete
    /// scene.
    pub distance: Option<f64>,
}

impl Orbit {
    /// From the front right and above, so that three sides of a box are visible.
    pub const DEFAULT: Orbit = Orbit { azimuth: 35.0, elevation: 22.0, distance: None };

    /// Parses `orbit:azimuth,elevation[,distance]`; `None` for other text.
    ///
    /// Errors: numbers that are missing, non-finite, or a distance that is not positive.
    pub fn parse(text: &str) -> Option<Result<Orbit, String>> {
        let numbers = text.strip_prefix("orbit")?;
        let Some(numbers) = numbers.strip_prefix(':') else {
            return numbers.is_empty().then_some(Ok(Orbit::DEFAULT));
        };
        let read: Result<Vec<f64>, _> = numbers.split(',').map(|n| n.trim().parse::<f64>()).collect();
        Some(match read.as_deref() {
            Ok(&[azimuth, elevation]) if azimuth.is_finite() && elevation.is_finite() => {
                Ok(Orbit { azimuth, elevation, distance: None })
            }
            Ok(&[azimuth, elevation, distance])
                if azimuth.is_finite() && elevation.is_finite() && distance > 0.0 && distance.is_finite() =>
            {
                Ok(Orbit { azimuth, elevation, distance: Some(distance) })
            }
            _ => Err(format!(
                "expected orbit:azimuth,elevation or orbit:azimuth,elevation,distance (a distance above 0), found \"{}\"",
                escape(text)
            )),
        })
    }

    /// The camera that shows the box `bounds`. `fov` is in degrees, `aspect` is width over height.
    pub fn camera(&self, bounds: &Bounds, fov: f64, aspect: f64) -> CameraDesc {
        let finite = !bounds.is_empty() && bounds.is_finite();
        let (center, radius) =
            if finite { (bounds.center(), 0.5 * bounds.size().length()) } else { (DVec3::ZERO, 1.0) };
        // A bounding box of size 0 gets a small radius.
        let radius = if radius > 0.0 { radius } else { 1e-3 * (1.0 + center.abs().max_element()) };
        let (azimuth, elevation) = (radians(self.azimuth), radians(self.elevation));
        let back = DVec3::new(sin(azimuth) * cos(elevation), sin(elevation), cos(azimuth) * cos(elevation));
        // If the camera looks straight up or down, the front is at the lower edge of the picture.
        let up = if cos(elevation).abs() > 1e-6 { DVec3::Y } else { -sin(elevation).signum() * DVec3::Z };
        let up = if cos(elevation) < -1e-6 { -up } else { up };
        let half_height = if aspect >= 1.0 {
            radians(0.5 * fov)
        } else {
            crate::math::elementary::atan2(tan(radians(0.5 * fov)), aspect)
        };
        let (tan_y, tan_x) = (tan(half_height), tan(half_height) * aspect);
        let distance = match self.distance {
            Some(radii) => radii * radius,
            None => fitting_distance(bounds, center, radius, back, up, [tan_x, tan_y]),
        };
        CameraDesc::Pinhole(PinholeDesc {
            position: center + distance * back,
            look_at: center,
            up,
            fov: Some(2.0 * half_height.to_degrees()),
            ..PinholeDesc::default()
        })
    }
}

/// The smallest distance at which all corners of the box are visible with a margin of 8 %, and at least 1.05 radii of
/// the bounding sphere.
fn fitting_distance(
    bounds: &Bounds,
    center: DVec3,
    radius: f64,
    back: DVec3,
    up: DVec3,
    tangents: [f64; 2],
) -> f64 {
    let mut distance = 1.05 * radius;
    if bounds.is_empty() || !bounds.is_finite() {
        return 3.0 * radius;
    }
    let right = up.cross(back).try_normalize().unwrap_or(DVec3::X);
    let up = back.cross(right);
    for corner in bounds.corners() {
        let corner = corner - center;
        for (axis, tangent) in [(right, tangents[0]), (up, tangents[1])] {
            distance = distance.max(corner.dot(back) + 1.08 * corner.dot(axis).abs() / tangent);
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec2;

    #[test]
    fn words_for_orbits() {
        assert_eq!(Orbit::parse("orbit"), Some(Ok(Orbit::DEFAULT)));
        let orbit = Orbit { azimuth: -20.0, elevation: 30.5, distance: Some(4.0) };
        assert_eq!(Orbit::parse("orbit:-20, 30.5,4"), Some(Ok(orbit)));
        assert_eq!(Orbit::parse("Camera.001"), None);
        for bad in ["orbit:", "orbit:1", "orbit:1,2,0", "orbit:1,2,3,4", "orbit:nan,1", "orbit:a,b"] {
            assert!(Orbit::parse(bad).unwrap().is_err(), "{bad}");
        }
    }

    #[test]
    fn every_corner_is_in_the_picture_from_everywhere() {
        let boxes = [
            Bounds::new(DVec3::new(-1.0, 0.0, -4.0), DVec3::new(2.0, 9.0, 4.0)),
            Bounds::new(DVec3::new(1e6, 0.0, 0.0), DVec3::new(1e6 + 1.0, 0.0, 100.0)),
            Bounds::new(DVec3::splat(-1e-6), DVec3::splat(1e-6)),
        ];
        for bounds in boxes {
            for (azimuth, elevation) in
                [(35.0, 22.0), (0.0, 90.0), (200.0, -90.0), (90.0, 0.0), (300.0, -60.0)]
            {
                for aspect in [0.3, 1.0, 2.5] {
                    let orbit = Orbit { azimuth, elevation, distance: None };
                    let desc = orbit.camera(&bounds, 38.0, aspect);
                    let camera = desc.prepare(aspect).unwrap();
                    let CameraDesc::Pinhole(desc) = desc else { panic!("an orbit is a pinhole camera") };
                    let ray = |x, y| camera.ray(DVec2::new(x, y), DVec2::ZERO).direction;
                    let forward = ray(0.0, 0.0).normalize();
                    // The picture's edges as planes through the camera position.
                    let (right, up) = (ray(1.0, 0.0) - ray(-1.0, 0.0), ray(0.0, 1.0) - ray(0.0, -1.0));
                    let scale = ray(0.0, 0.0).length();
                    for corner in bounds.corners() {
                        let p = corner - desc.position;
                        let depth = p.dot(forward);
                        assert!(depth > 0.0);
                        for axis in [right, up] {
                            let reach = 0.5 * axis.length() / scale * depth;
                            assert!(p.dot(axis.normalize()).abs() <= reach, "{azimuth} {elevation} {aspect}");
                        }
                    }
                }
            }
        }
    }
}
