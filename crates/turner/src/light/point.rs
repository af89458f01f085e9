//! Light from one point.

use super::profile::Lamp;
use super::{Attenuation, Illumination, LAMP, LightBound, ProfileUnits, Uniform};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ProfileFile, Range, SceneError, params};

params! {
    /// Light from one point, in all directions alike. Casts sharp shadows.
    pub struct PointDesc as "point" {
        /// Where it is.
        position: DVec3, required, default LAMP;
        /// Its colour.
        color: Spectrum = Spectrum::WHITE;
        /// Its strength.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How it weakens with distance.
        attenuation: Attenuation = Attenuation::NONE;
        /// Measurements that say how strongly it shines in each direction, relative to the scene file: IES (LM-63), photometry of types A, B and C.
        ies: Option<ProfileFile> = None;
        /// What the numbers of `ies` mean.
        ies_units: ProfileUnits = ProfileUnits::Relative;
        /// Where the vertical angle 0 of `ies` points: where such a lamp shines.
        ies_axis: DVec3 = DVec3::NEG_Y;
        /// Degrees by which the lamp is turned about that axis, against the clock if one looks against it. At 0 the horizontal angle 0 lies towards +x.
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
    lamp: Option<Lamp>,
}

impl PointDesc {
    pub(super) fn prepare(&self) -> Result<Point, SceneError> {
        let intensity = self.color * self.intensity as f32;
        let lamp = |file| Lamp::new(file, self.ies_axis, self.ies_rotation, self.ies_units);
        let lamp = self.ies.as_ref().map(lamp).transpose()?;
        Ok(Point { position: self.position, intensity, attenuation: self.attenuation, lamp })
    }
}

impl Point {
    pub(super) fn uniform(&self) -> Option<Uniform> {
        (self.attenuation == Attenuation::NONE && self.lamp.is_none())
            .then_some(Uniform::Point { position: self.position, intensity: self.intensity })
    }

    /// Where it is.
    pub(super) fn position(&self) -> DVec3 {
        self.position
    }

    pub(super) fn bound(&self) -> Option<LightBound> {
        let power = f64::from(self.intensity.luminance()) * self.attenuation.far()?;
        Some(match &self.lamp {
            Some(lamp) => {
                let (axis, cos) = lamp.cone();
                LightBound::cone(self.position, axis, cos, cos, power * lamp.peak())
            }
            None => LightBound::everywhere(self.position, 0.0, power),
        })
    }

    #[inline]
    pub(super) fn illuminate(&self, p: DVec3) -> Option<Illumination> {
        let mut light = from_point(self.position, self.intensity, &self.attenuation, p)?;
        if let Some(lamp) = &self.lamp {
            light.intensity *= lamp.factor(-light.to_light);
        }
        Some(light)
    }
}

/// Light from a point; none at the point itself, where it has no direction.
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
