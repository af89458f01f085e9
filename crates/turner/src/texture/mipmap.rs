//! Pictures at halved sizes (Williams 1983, "Pyramidal parametrics"), and look-ups of elongated footprints in them.
//!
//! Each level halves width and height, rounded down, down to one texel. A texel is the mean over the area that it covers of the picture, also where a size is odd (weights of
//! three texels), so that every level has the picture's mean. Means are taken of scene values (after the transfer curve), of colours weighted by alpha where
//! there is one, and stored as the picture is: the pyramid takes a third of the picture's memory more.
//!
//! An ellipse of length a and width b texels is looked up at ⌈a/b⌉ places along its major axis, at most sixteen, on the level whose texels are as wide as
//! b, between levels by their weights (after McCormack et al. 1999, "Feline: fast elliptical lines for anisotropic texture mapping").

use super::footprint::Ellipse;
use crate::color::Transfer;
use crate::image::{Image, Pixels};
use crate::math::DVec2;
use crate::math::elementary::ln;

/// The smaller sizes of a picture, half the size first.
#[derive(Clone, Debug)]
pub(super) struct Mipmap {
    levels: Vec<Image>,
}

/// Footprints are looked up as if no longer than so many of their widths.
const MOST_TAPS: f64 = 16.0;

/// Where an ellipse is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taps {
    /// How many places along the major axis.
    pub(super) count: u32,
    /// From one to the next, in texels of the picture itself.
    pub(super) step: DVec2,
    /// The finer of the two levels; 0 is the picture itself.
    pub(super) level: usize,
    /// The share of the coarser one.
    pub(super) coarser: f32,
}

impl Taps {
    /// For an ellipse in texels, on a pyramid of so many levels, the picture itself counted.
    pub(super) fn new(ellipse: &Ellipse, levels: usize) -> Taps {
        let length = ellipse.length.min(1e9);
        let width = ellipse.width.max(length / MOST_TAPS).max(1.0);
        let count = (length / width).ceil().clamp(1.0, MOST_TAPS);
        let level = (ln(width) * std::f64::consts::LOG2_E).clamp(0.0, levels.saturating_sub(1) as f64);
        let whole = level as usize;
        let step = if count > 1.0 { ellipse.major * (length / ellipse.length / count) } else { DVec2::ZERO };
        Taps { count: count as u32, step, level: whole, coarser: (level - whole as f64) as f32 }
    }

    /// The places, in texels of the picture from its middle.
    pub(super) fn offsets(self) -> impl Iterator<Item = DVec2> {
        let middle = 0.5 * (f64::from(self.count) - 1.0);
        (0..self.count).map(move |i| self.step * (f64::from(i) - middle))
    }
}

impl Mipmap {
    /// Of a picture whose samples fit its size, decoded by a curve.
    pub(super) fn new(image: &Image, transfer: Transfer) -> Mipmap {
        let curves = Curves::new(image, transfer);
        let mut levels: Vec<Image> = Vec::new();
        let mut last: Option<Values> = None;
        let (mut width, mut height) = (image.width, image.height);
        while width > 1 || height > 1 {
            let values = match &last {
                None => halved(image.channels, width, height, |i| curves.decode(image, i)),
                Some(v) => halved(image.channels, width, height, |i| v.samples[i]),
            };
            (width, height) = (values.width, values.height);
            levels.push(curves.encode(&values, image.channels));
            last = Some(values);
        }
        Mipmap { levels }
    }

    /// How many levels there are, the picture itself counted.
    pub(super) fn count(&self) -> usize {
        self.levels.len() + 1
    }

    /// A level of the picture that it was made of.
    #[inline]
    pub(super) fn level<'a>(&'a self, base: &'a Image, level: usize) -> &'a Image {
        level.checked_sub(1).and_then(|i| self.levels.get(i)).unwrap_or(base)
    }

    /// Bytes of the smaller sizes.
    pub(super) fn memory(&self) -> usize {
        self.levels.iter().map(Image::memory).sum()
    }
}

/// A level in scene values, with straight alpha as the last channel where there is one.
struct Values {
    width: u32,
    height: u32,
    samples: Vec<f32>,
}

/// The texels that texel `i` of `m` covers of `n`, m = ⌊n/2⌋ or 1: the first, and their weights.
fn covered(i: u32, n: u32) -> (u32, [f32; 3]) {
    if n == 1 {
        return (0, [1.0, 0.0, 0.0]);
    }
    if n.is_multiple_of(2) {
        return (2 * i, [0.5, 0.5, 0.0]);
    }
    let (m, n, i) = ((n / 2) as f32, n as f32, i as f32);
    (2 * i as u32, [(m - i) / n, m / n, (i + 1.0) / n])
}

