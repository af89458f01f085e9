//! Light from one point into a cone.

use super::point::from_point;
use super::profile::Lamp;
use super::{Attenuation, Illumination, LAMP, LightBound, ProfileUnits};
use crate::color::Spectrum;
use crate::math::elementary::cos;
use crate::math::{DVec3, radians};
use crate::schema::{ErrorCode, ProfileFile, Range, SceneError, params};

params! {
    /// Light from one point into a cone, with a soft rim.
    pub struct SpotDesc as "spot" {
        /// Where it is.
        position: DVec3, required, default LAMP;
        /// The point it shines at.
        look_at: DVec3 = DVec3::ZERO;
        /// Angle from the axis to the rim, degrees; beyond it there is no light.
        angle: f64 = 30.0, in Range { min: 0.0, open_min: true, max: 180.0, open_max: false };
        /// Width of the soft rim, degrees inwards from `angle`.
        penumbra: f64 = 5.0, in Range::closed(0.0, 180.0);
        /// Its colour.
        color: Spectrum = Spectrum::WHITE;
        /// Its strength on the axis.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How it weakens with distance.
        attenuation: Attenuation = Attenuation::NONE;
        /// Measurements that say how strongly it shines in each direction, as for the point light; within its cone.
        ies: Option<ProfileFile> = None;
        /// What the numbers of `ies` mean.
        ies_units: ProfileUnits = ProfileUnits::Relative;
        /// Degrees by which the lamp is turned about its axis.
        ies_rotation: f64 = 0.0;
    }
    example r#"[[light]]
type = "spot"
position = [0, 5, 3]
look_at = [0, 0, 0]
angle = 20
penumbra = 6
"#
}

/// A spot light, prepared.
#[derive(Clone, Debug)]
pub struct Spot {
    position: DVec3,
    axis: DVec3,
    /// Cosine of the angle at the rim, and of that where the full light begins.
    cos_rim: f64,
    cos_full: f64,
    intensity: Spectrum,
    attenuation: Attenuation,
    lamp: Option<Lamp>,
}

impl SpotDesc {
    pub(super) fn prepare(&self) -> Result<Spot, SceneError> {
        let axis = (self.look_at - self.position).try_normalize().ok_or_else(|| {
            SceneError::new(
                ErrorCode::OutOfRange,
                "a spot light's `position` and `look_at` are the same point",
            )
        })?;
        let lamp = |file| Lamp::new(file, axis, self.ies_rotation, self.ies_units);
        let lamp = self.ies.as_ref().map(lamp).transpose()?;
        Ok(Spot {
            position: self.position,
            axis,
            cos_rim: cos(radians(self.angle)),
            cos_full: cos(radians((self.angle - self.penumbra).max(0.0))),
            intensity: self.color * self.intensity as f32,
            attenuation: self.attenuation,
            lamp,
        })
    }
}

impl Spot {
    /// Where it is.
    pub(super) fn position(&self) -> DVec3 {
        self.position
    }

    pub(super) fn bound(&self) -> Option<LightBound> {
        let peak = self.lamp.as_ref().map_or(1.0, Lamp::peak);
        let power = f64::from(self.intensity.luminance()) * peak * self.attenuation.far()?;
        Some(LightBound::cone(self.position, self.axis, self.cos_full, self.cos_rim, power))
    }

    #[inline]
    pub(super) fn illuminate(&self, p: DVec3) -> Option<Illumination> {
        let mut light = from_point(self.position, self.intensity, &self.attenuation, p)?;
        let cos = -light.to_light.dot(self.axis) / light.to_light.length();
        if cos < self.cos_rim {
            return None;
        }
        if let Some(lamp) = &self.lamp {
            light.intensity *= lamp.factor(-light.to_light);
        }
        if cos < self.cos_full {
            // Hermite's smooth step over the rim.
            let x = (cos - self.cos_rim) / (self.cos_full - self.cos_rim);
            light.intensity *= (x * x * (3.0 - 2.0 * x)) as f32;
        }
        Some(light)
    }
}
