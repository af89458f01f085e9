//! Rows of a film in memory.

use super::adaptive::AdaptiveTile;
use super::brightest::Brightest;
use super::error::ERROR_SUMS;
use super::labels::HeldLabels;
use super::{Fixed96, Half, NonFinite, PixelRect, PixelSum, SampleSet, TILE, TileGrid, TileSums};
use crate::color::Spectrum;

/// One row of tiles of a film's region, and the samples that its tiles hold. Memory for the pixels is allocated zeroed and
/// filled with zeros before the first sample is added. Reading it first is slower: the page faults twice, and the second
/// page fault interrupts the other cores.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    rows: PixelRect,
    pixels: Pixels,
    /// Sums of additional channels, `channels` per pixel.
    extra: Vec<[u32; 3]>,
    /// Whether pixels and channels are allocated, but not yet written.
    is_fresh: bool,
    channels: usize,
    /// The brightest samples of each pixel; empty unless fireflies are removed.
    pub(super) brightest: Vec<Brightest>,
    /// For each tile, from the left: the samples that it holds.
    pub(super) held: Vec<SampleSet>,
    /// For each tile of an adaptive film what it holds in addition; empty otherwise.
    pub(super) adaptive: Vec<AdaptiveTile>,
    /// For each tile its labels; empty without channels of labels.
    pub(super) labels: Vec<HeldLabels>,
    /// The non-finite samples.
    pub(super) non_finite: NonFinite,
}

#[derive(Clone, Debug)]
pub(super) enum Pixels {
    /// At most one sample per pixel, unchanged: red, green, blue, and coverage with the sign bit set, which
    /// distinguishes it from zeroed memory. A third of the memory of sums: with one sample per pixel and sums,
    /// the first access to their memory takes half of the time outside of tracing.
    Samples(Vec<[u32; 4]>),
    /// Sums of samples.
    Sums(Vec<[u32; PixelSum::WORDS]>),
}

/// Marks a pixel that has its sample.
const HAS_SAMPLE: u32 = 1 << 31;

impl Band {
    /// Empty rows for one sample per pixel or more, with `channels` channels in addition to colour and coverage.
    pub(super) fn new(rows: PixelRect, one_sample: bool, channels: usize) -> Band {
        let count = rows.area() as usize;
        let pixels = if one_sample {
            Pixels::Samples(vec![[0; 4]; count])
        } else {
            Pixels::Sums(vec![[0; PixelSum::WORDS]; count])
        };
        let held = vec![SampleSet::default(); rows.width.div_ceil(TILE) as usize];
        Band {
            rows,
            pixels,
            extra: vec![[0; 3]; count * channels],
            channels,
            is_fresh: true,
            brightest: Vec::new(),
            held,
            adaptive: Vec::new(),
            labels: Vec::new(),
            non_finite: NonFinite::default(),
        }
    }

    /// Fills pixels and channels with zeros before they are changed for the first time.
    fn touch(&mut self) {
        if std::mem::take(&mut self.is_fresh) {
            match &mut self.pixels {
                Pixels::Samples(pixels) => pixels.fill([0; 4]),
                Pixels::Sums(pixels) => pixels.fill([0; PixelSum::WORDS]),
            }
            self.extra.fill([0; 3]);
        }
    }

    /// The pixels.
    pub(super) fn pixels(&self) -> &Pixels {
        &self.pixels
    }

    /// The same, mutable.
    pub(super) fn pixels_mut(&mut self) -> &mut Pixels {
        self.touch();
        &mut self.pixels
    }

    /// The number of pixels.
    pub(super) fn pixel_count(&self) -> usize {
        self.rows.area() as usize
    }

    /// Bytes per pixel.
    pub(super) fn bytes_per_pixel(one_sample: bool, channels: usize) -> usize {
        let color = if one_sample { size_of::<[u32; 4]>() } else { PixelSum::BYTES };
        color + channels * size_of::<[u32; 3]>()
    }

    /// Index of the first pixel of each row of a rectangle inside the band.
    fn row_starts(&self, rect: &PixelRect) -> impl Iterator<Item = usize> + Clone + use<> {
        let stride = self.rows.width as usize;
        let first = (rect.y - self.rows.y) as usize * stride + (rect.x - self.rows.x) as usize;
        (0..rect.height as usize).map(move |row| first + row * stride)
    }