/// Half the size, by means over areas.
fn halved(channels: u8, width: u32, height: u32, at: impl Fn(usize) -> f32) -> Values {
    let n = usize::from(channels);
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut samples = Vec::with_capacity(w as usize * h as usize * n);
    let has_alpha = matches!(n, 2 | 4);
    for y in 0..h {
        let (y0, rows) = covered(y, height);
        for x in 0..w {
            let (x0, columns) = covered(x, width);
            let (mut plain, mut weighted) = ([0.0f32; 4], [0.0f32; 4]);
            for (dy, wy) in rows.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                let row = (y0 as usize + dy) * width as usize;
                for (dx, wx) in columns.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                    let first = (row + x0 as usize + dx) * n;
                    let weight = wx * wy;
                    let alpha = if has_alpha { at(first + n - 1) } else { 1.0 };
                    for c in 0..n {
                        let v = at(first + c);
                        plain[c] += weight * v;
                        weighted[c] += weight * alpha * v;
                    }
                }
            }
            let alpha = plain[n - 1];
            if has_alpha && alpha > 0.0 {
                // What cannot be seen has no colour to give.
                samples.extend(weighted[..n - 1].iter().map(|v| v / alpha));
                samples.push(alpha);
            } else {
                samples.extend_from_slice(&plain[..n]);
            }
        }
    }
    Values { width: w, height: h, samples }
}

/// Between the samples of a picture and scene values.
struct Curves {
    transfer: Transfer,
    /// Scene values of the samples of integer pictures.
    decoded: Vec<f32>,
    /// Of eight bits, the sample nearest to each of evenly spaced scene values.
    eight: Vec<u8>,
    channels: usize,
}

/// Steps of the table from scene values to eight bits: five to the narrowest interval of the curve.
const STEPS: usize = 1 << 14;

impl Curves {
    fn new(image: &Image, transfer: Transfer) -> Curves {
        let table = |n: usize| (0..=n).map(move |i| i as f32 / n as f32);
        let decoded = match image.pixels {
            Pixels::U8(_) => table(255).map(|v| transfer.decode(v)).collect(),
            Pixels::U16(_) => table(65535).map(|v| transfer.decode(v)).collect(),
            Pixels::F32(_) => Vec::new(),
        };
        let eight = match image.pixels {
            Pixels::U8(_) => table(STEPS).map(|v| (transfer.encode(v) * 255.0 + 0.5) as u8).collect(),
            _ => Vec::new(),
        };
        Curves { transfer, decoded, eight, channels: usize::from(image.channels) }
    }

    /// Whether a sample is alpha, which has no curve.
    #[inline]
    fn is_alpha(&self, i: usize) -> bool {
        matches!(self.channels, 2 | 4) && i % self.channels == self.channels - 1
    }

    #[inline]
    fn decode(&self, image: &Image, i: usize) -> f32 {
        let curve = |v: usize, most: f32| if self.is_alpha(i) { v as f32 / most } else { self.decoded[v] };
        match &image.pixels {
            Pixels::U8(v) => curve(usize::from(v[i]), 255.0),
            Pixels::U16(v) => curve(usize::from(v[i]), 65535.0),
            Pixels::F32(v) if v[i].is_finite() => {
                if self.is_alpha(i) {
                    v[i].max(0.0)
                } else {
                    v[i]
                }
            }
            Pixels::F32(_) => 0.0,
        }
    }

