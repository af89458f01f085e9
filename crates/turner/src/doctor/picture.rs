//! The brightness of the probed pixels, as radiance and as displayed.

use crate::color::Spectrum;
use crate::film::FilmDesc;
use crate::math::elementary::{ln, pow};

/// The brightness of the probed pixels.
#[derive(Clone, Debug, Default)]
pub(super) struct PictureFacts {
    /// The factor from radiance to tone mapping: 2^exposure, including `auto_exposure`.
    pub(super) factor: f64,
    /// Luminance of the radiance, in the order of the pixels; NaN if unknown.
    pub(super) light: Vec<f64>,
    /// Luminance of the displayed values, which are those in the file, 0 to 1.
    pub(super) shown: Vec<f64>,
    /// Fraction of pixels with a channel at its maximum.
    pub(super) clipped: f64,
    /// Fraction of pixels with all channels at their maximum.
    pub(super) white: f64,
    /// Mean saturation of the displayed values: (max − min) / max.
    pub(super) saturation: f64,
}

impl PictureFacts {
    /// Computes them from the mean colours of the pixels.
    pub(super) fn new(film: &FilmDesc, colors: &[[f64; 3]]) -> PictureFacts {
        let luminance = |c: &[f64; 3]| f64::from(Spectrum::from(c.map(|v| v as f32)).luminance());
        let light: Vec<f64> = colors.iter().map(luminance).collect();
        let mut exposure = film.exposure;
        if film.auto_exposure {
            exposure += auto_exposure(&light);
        }
        let factor = pow(2.0, exposure.clamp(-120.0, 120.0));
        let mut facts = PictureFacts { factor, light, ..PictureFacts::default() };
        let mut saturation = 0.0;
        for color in colors {
            let shown = show(film, color, factor);
            let (most, least) = (shown[0].max(shown[1]).max(shown[2]), shown[0].min(shown[1]).min(shown[2]));
            facts.clipped += f64::from(u8::from(most >= 0.995));
            facts.white += f64::from(u8::from(least >= 0.985));
            saturation += if most > 0.0 { (most - least) / most } else { 0.0 };
            facts.shown.push(f64::from(Spectrum::from(shown.map(|v| v as f32)).luminance()));
        }
        let n = colors.len().max(1) as f64;
        (facts.clipped, facts.white, facts.saturation) = (facts.clipped / n, facts.white / n, saturation / n);
        facts
    }
}

/// A colour as displayed, which is its value in the file.
pub(super) fn show(film: &FilmDesc, color: &[f64; 3], factor: f64) -> [f64; 3] {
    let light = Spectrum::from(color.map(|v| (v * factor) as f32));
    let mapped = film.tonemap.map(light);
    mapped.to_array().map(|v| f64::from(film.transfer.encode(v)))
}

/// The exposure that the film's `auto_exposure` chooses, in stops.
fn auto_exposure(light: &[f64]) -> f64 {
    let mut logs: Vec<f64> = light.iter().filter(|v| **v > 0.0 && v.is_finite()).map(|v| ln(*v)).collect();
    logs.sort_by(f64::total_cmp);
    let cut = logs.len() / 20;
    let kept = logs.get(cut..logs.len() - cut).unwrap_or_default();
    if kept.is_empty() {
        return 0.0;
    }
    let mean = kept.iter().sum::<f64>() / kept.len() as f64;
    (ln(0.18) - mean) * std::f64::consts::LOG2_E
}

/// The quantile at `fraction`, 0 to 1. NaN values are ignored. 0 if there are no values.
pub(super) fn quantile(values: impl IntoIterator<Item = f64>, fraction: f64) -> f64 {
    let mut sorted: Vec<f64> = values.into_iter().filter(|v| !v.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    let at = (fraction * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(at).copied().unwrap_or(0.0)
}
