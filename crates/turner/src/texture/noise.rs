//! Clouds, smoke and spots of two colours.

use super::prepare::{Kind, Preparing};
use super::{Fractal, Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, SceneError, Transform, choice, params};

choice! {
    /// The sort of noise.
    pub enum NoiseKind {
        /// Octaves of noise summed: clouds.
        Fbm = "fbm",
        /// The sizes of the octaves summed: billows with dark creases.
        Turbulence = "turbulence",
        /// One octave: soft spots of one size.
        Plain = "plain",
    }
}

params! {
    /// Noise between two colours: irregular, without seam, never repeating. Its largest features are about one unit of texture coordinates wide.
    pub struct NoiseDesc as "noise" {
        /// The colour where it is low.
        low: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// The colour where it is high.
        high: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// "fbm" for clouds, "turbulence" for billows with dark creases, "plain" for soft spots of one size.
        kind: NoiseKind = NoiseKind::Fbm;
        /// Number of layers of detail ("plain" has one).
        octaves: u32 = 6, in Range::closed(1.0, 16.0);
        /// How much finer each layer is than the one before.
        lacunarity: f64 = 2.0, in Range::closed(1.0, 16.0);
        /// How much fainter each layer is than the one before.
        gain: f64 = 0.5, in Range::UNIT;
        /// How far the two colours are driven apart: 1 uses the noise as it is, which seldom reaches either.
        contrast: f64 = 2.0, in Range::closed(0.0, 1000.0);
        /// Another number, another noise of the same sort.
        seed: u32 = 0;
        /// Number of the largest features per unit of texture coordinates.
        density: f64 = 2.0;
        /// How the noise lies on the surface or goes through the solid.
        mapping: Mapping = Mapping::Solid;
        /// For `mapping = "triplanar"`: how sharply one direction follows another where the surface turns.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Moves, turns or stretches the noise.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.sky]
type = "noise"
low = "steelblue"
high = "white"

[[object]]
type = "sphere"
material = { color = "sky" }
"##
}

/// Noise between two colours.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    low: ColorSource,
    high: ColorSource,
    kind: NoiseKind,
    fractal: Fractal,
    contrast: f64,
    placement: Placement,
}

impl Kind for NoiseDesc {
    type Ready = Noise;
    const AT_ONCE: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.low);
        visit(self.high);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn triplanar(&self) -> Option<(f64, Transform)> {
        (self.mapping == Mapping::Triplanar).then_some((self.blend, self.transform))
    }

    fn prepare(&self, _: &mut Preparing<'_>) -> Result<Noise, SceneError> {
        let octaves = if self.kind == NoiseKind::Plain { 1 } else { self.octaves.min(16) };
        Ok(Noise {
            low: self.low,
            high: self.high,
            kind: self.kind,
            fractal: Fractal::new(u64::from(self.seed), octaves, self.lacunarity, self.gain),
            contrast: self.contrast,
            placement: Placement::new(self.mapping, self.density, self.transform),
        })
    }
}

impl Noise {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let (c, width) = (self.placement.coordinates(at), self.placement.width(at));
        let share = match self.kind {
            NoiseKind::Turbulence => self.contrast * self.fractal.turbulence(c, width),
            NoiseKind::Fbm | NoiseKind::Plain => 0.5 + 0.5 * self.contrast * self.fractal.fbm(c, width),
        };
        textures.mix(self.low, self.high, share, at)
    }

    /// A step on the surface over which it changes little, as [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, ready, text};
    use super::*;
    use crate::schema::value::Data;

    #[test]
    fn noise_is_even_and_never_repeats() {
        for (kind, low, high) in [("fbm", 0.4, 0.6), ("plain", 0.35, 0.65), ("turbulence", 0.2, 0.6)] {
            let noise = ready("noise", &[("kind", text(kind)), ("density", Data::Integer(9))]);
            let mean =
                (0..10_000).map(|i| at(&noise, f64::from(i % 100) * 0.37, f64::from(i / 100) * 0.37).r);
            let mean = mean.sum::<f32>() / 10_000.0;
            assert!(mean > low && mean < high, "{kind}: {mean}");
            assert_ne!(at(&noise, 0.3, 0.4), at(&noise, 256.3, 0.4));
            let other = ready("noise", &[("kind", text(kind)), ("seed", Data::Integer(1))]);
            assert_ne!(at(&noise, 0.3, 0.4), at(&other, 0.3, 0.4));
        }
        let flat = ready("noise", &[("contrast", Data::Integer(0))]);
        assert_eq!(at(&flat, 0.3, 0.4), Spectrum::grey(0.5));
    }

    #[test]
    fn plain_noise_has_one_octave() {
        let one = ready("noise", &[("octaves", Data::Integer(1))]);
        let plain = ready("noise", &[("kind", text("plain")), ("octaves", Data::Integer(9))]);
        assert_eq!(at(&one, 0.3, 0.4), at(&plain, 0.3, 0.4));
    }
}
