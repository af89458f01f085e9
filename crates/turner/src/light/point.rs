//! Light from one point.

use super::{Attenuation, Illumination, Uniform};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::scene::schema::{Range, params};

params! {
    /// Light from one point, in all directions alike. Casts sharp shadows.
    pub struct PointDesc as "point" {
        /// Where it is.
        position: DVec3;
        /// Its colour.
        color: Spectrum = Spectrum::WHITE;
        /// Its strength.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How it weakens with distance.
        attenuation: Attenuation = Attenuation::NONE;
    }
    example r#"[[light]]
type = "point"
position = [3, 5, 4]
intensity = 0.8
"#
}

/// A point light, prepared.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    position: DVec3,
    intensity: Spectrum,
    attenuation: Attenuation,
}

impl PointDesc {
    pub(super) fn prepare(&self) -> Point {
        let intensity = self.color * self.intensity as f32;
        Point { position: self.position, intensity, attenuation: self.attenuation }
    }
}

impl Point {
    pub(super) fn uniform(&self) -> Option<Uniform> {
        (self.attenuation == Attenuation::NONE)
            .then_some(Uniform::Point { position: self.position, intensity: self.intensity })
    }

    #[inline]
    pub(super) fn illuminate(&self, p: DVec3) -> Option<Illumination> {
        from_point(self.position, self.intensity, &self.attenuation, p)
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
