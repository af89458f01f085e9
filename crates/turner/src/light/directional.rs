//! Light from one direction, infinitely far away.

use super::Illumination;
use crate::color::Spectrum;
use crate::math::{DVec3, elementary::cos, radians};
use crate::scene::error::{ErrorCode, SceneError};
use crate::scene::schema::{Range, params};

params! {
    /// Light from infinitely far away, like the sun's: all its rays are parallel. Say where it comes `from`, or in which `direction` it shines.
    pub struct DirectionalDesc as "directional" {
        /// The direction it comes from, of any length.
        from: Option<DVec3> = None;
        /// The direction it shines in, of any length: the opposite of `from`.
        direction: Option<DVec3> = None;
        /// Its colour.
        color: Spectrum = Spectrum::WHITE;
        /// Its strength.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// A ray within this angle (degrees) of the direction it comes from looks along it: see the integrator's `light_seen`.
        seen_angle: f64 = 0.25, in Range::closed(0.0, 180.0);
    }
    example r#"[[light]]
type = "directional"
from = [1, 4, 4]
intensity = 0.6
"#
}

/// A directional light, prepared.
#[derive(Clone, Copy, Debug)]
pub struct Directional {
    /// Towards the light, unit.
    pub to_light: DVec3,
    /// The same with the length it was given: the classic documents measure shadow rays in it.
    given: DVec3,
    /// Colour times intensity.
    pub intensity: Spectrum,
    cos_seen: f64,
}

impl DirectionalDesc {
    pub(super) fn prepare(&self) -> Result<Directional, SceneError> {
        let given = match (self.from, self.direction) {
            (Some(from), None) => from,
            (None, Some(direction)) => -direction,
            (Some(_), Some(_)) => {
                let message = "`from` and `direction` are two ways to say the same: give one of them";
                return Err(SceneError::new(ErrorCode::Conflict, message));
            }
            (None, None) => {
                let message =
                    "a directional light needs `from` (where it comes from) or `direction` (where it shines)";
                return Err(SceneError::new(ErrorCode::MissingKey, message));
            }
        };
        let to_light = given.try_normalize().ok_or_else(|| {
            SceneError::new(ErrorCode::OutOfRange, "the direction of a directional light must not be zero")
        })?;
        let cos_seen = cos(radians(self.seen_angle));
        Ok(Directional { to_light, given, intensity: self.color * self.intensity as f32, cos_seen })
    }
}

impl Directional {
    #[inline]
    pub(super) fn illuminate(&self) -> Illumination {
        Illumination { to_light: self.given, finite: false, intensity: self.intensity }
    }

    /// Whether a ray in this unit direction looks along the light.
    pub fn is_seen(&self, direction: DVec3) -> bool {
        direction.dot(self.to_light) >= self.cos_seen - 1e-12
    }
}