    fn encode(&self, values: &Values, channels: u8) -> Image {
        let Values { width, height, samples } = values;
        let own = || samples.iter().enumerate();
        let pixels = match (self.eight.is_empty(), self.decoded.is_empty()) {
            (false, _) => Pixels::U8(
                own()
                    .map(|(i, v)| match self.is_alpha(i) {
                        true => (v * 255.0 + 0.5) as u8,
                        false => self.eight[((v * STEPS as f32 + 0.5) as usize).min(STEPS)],
                    })
                    .collect(),
            ),
            (true, false) => {
                let curve = |i, v: f32| if self.is_alpha(i) { v } else { self.transfer.encode(v) };
                Pixels::U16(own().map(|(i, v)| (curve(i, *v) * 65535.0 + 0.5) as u16).collect())
            }
            (true, true) => Pixels::F32(samples.clone()),
        };
        Image { width: *width, height: *height, channels, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, at: impl Fn(u32) -> f32) -> Image {
        let samples = (0..width * height).map(at).collect();
        Image { width, height, channels: 1, pixels: Pixels::F32(samples) }
    }

    fn mean(image: &Image) -> f64 {
        let all = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
        all.map(|(x, y)| f64::from(image.rgb(x, y)[0])).sum::<f64>() / f64::from(image.width * image.height)
    }

    #[test]
    fn every_level_has_the_mean_of_the_picture() {
        for (width, height) in [(8, 8), (7, 5), (1, 9), (13, 1), (64, 3), (1, 1)] {
            let image = grey(width, height, |i| ((i * 7919) % 101) as f32 / 100.0);
            let mipmap = Mipmap::new(&image, Transfer::Srgb);
            for level in 0..mipmap.count() {
                let found = mean(mipmap.level(&image, level));
                assert!((found - mean(&image)).abs() < 1e-6, "{width}x{height} level {level}: {found}");
            }
            let last = mipmap.level(&image, mipmap.count() - 1);
            assert_eq!((last.width, last.height), (1, 1));
        }
    }

    #[test]
    fn constants_stay_constant_and_memory_grows_by_a_third() {
        for transfer in [Transfer::None, Transfer::Srgb] {
            for value in [0u8, 1, 3, 77, 200, 255] {
                let pixels = Pixels::U8([value, 255 - value, value, 128].repeat(64 * 32));
                let image = Image { width: 64, height: 32, channels: 4, pixels };
                let mipmap = Mipmap::new(&image, transfer);
                for level in 0..mipmap.count() {
                    let Pixels::U8(v) = &mipmap.level(&image, level).pixels else { panic!("eight bits") };
                    assert!(
                        v.chunks(4).all(|c| c == [value, 255 - value, value, 128]),
                        "{transfer:?} {value}"
                    );
                }
                // But for the last levels, which are a texel wide.
                assert!(mipmap.memory() <= image.memory() / 3 + 16);
            }
        }
        let sixteen = Image { width: 4, height: 4, channels: 1, pixels: Pixels::U16(vec![12_345; 16]) };
        let mipmap = Mipmap::new(&sixteen, Transfer::Srgb);
        assert_eq!(mipmap.level(&sixteen, 2).pixels, Pixels::U16(vec![12_345]));
    }

    #[test]
    fn display_values_are_averaged_as_light() {
        let pixels = Pixels::U8(vec![0, 255, 255, 0]);
        let image = Image { width: 2, height: 2, channels: 1, pixels };
        let half = |transfer| Mipmap::new(&image, transfer).levels[0].pixels.clone();
        // sRGB of one half is 187.5.
        assert_eq!(half(Transfer::Srgb), Pixels::U8(vec![188]));
        assert_eq!(half(Transfer::None), Pixels::U8(vec![128]));
    }

    #[test]
    fn colours_count_as_far_as_they_are_seen() {
        let pixels = Pixels::U8(vec![200, 255, 10, 0]);
        let image = Image { width: 2, height: 1, channels: 2, pixels };
        assert_eq!(Mipmap::new(&image, Transfer::None).levels[0].pixels, Pixels::U8(vec![200, 128]));
        let unseen = Image { pixels: Pixels::U8(vec![200, 0, 10, 0]), ..image };
        assert_eq!(Mipmap::new(&unseen, Transfer::None).levels[0].pixels, Pixels::U8(vec![105, 0]));
    }

    #[test]
    fn taps_cover_the_ellipse() {
        let taps = |a: DVec2, b: DVec2| Taps::new(&Ellipse::new([a, b]), 8);
        // Smaller than a texel: the picture itself, once.
        let point = taps(DVec2::new(0.3, 0.0), DVec2::new(0.0, 0.1));
        assert_eq!((point.count, point.level, point.coarser), (1, 0, 0.0));
        // Round: one place between levels.
        let round = taps(DVec2::new(0.0, 4.0), DVec2::new(-4.0, 0.0));
        assert_eq!((round.count, round.level), (1, 2));
        assert!(round.coarser < 1e-9);
        // Long: several places, which reach as far as the axis less their own width.
        let long = taps(DVec2::new(0.0, 8.0), DVec2::new(2.0, 0.0));
        assert_eq!((long.count, long.level), (4, 1));
        let places: Vec<_> = long.offsets().collect();
        assert!((places[3] - places[0]).length() - 6.0 < 1e-9);
        assert!(places.iter().sum::<DVec2>().length() < 1e-9);
        // Too long: wider ones.
        let longest = taps(DVec2::new(64.0, 0.0), DVec2::new(0.0, 1.0));
        assert_eq!((longest.count, longest.level), (16, 2));
        // The last level is the coarsest.
        assert_eq!(taps(DVec2::new(1e9, 0.0), DVec2::new(0.0, 1e9)).level, 7);
    }
}
