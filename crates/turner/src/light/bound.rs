//! Bounds of what shines: where it is, where it shines to, and how strongly.

use super::{Attenuation, Light};
use crate::math::DVec3;

/// A sphere around something that shines, and a cone that its light does not leave (Conty Estevez and Kulla 2018, "Importance Sampling of Many
/// Lights with Adaptive Tree Splitting", section 4.1).
///
/// Its normals lie within the angle θo of the axis, and each of its points shines no farther than θe from its normal. What
/// arrives at the distance d, in a direction at the angle θ from the nearest normal, is about power · cos θ / d².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBound {
    /// The middle of the sphere.
    pub center: DVec3,
    /// Its radius, 0 or more.
    pub radius: f64,
    /// The axis, unit; anything where `cos_o` is −1.
    pub axis: DVec3,
    /// Cosine of θo.
    pub cos_o: f64,
    /// Cosine of θe, which is at most 90 degrees.
    pub cos_e: f64,
    /// Whether it shines around the opposite of the axis in the same way.
    pub two_sided: bool,
    /// Intensity along the nearest normal, in units that all lights share.
    pub power: f64,
}

impl LightBound {
    /// Of something that shines in all directions.
    pub fn everywhere(center: DVec3, radius: f64, power: f64) -> LightBound {
        LightBound { center, radius, axis: DVec3::Y, cos_o: -1.0, cos_e: 0.0, two_sided: false, power }
    }

    /// Of something flat that shines by the cosine, on the side of its unit normal or on both.
    pub fn flat(center: DVec3, radius: f64, normal: DVec3, two_sided: bool, power: f64) -> LightBound {
        LightBound { center, radius, axis: normal, cos_o: 1.0, cos_e: 0.0, two_sided, power }
    }

    /// Of a cone of light from a point: full up to an angle from the axis and none beyond another, by their cosines.
    pub(super) fn cone(center: DVec3, axis: DVec3, cos_full: f64, cos_rim: f64, power: f64) -> LightBound {
        let sin = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
        let (sin_full, sin_rim) = (sin(cos_full), sin(cos_rim));
        // The cosine of the rim's width. A rim of more than 90 degrees counts as full beyond the last 90.
        let cos_width = cos_full * cos_rim + sin_full * sin_rim;
        let (cos_o, cos_e) = if cos_width > 0.0 {
            (cos_full, cos_width)
        } else if cos_rim < 0.0 {
            // The angle of the rim less 90 degrees.
            (sin_rim, 0.0)
        } else {
            (1.0, 0.0)
        };
        LightBound { center, radius: 0.0, axis, cos_o, cos_e, two_sided: false, power }
    }
}

impl Attenuation {
    /// What light comes to far away, times the square of the distance; `None` if it weakens in another way.
    pub(super) fn far(&self) -> Option<f64> {
        let [_, _, q] = self.coefficients;
        let far = 1.0 / q;
        (far > 0.0 && far.is_finite()).then_some(far)
    }
}

impl Light {
    /// Its bounds, if it has a place and weakens by the square of the distance, at least far away.
    pub fn bound(&self) -> Option<LightBound> {
        match self {
            Light::Point(l) => l.bound(),
            Light::Spot(l) => l.bound(),
            Light::Area(l) => l.bound(),
            Light::Directional(_) | Light::Environment(_) => None,
        }
    }
}
