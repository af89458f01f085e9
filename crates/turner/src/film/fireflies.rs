//! Fireflies: samples far brighter than anything else around them. One of them is worth more than all other samples of its
//! pixel, which then shows the sample instead of the mean.
//!
//! A bright sample alone proves nothing: a lamp that covers a hundredth of a pixel looks the same. So three witnesses may
//! confirm a sample of a pixel, and its contribution c (luminance times weight) is limited to the largest of what they allow:
//!
//! ```text
//! limit = max( 2 · the 4th brightest of the pixel,           four samples of the pixel are that bright
//!              2 · the nth brightest of the 3 x 3 pixels,    the neighbours see that light, too
//!              W · m / 8 )                                   the sample changes the pixel by m / 8 at most
//! ```
//!
//! W is the weight of the pixel's samples, and m the mean of the 3 x 3 pixels in which no sample counts more than the nth
//! brightest. The third limit grows with the number of samples: a pixel converges to the same mean as without. Brighter
//! samples are scaled down to the limit, with their colour.
//!
//! Related: Zirr, Hanika and Dachsbacher 2018, "Re-weighting firefly samples for improved finite-sample Monte Carlo
//! estimates", which sorts samples by their brightness into layers, and asks in the same way how many samples of a pixel
//! and its neighbours have that brightness. The brightest samples themselves need less memory than layers and no
//! assumption on the brightness of a scene.

use super::brightest::{Bright, KEPT};
use super::{Antialias, Film, FilmDesc, PixelRect};
use crate::color::Spectrum;
use crate::schema::choice;

choice! {
    /// What happens to fireflies.
    pub enum Fireflies {
        /// They stay: the mean of many pictures is exact.
        Keep = "keep",
        /// A sample that neither its pixel nor the neighbours confirm is scaled down. The limit grows with the number of
        /// samples, so that the picture converges to the same. Takes 64 bytes per pixel. Light paths (`caustics`) and
        /// AOVs are not changed.
        Remove = "remove",
    }
}

/// How much brighter than its witnesses a sample may be.
const BRIGHTER: f32 = 2.0;

/// The part of the local mean by which a sample without witnesses may change its pixel.
const PART: f64 = 0.125;

impl FilmDesc {
    /// Whether fireflies are looked for, if there are several samples per pixel.
    pub(super) fn looks_for_fireflies(&self) -> bool {
        self.fireflies == Fireflies::Remove && self.antialias == Antialias::MonteCarlo
    }

    /// Whether fireflies are removed: only from random samples, of which there are several per pixel.
    pub fn removes_fireflies(&self) -> bool {
        self.looks_for_fireflies() && self.samples > 1
    }
}

/// The 3 x 3 pixels around a pixel.
struct Around {
    /// The brightest samples of all, brightest first, each once.
    brightest: [Bright; 9 * KEPT],
    count: usize,
    /// Sum of the luminance of all samples, and of their weights.
    luminance: f64,
    weight: f64,
}

impl Film {
    /// A pixel of the region without its fireflies; `mean` is the mean of its samples.
    pub(super) fn without_fireflies(&self, x: u32, y: u32, mean: [f32; 4]) -> [f32; 4] {
        let Some(limit) = self.firefly_limit(x, y) else { return mean };
        let Some((band, i)) = self.place(x, y) else { return mean };
        let weight = band.sum(i).weight();
        let mut out = mean.map(f64::from);
        for bright in band.brightest[i].iter().take_while(|bright| bright.luminance > limit) {
            let left_out = f64::from(1.0 - limit / bright.luminance) / weight;
            for (value, part) in out.iter_mut().zip(bright.color.to_array()) {
                *value -= left_out * f64::from(part);
            }
        }
        out.map(|v| v as f32)
    }

    /// The most that a sample may contribute to a pixel of the region, as luminance times weight. `None` if all contribute
    /// less, and if fireflies are kept.
    pub fn firefly_limit(&self, x: u32, y: u32) -> Option<f32> {
        let (band, i) = self.place(x, y)?;
        let mut own = band.brightest.get(i)?.iter();
        let first = own.next()?;
        let confirmed = own.nth(KEPT - 2).map_or(0.0, |bright| BRIGHTER * bright.luminance);
        let sum = band.sum(i);
        let weight = sum.weight();
        let is_small = |mean: f64| f64::from(first.luminance) <= PART * mean * weight;
        if first.luminance <= confirmed || weight <= 0.0 {
            return None;
        }
        let around = Around::new(self, x, y);
        let witnesses = witnesses(weight);
        let seen = around.brightest[..around.count].get(witnesses - 1).map_or(0.0, |bright| bright.luminance);
        if first.luminance <= BRIGHTER * seen {
            return None;
        }
        let above: f64 =
            around.brightest[..around.count].iter().map(|b| f64::from((b.luminance - seen).max(0.0))).sum();
        let mean = (around.luminance - above).max(0.0) / around.weight;
        if is_small(mean) {
            return None;
        }
        Some(confirmed.max(BRIGHTER * seen).max((PART * mean * weight) as f32))
    }
}

/// The number of samples of the 3 x 3 pixels that confirm their brightness.
fn witnesses(weight: f64) -> usize {
    (0.5 * weight).clamp(3.0, 16.0) as usize
}

impl Around {
    fn new(film: &Film, x: u32, y: u32) -> Around {
        let none = Bright { color: Spectrum::BLACK, luminance: 0.0, number: 0 };
        let mut out = Around { brightest: [none; 9 * KEPT], count: 0, luminance: 0.0, weight: 0.0 };
        let PixelRect { x: left, y: top, width, height } = film.region;
        let along =
            |at: u32, start: u32, size: u32| at.saturating_sub(1).max(start)..(at + 2).min(start + size);
        for ny in along(y, top, height) {
            for nx in along(x, left, width) {
                let Some((band, i)) = film.place(nx, ny) else { continue };
                let sum = band.sum(i);
                let Some([r, g, b, _]) = sum.mean().filter(|v| v.iter().all(|v| v.is_finite())) else {
                    continue;
                };
                out.luminance += f64::from(Spectrum::new(r, g, b).luminance()) * sum.weight();
                out.weight += sum.weight();
                for bright in band.brightest[i].iter() {
                    out.brightest[out.count] = bright;
                    out.count += 1;
                }
            }
        }
        let all = &mut out.brightest[..out.count];
        all.sort_unstable_by(|a, b| b.luminance.total_cmp(&a.luminance).then(a.number.cmp(&b.number)));
        out
    }
}
