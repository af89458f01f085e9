//! Rows of a film, as they are kept in memory.

use super::{PixelRect, PixelSum};
use crate::color::Spectrum;

/// Rows of a band: threads that work on different bands do not wait for each other.
pub const BAND: u32 = 16;

/// Words of a pixel's sums.
pub(super) const WORDS: usize = PixelSum::BYTES / 4;

/// Some rows of a film's region. Pixels are words, so that they come zeroed from the system, page by page as they are
/// used.
#[derive(Clone, Debug)]
pub struct Band {
    rows: PixelRect,
    pixels: Pixels,
}

#[derive(Clone, Debug)]
enum Pixels {
    /// At most one sample a pixel, as it came: red, green, blue, and the coverage with the sign bit set, which zeroed
    /// memory has not. A third of the memory of sums: at one sample a pixel half of the time outside of tracing
    /// was spent on touching it for the first time.
    Samples(Vec<[u32; 4]>),
    /// Sums of samples.
    Sums(Vec<[u32; WORDS]>),
}

/// Marks a pixel that has its sample.
const TAKEN: u32 = 1 << 31;

impl Band {
    /// Empty rows, for one sample a pixel or more.
    pub(super) fn new(rows: PixelRect, one_sample: bool) -> Band {
        let count = rows.area() as usize;
        let pixels = if one_sample {
            Pixels::Samples(vec![[0; 4]; count])
        } else {
            Pixels::Sums(vec![[0; WORDS]; count])
        };
        Band { rows, pixels }
    }

    /// Bytes of a pixel.
    pub(super) fn bytes_per_pixel(one_sample: bool) -> usize {
        if one_sample { size_of::<[u32; 4]>() } else { PixelSum::BYTES }
    }

    /// Where each row of a tile inside the band begins.
    fn row_starts(&self, tile: &PixelRect) -> impl Iterator<Item = usize> + Clone + use<> {
        let stride = self.rows.width as usize;
        let first = (tile.y - self.rows.y) as usize * stride + (tile.x - self.rows.x) as usize;
        (0..tile.height as usize).map(move |row| first + row * stride)
    }

    /// Adds one sample (colour times coverage, and coverage 0..=1) to each pixel of a tile inside the band, row by row.
    pub fn add_samples(&mut self, tile: &PixelRect, samples: impl Iterator<Item = (Spectrum, f32)> + Clone) {
        let starts = self.row_starts(tile);
        let width = tile.width as usize;
        if let Pixels::Samples(pixels) = &mut self.pixels {
            let free = starts.clone().all(|at| pixels[at..at + width].iter().all(|p| *p == [0; 4]));
            if free {
                let mut samples = samples;
                for start in starts {
                    for (pixel, (color, alpha)) in pixels[start..start + width].iter_mut().zip(&mut samples) {
                        let [r, g, b] = color.to_array().map(f32::to_bits);
                        *pixel = [r, g, b, alpha.to_bits() | TAKEN];
                    }
                }
                return;
            }
        }
        let sums: Vec<PixelSum> = samples
            .map(|(color, alpha)| {
                let mut sum = PixelSum::default();
                sum.add_or_leave_out(color, alpha);
                sum
            })
            .collect();
        self.add_sums(tile, &sums);
    }

    /// Adds the sums of a tile inside the band, row by row.
    pub fn add_sums(&mut self, tile: &PixelRect, sums: &[PixelSum]) {
        let starts = self.row_starts(tile);
        let width = tile.width as usize;
        let pixels = self.sums_mut();
        for (start, sums) in starts.zip(sums.chunks_exact(width)) {
            for (words, sum) in pixels[start..start + width].iter_mut().zip(sums) {
                let mut pixel = PixelSum::from_words(words);
                pixel.merge(sum);
                *words = pixel.to_words();
            }
        }
    }

    /// The pixels as sums, which they become if they are not.
    fn sums_mut(&mut self) -> &mut Vec<[u32; WORDS]> {
        if let Pixels::Samples(pixels) = &self.pixels {
            self.pixels = Pixels::Sums(pixels.iter().map(|p| sum_of_sample(p).to_words()).collect());
        }
        match &mut self.pixels {
            Pixels::Sums(pixels) => pixels,
            Pixels::Samples(_) => unreachable!("made sums above"),
        }
    }

    /// The sums of the pixel at an index, row by row.
    pub(super) fn sum(&self, i: usize) -> PixelSum {
        match &self.pixels {
            Pixels::Samples(pixels) => sum_of_sample(&pixels[i]),
            Pixels::Sums(pixels) => PixelSum::from_words(&pixels[i]),
        }
    }

    /// Samples in all pixels.
    pub(super) fn samples(&self) -> u64 {
        (0..self.rows.area() as usize).map(|i| u64::from(self.sum(i).count())).sum()
    }
}

fn sum_of_sample(&[r, g, b, alpha]: &[u32; 4]) -> PixelSum {
    let mut sum = PixelSum::default();
    if alpha & TAKEN != 0 {
        let color = Spectrum::from([r, g, b].map(f32::from_bits));
        sum.add_or_leave_out(color, f32::from_bits(alpha & !TAKEN));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sample a pixel, kept as it came or as a sum, is the same; a second one is added to the first.
    #[test]
    fn samples_are_the_sums_of_one() {
        let tile = PixelRect { x: 2, y: 1, width: 3, height: 2 };
        let rows = PixelRect { x: 0, y: 0, width: 7, height: 4 };
        let values = [0.25, 1e-20, -3.0, f32::NAN, 7e9, 0.0];
        let samples = values.map(|v| (Spectrum::new(v, 0.5, 1.0), 0.75));
        let (mut one, mut many) = (Band::new(rows, true), Band::new(rows, false));
        let same = |a: &Band, b: &Band| (0..28).all(|i| a.sum(i) == b.sum(i));
        for round in 0..2 {
            one.add_samples(&tile, samples.iter().copied());
            many.add_samples(&tile, samples.iter().copied());
            assert!(same(&one, &many));
            assert_eq!(one.samples(), 5 * (round + 1));
        }
        let mut transparent = Band::new(rows, true);
        transparent.add_samples(&tile, [(Spectrum::BLACK, 0.0); 6].into_iter());
        assert_eq!((transparent.samples(), transparent.sum(9).mean()), (6, Some([0.0; 4])));
        assert_eq!(transparent.sum(0).mean(), None);
    }
}
