//! Light from one direction, infinitely far away.

use std::f64::consts::{PI, TAU};

use super::Illumination;
use crate::color::Spectrum;
use crate::math::elementary::{cos, sin, sin_cos_turns};
use crate::math::{DVec3, Frame, radians};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// Light from infinitely far away, like the sun's: all its rays are parallel, or, with an `angle`, come from a disc of the sky. Say where it comes `from`, or in which `direction` it shines.
    pub struct DirectionalDesc as "directional" {
        /// The direction it comes from, of any length.
        from: Option<DVec3> = None;
        /// The direction it shines in, of any length: the opposite of `from`.
        direction: Option<DVec3> = None;
        /// Its colour.
        color: Spectrum = Spectrum::WHITE;
        /// Its strength.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Angle from one side of the light to the other, degrees: that of the sun is 0.53. Shadows get soft rims, glossy things and rays that hit nothing show a bright disc, and what arrives at a
        /// surface that faces it stays the same. 0 is a light without extent. The classic integrator asks sixteen places of the disc for its shadows, and does not show it.
        angle: f64 = 0.0, in Range::closed(0.0, 180.0);
        /// A ray within this angle (degrees) of the direction it comes from looks along it: see the integrator's `light_seen`.
        seen_angle: f64 = 0.25, in Range::closed(0.0, 180.0);
    }
    example r#"[[light]]
type = "directional"
from = [1, 4, 4]
intensity = 0.6
angle = 2
"#
}

/// A directional light, prepared.
#[derive(Clone, Copy, Debug)]
pub struct Directional {
    /// BsdfFromWo the light, unit.
    pub to_light: DVec3,
    /// The same with the length it was given: the classic documents measure shadow rays in it.
    given: DVec3,
    /// Colour times intensity.
    pub intensity: Spectrum,
    cos_seen: f64,
    disc: Option<Disc>,
}

/// A round part of the sky that shines evenly.
#[derive(Clone, Copy, Debug)]
struct Disc {
    /// Around the direction to its middle.
    frame: Frame,
    /// 1 − cos of half its angle.
    cap: f64,
    radiance: Spectrum,
}

impl Disc {
    /// Half of `angle` degrees around `to_light`; what arrives at a surface that faces it is `irradiance`. `None` if the angle is too small
    /// for a disc.
    fn new(to_light: DVec3, angle: f64, irradiance: Spectrum) -> Option<Disc> {
        let sin_quarter = sin(radians(0.25 * angle));
        let cap = 2.0 * sin_quarter * sin_quarter;
        // ∫ cos θ over the disc: π sin² of half the angle.
        let projected = PI * cap * (2.0 - cap);
        let radiance = irradiance * (1.0 / projected) as f32;
        // Single precision holds no more light than that; directions of double precision no smaller disc.
        (cap > 1e-15 && radiance.is_finite()).then(|| Disc { frame: Frame::from_z(to_light), cap, radiance })
    }

    fn pdf(&self) -> f64 {
        1.0 / (TAU * self.cap)
    }
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
        let intensity = self.color * self.intensity as f32;
        let disc = Disc::new(to_light, self.angle, intensity);
        Ok(Directional { to_light, given, intensity, cos_seen, disc })
    }
}

impl Directional {
    #[inline]
    pub(super) fn illuminate(&self) -> Illumination {
        Illumination { to_light: self.given, finite: false, intensity: self.intensity }
    }

    /// Whether it has an extent.
    pub fn is_disc(&self) -> bool {
        self.disc.is_some()
    }

    /// For a light with an extent: a unit direction towards it, evenly chosen by `u`, its radiance, and the density per solid angle.
    #[inline]
    pub fn sample(&self, u: [f64; 2]) -> Option<(DVec3, Spectrum, f64)> {
        let disc = self.disc.as_ref()?;
        let x = u[0] * disc.cap;
        let (cos, sin) = (1.0 - x, (x * (2.0 - x)).max(0.0).sqrt());
        let (s, c) = sin_cos_turns(u[1]);
        Some((disc.frame.to_world(DVec3::new(sin * c, sin * s, cos)), disc.radiance, disc.pdf()))
    }

    /// For a light with an extent: what a ray in a unit direction finds of it, with the density of [`Directional::sample`]; `None` beside it.
    #[inline]
    pub fn found(&self, direction: DVec3) -> Option<(Spectrum, f64)> {
        let disc = self.disc.as_ref()?;
        // 1 − cos of the angle between them is half the square of the chord: exact however small it is.
        let inside = 0.5 * direction.distance_squared(self.to_light) <= disc.cap;
        inside.then(|| (disc.radiance, disc.pdf()))
    }

    /// Whether a ray in this unit direction looks along the light.
    pub fn is_seen(&self, direction: DVec3) -> bool {
        direction.dot(self.to_light) >= self.cos_seen - 1e-12
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec2;
    use crate::math::elementary::atan2;

    fn light(angle: f64) -> Directional {
        let desc = DirectionalDesc {
            from: Some(DVec3::new(1.0, 2.0, -0.5)),
            color: Spectrum::new(1.0, 0.5, 0.25),
            intensity: 3.0,
            angle,
            ..DirectionalDesc::default()
        };
        desc.prepare().unwrap()
    }

    #[test]
    fn a_disc_brings_what_a_point_brings() {
        for angle in [1e-5, 0.01, 0.53, 30.0, 180.0] {
            let light = light(angle);
            let (mut sum, n) = (0.0, 200);
            let mut widest = 0.0_f64;
            for i in 0..n * n {
                let u = (DVec2::new(f64::from(i % n), f64::from(i / n)) + 0.5) / f64::from(n);
                let (d, radiance, pdf) = light.sample(u.into()).unwrap();
                assert!((d.length() - 1.0).abs() < 1e-12);
                assert_eq!(light.found(d), Some((radiance, pdf)));
                sum += f64::from(radiance.r) * d.dot(light.to_light) / pdf;
                widest = widest.max(atan2(d.cross(light.to_light).length(), d.dot(light.to_light)));
            }
            // Irradiance on a surface that faces it, and the rim.
            assert!((sum / f64::from(n * n) - 3.0).abs() < 1e-4, "{angle}: {sum}");
            let half = radians(0.5 * angle);
            assert!(widest <= half * (1.0 + 1e-6) && widest > half * 0.99, "{angle}: {widest}");
            let beside =
                Frame::from_z(light.to_light).to_world(DVec3::new(sin(1.001 * half), 0.0, cos(1.001 * half)));
            assert_eq!(light.found(beside), None, "{angle}");
            assert_eq!(light.found(-light.to_light), None);
        }
        // Without extent, or with one that is none.
        for angle in [0.0, 1e-7, 1e-300] {
            assert!(!light(angle).is_disc() && light(angle).sample([0.5, 0.5]).is_none());
        }
    }
}
