//! Directional light: infinitely far away.

use std::f64::consts::{PI, TAU};

use super::Illumination;
use crate::color::Spectrum;
use crate::math::elementary::{cos, sin, sin_cos_turns};
use crate::math::{DVec3, Frame, radians};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// Light from infinitely far away, such as the sun. Its rays are parallel, or come from a disc in the sky if
    /// `angle` is set. Give either `from` or `direction`.
    pub struct DirectionalDesc as "directional" {
        /// The direction that the light comes from, of any length.
        from: Option<DVec3> = None;
        /// The direction in which the light travels, of any length: the opposite of `from`.
        direction: Option<DVec3> = None;
        /// Colour of the light.
        color: Spectrum = Spectrum::WHITE;
        /// Strength of the light.
        intensity: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Angular diameter of the light, in degrees; the sun's is 0.53. Shadows get soft edges, and glossy
        /// surfaces and rays that hit nothing show a bright disc. The irradiance of a surface that faces the light
        /// stays the same. At 0 the light has no extent. The classic integrator takes sixteen shadow rays to the disc
        /// and does not show it.
        angle: f64 = 0.0, in Range::closed(0.0, 180.0);
        /// A ray within this angle (degrees) of the direction that the light comes from sees the light: see the
        /// integrator's `light_seen`.
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
    /// Towards the light, unit.
    pub to_light: DVec3,
    /// Towards the light with the length given in the scene: classic ray tracing measures shadow rays in it.
    given: DVec3,
    /// Colour times intensity.
    pub intensity: Spectrum,
    cos_seen: f64,
    disc: Option<Disc>,
}

/// A disc of constant radiance in the sky.
///
/// ```text
///       ___
///     /  |  \   half angle α, cap = 1 − cos α
///     \__|__/   solid angle 2π·cap
///      \ | /    projected solid angle π sin² α = π·cap·(2 − cap)
///       \|/
///        p
/// ```
#[derive(Clone, Copy, Debug)]
struct Disc {
    /// z axis towards the centre of the disc.
    frame: Frame,
    /// 1 − cos of half the angle.
    cap: f64,
    radiance: Spectrum,
}

impl Disc {
    /// A disc of `angle` degrees diameter around `to_light`. `irradiance` is that of a surface that faces it. `None`
    /// if the angle is too small for a disc.
    fn new(to_light: DVec3, angle: f64, irradiance: Spectrum) -> Option<Disc> {
        let sin_quarter = sin(radians(0.25 * angle));
        let cap = 2.0 * sin_quarter * sin_quarter;
        // ∫ cos θ dω over the disc: π sin² of half the angle.
        let projected = PI * cap * (2.0 - cap);
        let radiance = irradiance * (1.0 / projected) as f32;
        // The bounds are those of precision: radiance must fit f32, and directions in f64 resolve no smaller disc.
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
                let message = "`from` and `direction` are two forms of the same value: give one of them";
                return Err(SceneError::new(ErrorCode::Conflict, message));
            }
            (None, None) => {
                let message = "a directional light needs `from` (where it comes from) or `direction` (where it travels)";
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

    /// For a light with an extent: a unit direction towards it, uniform over its solid angle, its radiance, and the
    /// pdf per solid angle.
    #[inline]
    pub fn sample(&self, u: [f64; 2]) -> Option<(DVec3, Spectrum, f64)> {
        let disc = self.disc.as_ref()?;
        let x = u[0] * disc.cap;
        let (cos, sin) = (1.0 - x, (x * (2.0 - x)).max(0.0).sqrt());
        let (s, c) = sin_cos_turns(u[1]);
        Some((disc.frame.to_world(DVec3::new(sin * c, sin * s, cos)), disc.radiance, disc.pdf()))
    }

    /// For a light with an extent: the radiance that a ray in a unit direction finds, with the pdf of
    /// [`Directional::sample`]; `None` outside the disc.
    #[inline]
    pub fn found(&self, direction: DVec3) -> Option<(Spectrum, f64)> {
        let disc = self.disc.as_ref()?;
        // 1 − cos of the angle between them is half the square of the chord: exact however small it is.
        let inside = 0.5 * direction.distance_squared(self.to_light) <= disc.cap;
        inside.then(|| (disc.radiance, disc.pdf()))
    }

    /// Whether a ray in this unit direction sees the light: see `seen_angle`.
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
            // The irradiance of a surface that faces it, and the edge.
            assert!((sum / f64::from(n * n) - 3.0).abs() < 1e-4, "{angle}: {sum}");
            let half = radians(0.5 * angle);
            assert!(widest <= half * (1.0 + 1e-6) && widest > half * 0.99, "{angle}: {widest}");
            let beside =
                Frame::from_z(light.to_light).to_world(DVec3::new(sin(1.001 * half), 0.0, cos(1.001 * half)));
            assert_eq!(light.found(beside), None, "{angle}");
            assert_eq!(light.found(-light.to_light), None);
        }
        // No extent, or too small an extent.
        for angle in [0.0, 1e-7, 1e-300] {
            assert!(!light(angle).is_disc() && light(angle).sample([0.5, 0.5]).is_none());
        }
    }
}
