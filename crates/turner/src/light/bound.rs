//! Bounds of a light: where it is, the directions in which it emits, and how strongly.

use super::{Attenuation, Light};
use crate::math::DVec3;

/// A bounding sphere of an emitter and a cone that bounds its emission (Conty Estevez and Kulla 2018, "Importance
/// Sampling of Many Lights with Adaptive Tree Splitting", section 4.1).
///
/// ```text
///         axis
///    \  θo |  /       the normals of the emitter lie within θo of the axis;
///     \    | /        each point emits within θe of its normal,
///   θe \   |/ θe      so nothing is emitted beyond θo + θe from the axis
///    ---( light )---
/// ```
///
/// At distance d, in a direction at the angle θ from the nearest normal, about power · cos θ / d² arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBound {
    /// Centre of the bounding sphere.
    pub center: DVec3,
    /// Its radius, 0 or more.
    pub radius: f64,
    /// The axis, unit; arbitrary where `cos_o` is −1.
    pub axis: DVec3,
    /// Cosine of θo.
    pub cos_o: f64,
    /// Cosine of θe, which is at most 90 degrees.
    pub cos_e: f64,
    /// Whether it emits in the same way around the opposite of the axis.
    pub two_sided: bool,
    /// Intensity along the nearest normal, in a unit common to all lights.
    pub power: f64,
}

impl LightBound {
    /// Bound of an emitter in all directions.
    pub fn everywhere(center: DVec3, radius: f64, power: f64) -> LightBound {
        LightBound { center, radius, axis: DVec3::Y, cos_o: -1.0, cos_e: 0.0, two_sided: false, power }
    }

    /// Bound of a flat Lambertian emitter, on the side of its unit normal or on both.
    pub fn flat(center: DVec3, radius: f64, normal: DVec3, two_sided: bool, power: f64) -> LightBound {
        LightBound { center, radius, axis: normal, cos_o: 1.0, cos_e: 0.0, two_sided, power }
    }

    /// Bound of a spot light: full intensity up to an angle from the axis, none beyond another, given by their
    /// cosines.
    pub(super) fn cone(center: DVec3, axis: DVec3, cos_full: f64, cos_rim: f64, power: f64) -> LightBound {
        let sin = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
        let (sin_full, sin_rim) = (sin(cos_full), sin(cos_rim));
        // The cosine of the penumbra's width. A penumbra wider than 90 degrees counts as full except in its last 90
        // degrees.
        let cos_width = cos_full * cos_rim + sin_full * sin_rim;
        let (cos_o, cos_e) = if cos_width > 0.0 {
            (cos_full, cos_width)
        } else if cos_rim < 0.0 {
            // The rim angle minus 90 degrees.
            (sin_rim, 0.0)
        } else {
            (1.0, 0.0)
        };
        LightBound { center, radius: 0.0, axis, cos_o, cos_e, two_sided: false, power }
    }
}

impl Attenuation {
    /// The factor far away times the square of the distance; `None` if the falloff is not inverse-square far away.
    pub(super) fn far(&self) -> Option<f64> {
        let [_, _, q] = self.coefficients;
        let far = 1.0 / q;
        (far > 0.0 && far.is_finite()).then_some(far)
    }
}

impl Light {
    /// Its bounds, if it is at a finite distance and falls off with the square of the distance, at least far away.
    pub fn bound(&self) -> Option<LightBound> {
        match self {
            Light::Point(l) => l.bound(),
            Light::Spot(l) => l.bound(),
            Light::Area(l) => l.bound(),
            Light::Directional(_) | Light::Environment(_) => None,
        }
    }
}