    /// The indices of a rectangle's pixels inside the band, row by row.
    pub(super) fn indices(&self, rect: &PixelRect) -> impl Iterator<Item = usize> + Clone + use<> {
        let width = rect.width as usize;
        self.row_starts(rect).flat_map(move |start| start..start + width)
    }

    /// The pixels of a tile.
    pub(super) fn tile(&self, column: usize) -> PixelRect {
        TileGrid::new(self.rows).rect(column)
    }

    /// The samples of half of a tile.
    pub(super) fn held_half(&self, column: usize, half: Half) -> &SampleSet {
        match (half, self.adaptive.get(column)) {
            (Half::Odd, Some(adaptive)) => &adaptive.odd,
            _ => &self.held[column],
        }
    }

    /// The sets of samples of all tiles and halves.
    pub(super) fn sets(&self) -> impl Iterator<Item = &SampleSet> {
        self.held.iter().chain(self.adaptive.iter().map(|tile| &tile.odd))
    }

    /// Records that a tile, or only one half of it, holds more samples, and the non-finite ones among them. Returns
    /// false if it already holds one of them: then they must not be added.
    pub(super) fn record(
        &mut self,
        column: usize,
        half: Option<Half>,
        samples: &SampleSet,
        non_finite: &NonFinite,
    ) -> bool {
        let halves = half.as_ref().map_or(&Half::BOTH[..], std::slice::from_ref);
        if halves.iter().any(|half| self.held_half(column, *half).overlap(samples).is_some()) {
            return false;
        }
        for &half in halves {
            match (half, self.adaptive.get_mut(column)) {
                (Half::Odd, Some(adaptive)) => adaptive.odd.insert_all(samples),
                (Half::Odd, None) => {}
                (Half::Even, _) => self.held[column].insert_all(samples),
            }
        }
        self.non_finite.merge(non_finite);
        true
    }

    /// Adds one sample (colour times coverage, and coverage 0..=1) to each pixel of a rectangle inside the band,
    /// row by row.
    pub(super) fn add_samples(
        &mut self,
        rect: &PixelRect,
        samples: impl Iterator<Item = (Spectrum, f32)> + Clone,
    ) {
        let starts = self.row_starts(rect);
        let width = rect.width as usize;
        if let Pixels::Samples(pixels) = self.pixels_mut() {
            let free = starts.clone().all(|at| pixels[at..at + width].iter().all(|p| *p == [0; 4]));
            if free {
                let mut samples = samples;
                for start in starts {
                    for (pixel, (color, alpha)) in pixels[start..start + width].iter_mut().zip(&mut samples) {
                        let [r, g, b] = color.to_array().map(f32::to_bits);
                        *pixel = [r, g, b, alpha.to_bits() | HAS_SAMPLE];
                    }
                }
                return;
            }
        }
        let pixels = self.sums_mut();
        let indices = starts.flat_map(|start| start..start + width);
        for (i, (color, alpha)) in indices.zip(samples) {
            let mut sum = PixelSum::from_words(&pixels[i]);
            sum.add_or_omit(color, alpha);
            pixels[i] = sum.to_words();
        }
    }

    /// Adds the part of a tile's sums that lies in the band.
    pub(super) fn add_sums(&mut self, sums: &TileSums) {
        let (rect, rows) = (sums.rect(), self.rows);
        let width = rect.width as usize;
        let (top, bottom) = (rect.y.max(rows.y), (rect.y + rect.height).min(rows.y + rows.height));
        if top >= bottom {
            return;
        }
        let part = PixelRect { y: top, height: bottom - top, ..rect };
        let skipped = (top - rect.y) as usize * width;
        let starts = self.row_starts(&part);
        if !self.add_plain(sums, starts.clone(), skipped) {
            self.add_wide(sums, starts.clone(), skipped);
        }
        for (row, start) in starts.enumerate() {
            self.merge_brightest(start, sums, skipped + row * width, width);
        }
    }

    /// Adds a tile's sums of 64 bits, from the pixel `skipped` on, to the rows of pixels that begin at `starts`. Returns
    /// false and adds nothing if some sums need more bits, or if the film has AOVs.
    fn add_plain(&mut self, sums: &TileSums, starts: impl Iterator<Item = usize>, skipped: usize) -> bool {
        let (channels, width) = (self.channels, sums.rect().width as usize);
        let of_error = if sums.estimates_error { ERROR_SUMS } else { 0 };
        if channels != of_error || !sums.pixels.are_plain() {
            return false;
        }
        self.sums_mut();
        let Pixels::Sums(pixels) = &mut self.pixels else { return false };
        for (row, start) in starts.enumerate() {
            let words = pixels[start..start + width].iter_mut().zip(skipped + row * width..);
            let error = &mut self.extra[start * channels..(start + width) * channels];
            match sums.estimates_error {
                true => words.zip(error.as_chunks_mut().0).for_each(|((words, i), error)| {
                    sums.pixels.add_to_words(i, words, Some(error));
                }),
                false => words.for_each(|(words, i)| sums.pixels.add_to_words(i, words, None)),
            }
        }
        true
    }

