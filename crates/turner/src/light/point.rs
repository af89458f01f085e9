//! Point light.

use super::profile::OrientedProfile;
use super::{Attenuation, DEFAULT_POSITION, Illumination, LightBound, ProfileUnits, Uniform};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ProfileFile, Range, SceneError, params};

params! {
    /// Light from one point, equal in all directions. Casts sharp shadows.
    pub struct PointDesc as "point" {
        /// Position of the light.
        position: DVec3, required, default DEFAULT_POSITION;
        /// Colour of the light.
        color: Spectrum = Spectrum::WHITE;
        /// Strength of the light.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How the light falls off with distance.
        attenuation: Attenuation = Attenuation::NONE;
        /// IES file (LM-63) with the measured intensity in each direction, as a path relative to the scene file.
        /// Photometry of types A, B and C is read.
        ies: Option<ProfileFile> = None;
        /// How the values of the IES file are used.
        ies_units: ProfileUnits = ProfileUnits::Relative;
        /// Axis of the IES profile: the direction of the vertical angle 0, in which such a light points.
        ies_axis: DVec3 = DVec3::NEG_Y;
        /// Rotation of the IES profile about its axis, degrees, counter-clockwise as seen from behind the light (from
        /// above for a light that points down). At 0 the horizontal angle 0 points towards +x.
        ies_rotation: f64 = 0.0;
    }
    example r#"[[light]]
type = "point"
position = [3, 5, 4]
intensity = 0.8
"#
}

/// A point light, prepared.
#[derive(Clone, Debug)]
pub struct Point {
    position: DVec3,
    intensity: Spectrum,
    attenuation: Attenuation,
    profile: Option<OrientedProfile>,
}

impl PointDesc {
    pub(super) fn prepare(&self) -> Result<Point, SceneError> {
        let intensity = self.color * self.intensity as f32;
        let orient = |file| OrientedProfile::new(file, self.ies_axis, self.ies_rotation, self.ies_units);
        let profile = self.ies.as_ref().map(orient).transpose()?;
        Ok(Point { position: self.position, intensity, attenuation: self.attenuation, profile })
    }
}

impl Point {
    pub(super) fn uniform(&self) -> Option<Uniform> {
        (self.attenuation == Attenuation::NONE && self.profile.is_none())
            .then_some(Uniform::Point { position: self.position, intensity: self.intensity })
    }

    /// Its position.
    pub(super) fn position(&self) -> DVec3 {
        self.position
    }

    pub(super) fn bound(&self) -> Option<LightBound> {
        let power = f64::from(self.intensity.luminance()) * self.attenuation.far()?;
        Some(match &self.profile {
            Some(profile) => {
                let (axis, cos) = profile.cone();
                LightBound::cone(self.position, axis, cos, cos, power * profile.peak())
            }
            None => LightBound::everywhere(self.position, 0.0, power),
        })
    }

    #[inline]
    pub(super) fn illuminate(&self, p: DVec3) -> Option<Illumination> {
        let mut light = from_point(self.position, self.intensity, &self.attenuation, p)?;
        if let Some(profile) = &self.profile {
            light.intensity *= profile.factor(-light.to_light);
        }
        Some(light)
    }
}

/// Light from a point. `None` at the point itself, where there is no direction.
#[inline]
pub(super) fn from_point(
    position: DVec3,
    intensity: Spectrum,
    attenuation: &Attenuation,
    p: DVec3,
) -> Option<Illumination> {
    let to_light = position - p;
    let d2 = to_light.length_squared();
    if d2 == 0.0 {
        return None;
    }
    let factor = if *attenuation == Attenuation::NONE { 1.0 } else { attenuation.factor(d2.sqrt()) };
    Some(Illumination { to_light, finite: true, intensity: intensity * factor as f32 })
}
