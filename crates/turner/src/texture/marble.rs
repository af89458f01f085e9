//! Marble: veins from a sine that noise displaces (after Perlin 1985, "An image synthesizer").
//!
//! The phase is φ = π·(veins·d·p + distortion·fbm(p)), with d perpendicular to the undisturbed veins. Veins are where
//! sin φ = 0: thin for sharp = 1, broad and soft for sharp = 0. A second set, finer and fainter, crosses the first.
//! Both fade in and out with clouds of a third colour.

use super::placement::smoothstep;
use super::prepare::{Kind, PrepareContext};
use super::{Fractal, Mapping, Placement, TexturePoint, Textures, Tint};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::elementary::sin;
use crate::schema::{ColorSource, Range, SceneError, Transform, params};

params! {
    /// Marble: dark veins through a light, cloudy stone. The veins are slanted sheets through the solid.
    pub struct MarbleDesc as "marble" {
        /// Colour of the stone.
        base: Tint = Tint::Display(0xf2efe9);
        /// Colour of the clouds.
        cloud: Tint = Tint::Display(0xb0b4b8);
        /// Colour of the veins.
        vein: Tint = Tint::Display(0x3d4249);
        /// Number of veins per unit of texture coordinates.
        veins: f64 = 2.0, in Range::closed(0.0, 1e6);
        /// How far noise displaces the veins: 0 leaves flat sheets.
        distortion: f64 = 2.0, in Range::closed(0.0, 1000.0);
        /// Sharpness of the veins: 0 is broad and soft, 1 is thin.
        sharp: f64 = 0.8, in Range::UNIT;
        /// Seed: another value gives another stone.
        seed: u32 = 0;
        /// Scales the pattern: with density 2 it is half as large.
        density: f64 = 1.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Solid;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the pattern.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.carrara]
type = "marble"

[[object]]
type = "sphere"
material = { color = "carrara" }
"##
}

/// Marble.
#[derive(Clone, Debug)]
pub(super) struct Marble {
    base: ColorSource,
    cloud: ColorSource,
    vein: ColorSource,
    veins: f64,
    distortion: f64,
    sharp: f64,
    displacement: Fractal,
    fine: Fractal,
    clouds: Fractal,
    placement: Placement,
    /// The mean over all phases.
    mean: Vein,
}

/// Direction perpendicular to the veins: (4, 5, −2)/√45.
const ACROSS: DVec3 = DVec3::new(0.596_284_793_999_944, 0.745_355_992_499_93, -0.298_142_396_999_972);

/// Direction perpendicular to the fine veins, and to the other one: (2, 0, 4)/√20.
const ALONG: DVec3 = DVec3::new(0.447_213_595_499_958, 0.0, 0.894_427_190_999_916);

/// Strength of a vein at a point.
#[derive(Clone, Copy, Debug)]
struct Vein {
    /// 1 at its centre, 0 outside.
    core: f64,
    /// 1 at its centre, falling off to half-way to the next vein.
    halo: f64,
}

impl Kind for MarbleDesc {
    type Prepared = Marble;
    const MAX_INPUTS: u64 = 3;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        self.base.visit(visit);
        self.cloud.visit(visit);
        self.vein.visit(visit);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn triplanar(&self) -> Option<(f64, Transform)> {
        (self.mapping == Mapping::Triplanar).then_some((self.blend, self.transform))
    }

    fn prepare(&self, cx: &mut PrepareContext<'_>) -> Result<Marble, SceneError> {
        let seed = u64::from(self.seed) << 8;
        let mut marble = Marble {
            base: self.base.resolve(cx.transfer),
            cloud: self.cloud.resolve(cx.transfer),
            vein: self.vein.resolve(cx.transfer),
            veins: self.veins,
            distortion: self.distortion,
            sharp: self.sharp,
            displacement: Fractal::new(seed + 1, 6, 2.05, 0.48),
            fine: Fractal::new(seed + 3, 4, 2.1, 0.48),
            clouds: Fractal::new(seed + 2, 4, 2.0, 0.5),
            placement: Placement::new(self.mapping, self.density, self.transform),
            mean: Vein { core: 0.0, halo: 0.0 },
        };
        const PHASES: i32 = 256;
        for i in 0..PHASES {
            let vein = marble.vein_at(f64::from(i) / f64::from(PHASES));
            marble.mean.core += vein.core / f64::from(PHASES);
            marble.mean.halo += vein.halo / f64::from(PHASES);
        }
        Ok(marble)
    }
}

