//! FLIP: how visible the differences between two images are to an observer who alternates them on a display.
//!
//! For display values this is LDR-FLIP: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild,
//! "FLIP: A Difference Evaluator for Alternating Images", Proceedings of the ACM on Computer Graphics and
//! Interactive Techniques 3 (2), 2020. For linear light it is HDR-FLIP: Andersson, Nilsson, Shirley and
//! Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics Short Papers 2021.
//!
//! ```text
//! linear RGB ─ opponent colours ─ contrast sensitivity ─ L*a*b*, Hunt effect ─ HyAB ─ redistributed ── c ─┬─
//! c^(1 − f)
//!        └──── achromatic ── edges and points (derivatives of Gaussians) ── largest difference ── √ ── f ─┘
//! ```
//!
//! * Colours: a filter with the contrast sensitivity of human vision removes detail that is too fine to see at
//!   the viewing distance. The colours that remain are compared by the perceptual distance HyAB, and the
//!   distance is mapped to c in 0..=1.
//! * Features: edges and points attract attention. They are detected by first and second derivatives of
//!   Gaussians, and f is the larger of their differences.
//! * Each pixel has the value c^(1 − f), so that a difference counts more where features differ. The image has
//!   the mean.
//! * Linear light is tone-mapped at several exposures ([`exposures`]); each pixel takes its largest value.
//!
//! The observer is that of the papers: 0.7 m from a display that is 0.7 m and 3840 pixels wide, which is 67
//! pixels per degree. Beyond its edges an image continues with the edge's pixels. Transparent images are
//! compared on black and on white; each pixel takes the larger value.

mod color;
mod exposures;
mod filters;

use super::{Measured, Pair, mean_of, strips};
use crate::color::srgb_decode;
use color::{Lab, Scale};
use filters::Filters;

pub use exposures::exposures;

/// Pixels per degree: 0.7 m · 3840 / 0.7 m · π / 180.
const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// How the images are displayed.
#[derive(Clone, Copy)]
struct ViewingCondition {
    background: f32,
    /// 2^exposure, the factor before tone mapping; `None` for display values.
    factor: Option<f64>,
}

/// The mean FLIP of a pair, 0 to 1, and its map.
pub fn flip(pair: &Pair, threads: usize) -> Measured {
    let factors: Vec<Option<f64>> = if pair.is_linear {
        exposures(pair).into_iter().map(|stops| Some(crate::math::elementary::pow(2.0, stops))).collect()
    } else {
        vec![None]
    };
    let backgrounds = pair.backgrounds();
    let conditions: Vec<ViewingCondition> = factors
        .iter()
        .flat_map(|&factor| {
            backgrounds.iter().map(move |&background| ViewingCondition { background, factor })
        })
        .collect();
    let (filters, scale) = (Filters::new(PIXELS_PER_DEGREE), Scale::new());
    let map = strips::map((pair.width, pair.height), threads, |first, out| {
        for condition in &conditions {
            strip(pair, *condition, &filters, &scale, first, out);
        }
    });
    Measured::new(pair, mean_of(&map), map)
}

/// Raises the values of a strip to those of one viewing condition.
fn strip(
    pair: &Pair,
    condition: ViewingCondition,
    filters: &Filters,
    scale: &Scale,
    first: usize,
    out: &mut [f32],
) {
    let size @ (width, _) = (pair.width as usize, pair.height as usize);
    let rows = first..first + out.len() / width.max(1);
    let of = |picture: usize| {
        let at = |x: usize, y: usize| displayed(pair, picture, y * width + x, condition);
        filters.response(size, rows.clone(), at)
    };
    let (a, b) = (of(0), of(1));
    for (i, out) in out.iter_mut().enumerate() {
        let colors = scale.redistributed(Lab::hunt(a.filtered(i)).hyab(Lab::hunt(b.filtered(i))));
        let features = a.feature_difference(&b, i);
        let value = crate::math::elementary::pow(colors, 1.0 - features);
        *out = out.max(value as f32);
    }
}

/// Linear light that the display emits, 0..=1.
fn displayed(pair: &Pair, picture: usize, index: usize, condition: ViewingCondition) -> [f64; 3] {
    match condition.factor {
        None => pair.shown(picture, index, condition.background).map(|v| f64::from(srgb_decode(v))),
        Some(factor) => pair
            .on(picture, index, condition.background)
            .map(|v| exposures::tone_mapped(f64::from(v.max(0.0)) * factor).clamp(0.0, 1.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::pair;
    use super::*;

    #[test]
    fn nothing_and_everything() {
        let batch = |x: u32, y: u32| [0.1 * (x % 7) as f32, 0.2 * (y % 5) as f32, 0.5];
        let same = flip(&pair(20, 12, false, batch, batch), 2);
        assert_eq!((same.value, same.worst.value), (0.0, 0.0));
        // Green and blue have the largest distance.
        let most = flip(&pair(8, 8, false, |_, _| [0.0, 1.0, 0.0], |_, _| [0.0, 0.0, 1.0]), 1);
        assert!((most.value - 1.0).abs() < 1e-4, "{}", most.value);
        // Black and white: L* of 0 and 100, no features. 100^0.7 = 25.12; the rest is the redistribution.
        let grey = flip(&pair(8, 8, false, |_, _| [0.0; 3], |_, _| [1.0; 3]), 1);
        let cmax = Scale::new().largest;
        let bend = 0.4 * cmax;
        let c = crate::math::elementary::pow(100.0, 0.7);
        let expected = if c < bend { c * 0.95 / bend } else { 0.95 + (c - bend) / (cmax - bend) * 0.05 };
        assert!((grey.value - expected).abs() < 1e-5, "{} {expected}", grey.value);
    }

    #[test]
    fn threads_and_strips_change_nothing() {
        let a = |x: u32, y: u32| [((x * 31 + y * 17) % 23) as f32 / 22.0; 3];
        let b = |x: u32, y: u32| [((x * 29 + y * 17) % 19) as f32 / 18.0, 0.5, 0.1];
        for linear in [false, true] {
            let pair = pair(9, 150, linear, a, b);
            assert_eq!(flip(&pair, 1), flip(&pair, 3));
        }
    }
}
