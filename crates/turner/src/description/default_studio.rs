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

use crate::color::Spectrum;
use crate::schema::error::escape;
use crate::schema::{Range, params};

/// Field of view of an orbit camera, degrees: that of a short telephoto lens, as products are photographed.
pub const FOV: f64 = 28.0;

/// The backdrop that the studio shows where the scene asks for none: #f5f5f5.
pub const BACKDROP: Spectrum = Spectrum::new(0.913_098_65, 0.913_098_65, 0.913_098_65);

params! {
    /// The default studio: a camera, lights and a floor. Each is added only if the scene has none of its own. A model
    /// that is rendered without a scene file (`turner model.glb`) is shown in this studio.
    pub struct StudioDesc as "studio" {
        /// The camera: the name or index of a camera of the scene's models and `[[view]]` sections, or
        /// "orbit:azimuth,elevation" or "orbit:azimuth,elevation,distance". An orbit camera looks at the scene from
        /// `azimuth` degrees to the right of the front (+z) and `elevation` degrees above the horizon, and frames it: the
        /// silhouette is in the middle of the picture and fills three quarters of its shorter side. `distance`, in radii
        /// of the bounding sphere, replaces the framed distance. A `[camera]` keeps its lens then. Without this key: the scene's own camera, else the first
        /// camera of a model, else "orbit:35,22".
        camera: Option<String> = None;
        /// Field of view along the shorter side of the picture, degrees. Without this key: that of the camera of the scene
        /// or model, 28 for an orbit camera.
        fov: Option<f64> = None, in Range::open(0.0, 180.0);
        /// Enlargement about the middle of the picture: 2 shows everything twice as large.
        zoom: f64 = 1.0, in Range::POSITIVE;
        /// The name of an object that an orbit camera frames instead of the complete scene.
        look_at: Option<String> = None;
        /// F-number of the lens, for depth of field: 2.8 blurs more than 8. The lens is that of a full-frame camera in
        /// front of an object of 30 cm, whatever the units of the scene.
        f_stop: Option<f64> = None, in Range::POSITIVE;
        /// Distance of the plane of focus along the viewing direction, in scene units. Without this key the middle of
        /// what an orbit camera frames is in focus. Without `f_stop` the f-number is then 2.8.
        focus: Option<f64> = None, in Range::POSITIVE;
        /// Whether to add a floor below the scene. Without this key, a floor is added if the scene has no camera and
        /// the background is not transparent. In front of a backdrop, an environment map or a transparent background the
        /// floor is a shadow catcher: only the shadows on it are visible. A floor that the camera looks at from below is
        /// omitted.
        ground: Option<bool> = None;
        /// The backdrop: the colour that the camera sees behind everything, instead of lights and background. It is
        /// the colour of the picture, after exposure and tone mapping: "white" is 255. Without this key it is near white if
        /// the built-in studio lights the scene and the scene has no `[background]`; otherwise `[background]` is shown.
        backdrop: Option<Spectrum> = None;
        /// Whether the built-in studio environment lights a scene without lights.
        lights: bool = true;
        /// Rotation of the studio environment about the vertical axis, degrees. With an orbit camera the lights stand
        /// relative to the camera, otherwise relative to the front (+z).
        rotation: f64 = 0.0;
        /// Factor of the radiance of the studio environment.
        strength: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Whether the exposure is chosen for the light of environment maps, so that white surfaces look white; `exposure` of
        /// `[film]` is added. It is on for models without a scene file.
        metering: bool = false;
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
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