impl Marble {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let (p, width) = (self.placement.coordinates(at), self.placement.width(at));
        let shift = self.displacement.fbm(1.1 * p, 1.1 * width);
        let drift = self.fine.fbm(2.3 * p, 2.3 * width);
        // Noise changes by about its amplitude per unit.
        let phases = width * (self.veins + self.distortion);
        let main = self.vein(self.veins * ACROSS.dot(p) + self.distortion * shift, phases);
        let fine = self
            .vein(1.7 * self.veins * ALONG.dot(p) + self.distortion * (0.5 * shift + drift), 1.7 * phases);
        let clouds = self.clouds.fbm(0.9 * p + DVec3::splat(0.6 * shift), 1.5 * width);
        // Veins are darkest in the clouds; elsewhere they are thin or vanish, the fine ones first.
        let strength = smoothstep(-0.3, 0.25, clouds);
        let cloudy = smoothstep(-0.2, 0.4, clouds) + 0.5 * main.halo * strength;
        let veined =
            (main.core * (0.2 + 0.7 * strength)).max(fine.core * 0.5 * smoothstep(-0.1, 0.35, clouds));
        if veined >= 1.0 {
            return textures.color(self.vein, at);
        }
        let stone = textures.mix(self.base, self.cloud, cloudy, at);
        if veined > 0.0 { stone.lerp(textures.color(self.vein, at), veined as f32) } else { stone }
    }

    /// The vein at a phase, an integer at its centre. Where a footprint covers one or more phases, the mean of all
    /// phases.
    fn vein(&self, phase: f64, covered: f64) -> Vein {
        let lost = if covered > 0.0 { smoothstep(0.25, 1.0, covered) } else { 0.0 };
        let own = if lost < 1.0 { self.vein_at(phase) } else { Vein { core: 0.0, halo: 0.0 } };
        let to_mean = |v: f64, mean: f64| v + lost * (mean - v);
        Vein { core: to_mean(own.core, self.mean.core), halo: to_mean(own.halo, self.mean.halo) }
    }

    fn vein_at(&self, phase: f64) -> Vein {
        let away = sin(std::f64::consts::PI * phase).abs();
        let width = 1.0 - 0.9 * self.sharp;
        Vein { core: 1.0 - smoothstep(0.0, width, away), halo: (1.0 - away) * (1.0 - away) }
    }

    /// See [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{prepare_texture, text};
    use super::*;
    use crate::math::DVec2;
    use crate::schema::TextureId;
    use crate::schema::value::Data;

    #[test]
    fn without_noise_veins_are_planes() {
        let keys = [("distortion", Data::Integer(0)), ("base", text("white")), ("cloud", text("white"))];
        let marble = prepare_texture("marble", &keys);
        let at = |p: DVec3| marble.eval(TextureId(0), &TexturePoint::new(DVec2::ZERO, p));
        // At the centre of a vein it is darker than the stone, anywhere along the vein. Between veins it is stone or
        // a fine vein.
        let inside = DVec3::new(1.0, 0.0, 2.0);
        for k in -20..20 {
            let on = at(0.37 * f64::from(k) * inside);
            assert!(on.r < 0.9, "{on:?}");
        }
    }

    #[test]
    fn the_two_sorts_of_veins_cross_at_right_angles() {
        assert!(ACROSS.dot(ALONG).abs() < 1e-12);
        assert!((ACROSS.length() - 1.0).abs() < 1e-12 && (ALONG.length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn marble_is_mostly_stone() {
        let marble = prepare_texture("marble", &[]);
        let dark = (0..10_000).filter(|i| {
            let p = DVec3::new(f64::from(i % 100), f64::from(i / 100), 0.3) * 0.173;
            marble.eval(TextureId(0), &TexturePoint::new(DVec2::ZERO, p)).g < 0.6
        });
        let share = dark.count() as f64 / 10_000.0;
        assert!((0.02..0.3).contains(&share), "{share}");
    }
}