    /// The same for sums of any size, and with AOVs.
    fn add_wide(&mut self, sums: &TileSums, starts: impl Iterator<Item = usize> + Clone, skipped: usize) {
        let (channels, width) = (self.channels, sums.rect().width as usize);
        let pixels = self.sums_mut();
        for (row, start) in starts.clone().enumerate() {
            let first = skipped + row * width;
            for (words, i) in pixels[start..start + width].iter_mut().zip(first..) {
                let mut pixel = PixelSum::from_words(words);
                pixel.merge(&sums.pixels.narrow(i));
                *words = pixel.to_words();
            }
        }
        if channels > 0 {
            for (row, start) in starts.enumerate() {
                let first = skipped + row * width;
                let own = &mut self.extra[start * channels..(start + width) * channels];
                for (words, sum) in own.iter_mut().zip(sums.extra_of(first..first + width)) {
                    *words = Fixed96::from_words(*words).plus(Fixed96::from_i128(sum)).to_words();
                }
            }
        }
    }

    /// Adds the sums of a tile of another film in the same rows, and the set of its samples.
    pub(super) fn merge_tile(&mut self, other: &Band, column: usize) {
        let rect = self.tile(column);
        let indices = self.indices(&rect);
        self.touch();
        self.held[column].insert_all(&other.held[column]);
        if let (Some(own), Some(theirs)) = (self.adaptive.get_mut(column), other.adaptive.get(column)) {
            own.odd.insert_all(&theirs.odd);
            own.rays += theirs.rays;
        }
        match (&mut self.pixels, &other.pixels) {
            (Pixels::Samples(own), Pixels::Samples(theirs))
                if indices.clone().all(|i| own[i] == [0; 4] || theirs[i] == [0; 4]) =>
            {
                for i in indices.clone().filter(|i| theirs[*i] != [0; 4]) {
                    own[i] = theirs[i];
                }
            }
            // A tile without samples must not convert samples to sums.
            (_, Pixels::Samples(theirs)) if indices.clone().all(|i| theirs[i] == [0; 4]) => {}
            _ => {
                let own = self.sums_mut();
                for i in indices.clone() {
                    let mut sum = PixelSum::from_words(&own[i]);
                    sum.merge(&other.sum(i));
                    own[i] = sum.to_words();
                }
            }
        }
        indices.clone().for_each(|i| self.merge_brightest_pixel(i, other, i));
        let channels = self.channels;
        for i in indices.flat_map(|i| i * channels..(i + 1) * channels) {
            self.extra[i] =
                Fixed96::from_words(self.extra[i]).plus(Fixed96::from_words(other.extra[i])).to_words();
        }
    }

    /// The pixels as sums; converts single samples if necessary.
    pub(super) fn sums_mut(&mut self) -> &mut Vec<[u32; PixelSum::WORDS]> {
        self.touch();
        if let Pixels::Samples(pixels) = &self.pixels {
            self.pixels = Pixels::Sums(pixels.iter().map(|p| sum_of_sample(p).to_words()).collect());
        }
        match &mut self.pixels {
            Pixels::Sums(pixels) => pixels,
            Pixels::Samples(_) => unreachable!("made sums above"),
        }
    }

    /// The single sample of the pixel at an index; `None` without one, or where there are sums.
    #[inline]
    pub(super) fn single(&self, i: usize) -> Option<[f32; 4]> {
        let Pixels::Samples(pixels) = &self.pixels else { return None };
        let [r, g, b, alpha] = pixels[i];
        (alpha & HAS_SAMPLE != 0).then(|| [r, g, b, alpha & !HAS_SAMPLE].map(f32::from_bits))
    }

    /// The mean of the samples of the pixel at an index, as [`PixelSum::mean`].
    #[inline]
    pub(super) fn mean(&self, i: usize) -> Option<[f32; 4]> {
        match self.single(i) {
            // Nearly all single samples are their own mean.
            Some([r, g, b, 1.0]) if [r, g, b].into_iter().all(Fixed96::keeps) => Some([r, g, b, 1.0]),
            _ => self.sum(i).mean(),
        }
    }

