//! Noise between two colours: clouds, smoke and spots.

use super::prepare::{Kind, PrepareContext};
use super::{Fractal, Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, SceneError, Transform, choice, params};

choice! {
    /// The kind of noise.
    pub enum NoiseKind {
        /// Fractal Brownian motion: the sum of octaves of noise; clouds.
        Fbm = "fbm",
        /// The sum of the octaves' absolute values: billows with dark creases.
        Turbulence = "turbulence",
        /// One octave: soft spots of one size.
        Plain = "plain",
    }
}

params! {
    /// Noise that blends between two colours: irregular, seamless and not repeating. With density 1, its largest
    /// features are about one unit of texture coordinates wide.
    pub struct NoiseDesc as "noise" {
        /// The colour of low values.
        low: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// The colour of high values.
        high: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// "fbm" for clouds, "turbulence" for billows with dark creases, "plain" for soft spots of one size.
        kind: NoiseKind = NoiseKind::Fbm;
        /// Number of octaves, the layers of detail ("plain" always has one).
        octaves: u32 = 6, in Range::closed(1.0, 16.0);
        /// Frequency ratio of successive octaves.
        lacunarity: f64 = 2.0, in Range::closed(1.0, 16.0);
        /// Amplitude ratio of successive octaves.
        gain: f64 = 0.5, in Range::UNIT;
        /// Contrast: 1 uses the noise unchanged, which seldom reaches either colour; higher values push it towards
        /// the two colours.
        contrast: f64 = 2.0, in Range::closed(0.0, 1000.0);
        /// Seed: another value gives another noise of the same kind.
        seed: u32 = 0;
        /// Number of the largest features per unit of texture coordinates.
        density: f64 = 2.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Solid;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the noise.
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
    type Prepared = Noise;
    const MAX_INPUTS: u64 = 2;

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

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Noise, SceneError> {
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
        let weight = match self.kind {
            NoiseKind::Turbulence => self.contrast * self.fractal.turbulence(c, width),
            NoiseKind::Fbm | NoiseKind::Plain => 0.5 + 0.5 * self.contrast * self.fractal.fbm(c, width),
        };
        textures.mix(self.low, self.high, weight, at)
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
    use super::super::tests::{at, prepare_texture, text};
    use super::*;
    use crate::schema::value::Data;

    #[test]
    fn noise_is_even_and_never_repeats() {
        for (kind, low, high) in [("fbm", 0.4, 0.6), ("plain", 0.35, 0.65), ("turbulence", 0.2, 0.6)] {
            let noise = prepare_texture("noise", &[("kind", text(kind)), ("density", Data::Integer(9))]);
            let mean =
                (0..10_000).map(|i| at(&noise, f64::from(i % 100) * 0.37, f64::from(i / 100) * 0.37).r);
            let mean = mean.sum::<f32>() / 10_000.0;
            assert!(mean > low && mean < high, "{kind}: {mean}");
            assert_ne!(at(&noise, 0.3, 0.4), at(&noise, 256.3, 0.4));
            let other = prepare_texture("noise", &[("kind", text(kind)), ("seed", Data::Integer(1))]);
            assert_ne!(at(&noise, 0.3, 0.4), at(&other, 0.3, 0.4));
        }
        let flat = prepare_texture("noise", &[("contrast", Data::Integer(0))]);
        assert_eq!(at(&flat, 0.3, 0.4), Spectrum::grey(0.5));
    }

    #[test]
    fn plain_noise_has_one_octave() {
        let one = prepare_texture("noise", &[("octaves", Data::Integer(1))]);
        let plain = prepare_texture("noise", &[("kind", text("plain")), ("octaves", Data::Integer(9))]);
        assert_eq!(at(&one, 0.3, 0.4), at(&plain, 0.3, 0.4));
    }
}
