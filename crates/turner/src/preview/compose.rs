//! The colour of each pixel from its light and albedo.

use turner_bvh::InstructionSet;

use crate::color::Spectrum;
use crate::preview::buffers::{CATCHER, Light, NO_KEY, Still};
use crate::preview::upsample::{UpsampleRow, Upsampled};

/// The parts of a picture.
pub(super) struct Composed<'a> {
    pub(super) set: InstructionSet,
    /// The light that is on the grid.
    pub(super) grid: Upsampled<'a>,
    /// Direct light and gloss of all pixels, where they are not on the grid.
    pub(super) full: Option<Full<'a>>,
    pub(super) still: &'a [Still],
    pub(super) has_gloss: bool,
    /// Light that arrives at a surface from others, over π, as the mean of the picture.
    pub(super) ambient: [f32; 3],
}

/// Light of all pixels.
pub(super) struct Full<'a> {
    pub(super) direct: &'a Light,
    /// The same without a filter.
    pub(super) unfiltered: &'a Light,
    pub(super) gloss: Option<&'a Light>,
}

fn at(light: &Light, i: usize) -> Spectrum {
    let [r, g, b] = &light.rgb;
    Spectrum::new(r[i], g[i], b[i])
}

impl Composed<'_> {
    /// Direct light of a pixel, without a filter.
    fn unfiltered(&self, i: usize) -> Spectrum {
        let unfiltered = self.full.as_ref().map(|full| full.unfiltered);
        unfiltered.filter(|light| light.count[i] > 0.0).map_or(Spectrum::BLACK, |light| at(light, i))
    }

    /// Composes rows.
    pub(super) fn rows(
        &self,
        first: usize,
        color: &mut [[f32; 3]],
        alpha: &mut [f32],
        scratch: &mut UpsampleRow,
    ) {
        let [width, _] = self.grid.size;
        let rows = color.chunks_exact_mut(width).zip(alpha.chunks_exact_mut(width));
        for (y, (color, alpha)) in (first..).zip(rows) {
            self.grid.row(self.set, y, scratch);
            for (x, (color, alpha)) in color.iter_mut().zip(alpha).enumerate() {
                (*color, *alpha) = self.pixel(x, y, scratch);
            }
        }
    }

    #[inline]
    fn pixel(&self, x: usize, y: usize, row: &UpsampleRow) -> ([f32; 3], f32) {
        let i = y * self.grid.size[0] + x;
        let (still, ambient) = (&self.still[i], Spectrum::from(self.ambient));
        let mut sum = still.seen + still.bounced * ambient;
        let mut alpha = still.alpha;
        let key = self.grid.guides.key[i];
        if key == NO_KEY {
            if !still.albedo.is_black() {
                // A surface that some frames find within the pixel, but not the first one.
                sum += still.albedo * (self.unfiltered(i) + ambient);
            }
            return (sum.to_array(), alpha);
        }
        let direct = match &self.full {
            Some(full) => at(full.direct, i),
            None => self.grid.at(row, 0, x, y).unwrap_or(Spectrum::BLACK),
        };
        if key & CATCHER != 0 {
            if direct.g > 0.0 {
                let left = (direct.r / direct.g).clamp(0.0, 1.0);
                let off = (1.0 - left) * still.catcher;
                sum *= 1.0 - off;
                alpha += off * (1.0 - alpha);
            }
            return (sum.to_array(), alpha);
        }
        if !still.albedo.is_black() {
            sum += still.albedo * (direct + self.grid.at(row, 2, x, y).unwrap_or(ambient));
        }
        if self.has_gloss && self.grid.guides.roughness[i] < 1.0 {
            sum += match &self.full {
                Some(full) => full.gloss.map_or(Spectrum::BLACK, |gloss| at(gloss, i)),
                None => self.grid.at(row, 1, x, y).unwrap_or(Spectrum::BLACK),
            };
        }
        (sum.to_array(), alpha)
    }
}