    /// The sums of additional channels of the pixel at an index.
    pub(super) fn extra(&self, i: usize) -> &[[u32; 3]] {
        &self.extra[i * self.channels..(i + 1) * self.channels]
    }

    /// The same, mutable.
    pub(super) fn extra_mut(&mut self, i: usize) -> &mut [[u32; 3]] {
        self.touch();
        &mut self.extra[i * self.channels..(i + 1) * self.channels]
    }

    /// The sums of the pixel at an index, row by row.
    pub(super) fn sum(&self, i: usize) -> PixelSum {
        match &self.pixels {
            Pixels::Samples(pixels) => sum_of_sample(&pixels[i]),
            Pixels::Sums(pixels) => PixelSum::from_words(&pixels[i]),
        }
    }

    /// Number of finite samples of all pixels: the samples with weight 1 in the pixel's own tile.
    pub(super) fn samples(&self) -> u64 {
        self.held_samples().saturating_sub(self.non_finite.count)
    }

    /// Number of samples of all pixels.
    pub(super) fn held_samples(&self) -> u64 {
        let grid = TileGrid::new(self.rows);
        let of_tile = |column: usize| match self.adaptive.get(column) {
            Some(adaptive) if adaptive.odd != self.held[column] => {
                let of = |half| grid.half_area(column, half) * self.held_half(column, half).len();
                Half::BOTH.map(of).iter().sum()
            }
            _ => grid.rect(column).area() * self.held[column].len(),
        };
        (0..self.held.len()).map(of_tile).sum()
    }
}

fn sum_of_sample(&[r, g, b, alpha]: &[u32; 4]) -> PixelSum {
    let mut sum = PixelSum::default();
    if alpha & HAS_SAMPLE != 0 {
        let color = Spectrum::from([r, g, b].map(f32::from_bits));
        sum.add_or_omit(color, f32::from_bits(alpha & !HAS_SAMPLE));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sample per pixel is the same whether stored as a sample or as a sum; a second one is added to the
    /// first.
    #[test]
    fn samples_are_the_sums_of_one() {
        let tile = PixelRect { x: 2, y: 1, width: 3, height: 2 };
        let rows = PixelRect { x: 0, y: 0, width: 7, height: 4 };
        let values = [0.25, 1e-20, -3.0, f32::NAN, 7e9, 0.0];
        let samples = values.map(|v| (Spectrum::new(v, 0.5, 1.0), if v < 1.0 { 0.75 } else { 1.0 }));
        let (mut one, mut many) = (Band::new(rows, true, 0), Band::new(rows, false, 0));
        let same = |a: &Band, b: &Band| (0..28).all(|i| a.sum(i) == b.sum(i));
        let weight = |band: &Band| (0..28).map(|i| band.sum(i).weight()).sum::<f64>();
        for round in 0..2 {
            one.add_samples(&tile, samples.iter().copied());
            many.add_samples(&tile, samples.iter().copied());
            assert!(same(&one, &many));
            let means =
                |band: &Band| (0..28).map(|i| band.mean(i).map(|v| v.map(f32::to_bits))).collect::<Vec<_>>();
            assert_eq!(means(&one), means(&many));
            assert_eq!(weight(&one), 5.0 * f64::from(round + 1));
        }
        let mut transparent = Band::new(rows, true, 0);
        transparent.add_samples(&tile, [(Spectrum::BLACK, 0.0); 6].into_iter());
        assert_eq!((weight(&transparent), transparent.sum(9).mean()), (6.0, Some([0.0; 4])));
        assert_eq!(transparent.sum(0).mean(), None);
    }

    #[test]
    fn no_sample_is_recorded_twice() {
        let mut band = Band::new(PixelRect { x: 0, y: 0, width: 20, height: 16 }, false, 0);
        let set = |range| {
            let mut set = SampleSet::default();
            set.insert(range);
            set
        };
        let bad = NonFinite { count: 3, first: None };
        assert!(band.record(1, None, &set(2..5), &bad));
        assert!(!band.record(1, None, &set(4..6), &bad));
        assert_eq!((band.held[1].clone(), band.non_finite.count), (set(2..5), 3));
        // Tile 1 is 4 columns wide.
        assert_eq!(band.samples(), 4 * 16 * 3 - 3);
        assert!(band.record(1, None, &set(5..6), &bad) && band.record(0, None, &set(2..5), &bad));
    }
}
