//! Shadow catchers in the film: the shadow of a pixel from the light that its shadow catchers receive.
//!
//! ```text
//!  a = 1 − Σ shadowed / Σ unshadowed           the fraction of the light that is kept off
//!  pixel = Σ colour − a · Σ colour behind,     alpha = Σ alpha + a · Σ (caught − alpha behind)
//! ```
//!
//! Over the samples that hit a shadow catcher, what is behind it is darkened by the fraction a; what is transparent becomes
//! black with the coverage a. Where nothing is behind, the pixel is black with the alpha of the shadow.

use super::{Film, Fixed96};
use crate::film::band::Band;

/// The channels of films of scenes with shadow catchers. They are no AOVs.
pub(crate) const CAUGHT: [&str; 7] = [
    "caught.A",
    "caught.shadowed",
    "caught.unshadowed",
    "caught.behind.R",
    "caught.behind.G",
    "caught.behind.B",
    "caught.behind.A",
];

/// Less coverage than this is rounding.
const ROUNDING: f32 = 1e-6;

/// The shadow catchers of a film.
#[derive(Clone, Copy)]
pub(super) struct Caught {
    /// The index of their first channel.
    channel: usize,
}

impl Caught {
    /// `None` if the film has none.
    pub(super) fn of(film: &Film) -> Option<Caught> {
        let channel = film.channels().iter().position(|c| c.name == CAUGHT[0])?;
        Some(Caught { channel })
    }

    /// The means of the channels in a pixel, and the fraction of the light that is kept off.
    fn means(self, band: &Band, i: usize) -> Option<([f64; CAUGHT.len()], f64)> {
        let weight = band.sum(i).weight();
        let sums: &[[u32; 3]; CAUGHT.len()] = band.extra(i).get(self.channel..)?.first_chunk()?;
        let means = sums.map(|words| Fixed96::from_words(words).mean(weight));
        let [_, shadowed, unshadowed, ..] = means;
        (weight != 0.0 && unshadowed > 0.0).then(|| (means, (1.0 - shadowed / unshadowed).clamp(0.0, 1.0)))
    }

    /// A pixel with its shadow.
    pub(super) fn apply(self, band: &Band, i: usize, [r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
        let Some((means, kept_off)) = self.means(band, i) else { return [r, g, b, alpha] };
        let [caught, _, _, behind @ ..] = means;
        let [red, green, blue, coverage] = behind.map(|v| (v * kept_off) as f32);
        let added = (caught * kept_off) as f32 - coverage;
        // What is opaque behind stays opaque, whatever rounding leaves.
        let alpha = if added > ROUNDING { alpha + added } else { alpha };
        [r - red, g - green, b - blue, alpha]
    }
}

impl Film {
    /// The shadow on the shadow catchers in a pixel of the region: the fraction of the direct light that objects keep off,
    /// times the coverage of the shadow catchers, 0..=1.
    pub fn shadow(&self, x: u32, y: u32) -> f32 {
        let means = Caught::of(self).and_then(|caught| {
            let (band, i) = self.place(x, y)?;
            caught.means(band, i)
        });
        means.map_or(0.0, |([caught, ..], kept_off)| (caught * kept_off) as f32)
    }
}
