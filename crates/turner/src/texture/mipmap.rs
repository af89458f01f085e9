//! Mipmaps (Williams 1983, "Pyramidal parametrics") and anisotropic lookups in them.
//!
//! Each level has half the width and height of the one before, rounded down, to a single texel:
//!
//! ```text
//!     +-------+   +---+   +-+
//!     |       |   |   |   +-+ ...   a third more memory in total
//!     |       |   +---+
//!     +-------+
//! ```
//!
//! A texel is the mean over its area in the level before. For odd sizes that are three texels with different weights,
//! so every level has the mean of the image. Means are taken of scene values (after the transfer curve) and weighted
//! by alpha; levels are stored in the image's own format.
//!
//! An isotropic lookup would blur textures at grazing angles, where footprints are long ellipses. An ellipse of
//! length a and width b texels is therefore sampled by ⌈a/b⌉ trilinear lookups ("taps"), at most sixteen, along its
//! major axis, on the levels whose texels are about as wide as b (after McCormack et al. 1999, "Feline: fast
//! elliptical lines for anisotropic texture mapping"):
//!
//! ```text
//!        .-------------------------.
//!      (    x     x     x     x     )     b
//!        `-------------------------´
//!                     a
//! ```
//!
//! After non-specular scattering a lookup is isotropic: bilinear, on a single level.

use super::footprint::Ellipse;
use crate::color::Transfer;
use crate::image::{Image, Pixels};
use crate::math::DVec2;
use crate::math::elementary::ln;

/// The smaller levels of an image, half the size first.
#[derive(Clone, Debug)]
pub(super) struct Mipmap {
    levels: Vec<Image>,
}

/// Maximum number of taps; longer ellipses are widened.
const MAX_TAPS: f64 = 16.0;

/// The taps of an ellipse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taps {
    /// Number of taps along the major axis.
    pub(super) count: u32,
    /// Distance between taps, in texels of the full image.
    pub(super) step: DVec2,
    /// The finer of the two levels; 0 is the full image.
    pub(super) level: usize,
    /// The weight of the coarser level.
    pub(super) coarser: f32,
}

impl Taps {
    /// A single tap on the level whose texels have about the area of the ellipse.
    pub(super) fn isotropic(ellipse: &Ellipse, levels: usize) -> Taps {
        let length = ellipse.length.min(1e9);
        let area = (length * ellipse.width.max(length / MAX_TAPS)).max(1.0);
        let last = levels.saturating_sub(1);
        // log₂ √area, rounded: half the exponent of the area.
        let exponent = (area.to_bits() >> 52) as usize - 1023;
        Taps { count: 1, step: DVec2::ZERO, level: exponent.div_ceil(2).min(last), coarser: 0.0 }
    }

    /// The taps for an ellipse in texels, with `levels` levels including the full image.
    pub(super) fn new(ellipse: &Ellipse, levels: usize) -> Taps {
        let length = ellipse.length.min(1e9);
        let width = ellipse.width.max(length / MAX_TAPS).max(1.0);
        let count = (length / width).ceil().clamp(1.0, MAX_TAPS);
        let level = (ln(width) * std::f64::consts::LOG2_E).clamp(0.0, levels.saturating_sub(1) as f64);
        let whole = level as usize;
        let step = if count > 1.0 { ellipse.major * (length / ellipse.length / count) } else { DVec2::ZERO };
        Taps { count: count as u32, step, level: whole, coarser: (level - whole as f64) as f32 }
    }

    /// Offsets of the taps from the centre, in texels of the full image.
    pub(super) fn offsets(self) -> impl Iterator<Item = DVec2> {
        let center = 0.5 * (f64::from(self.count) - 1.0);
        (0..self.count).map(move |i| self.step * (f64::from(i) - center))
    }
}

impl Mipmap {
    /// The mipmap of a consistent image, decoded by a curve.
    pub(super) fn new(image: &Image, transfer: Transfer) -> Mipmap {
        let curves = Curves::new(image, transfer);
        let mut levels: Vec<Image> = Vec::new();
        let mut last: Option<Values> = None;
        let (mut width, mut height) = (image.width, image.height);
        while width > 1 || height > 1 {
            let values = match (&last, &image.pixels) {
                (None, Pixels::U8(v)) if matches!(image.channels, 1 | 3) => {
                    halved(image.channels, width, height, |i| curves.decoded[usize::from(v[i])])
                }
                (None, _) => halved(image.channels, width, height, |i| curves.decode(image, i)),
                (Some(v), _) => halved(image.channels, width, height, |i| v.samples[i]),
            };
            (width, height) = (values.width, values.height);
            levels.push(curves.encode(&values, image.channels));
            last = Some(values);
        }
        Mipmap { levels }
    }

    /// Number of levels, including the full image.
    pub(super) fn count(&self) -> usize {
        self.levels.len() + 1
    }

    /// A level; `base` is the full image.
    #[inline]
    pub(super) fn level<'a>(&'a self, base: &'a Image, level: usize) -> &'a Image {
        level.checked_sub(1).and_then(|i| self.levels.get(i)).unwrap_or(base)
    }

    /// Bytes of the smaller levels.
    pub(super) fn memory(&self) -> usize {
        self.levels.iter().map(Image::memory).sum()
    }
}

/// A level in scene values, with straight (not premultiplied) alpha as the last channel if there is one.
struct Values {
    width: u32,
    height: u32,
    samples: Vec<f32>,
}

/// The texels of a row of `n` that texel `i` of the next level covers: the first, and their weights.
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

/// The next level: means over areas.
fn halved(channels: u8, width: u32, height: u32, at: impl Fn(usize) -> f32) -> Values {
    let n = usize::from(channels);
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut samples = Vec::with_capacity(w as usize * h as usize * n);
    let has_alpha = matches!(n, 2 | 4);
    if !has_alpha && width.is_multiple_of(2) && height.is_multiple_of(2) {
        // The common case: the same sums, four texels each.
        let row = n * width as usize;
        for y in 0..h as usize {
            for x in 0..w as usize {
                let first = 2 * y * row + 2 * x * n;
                for i in first..first + n {
                    let above = 0.25 * at(i) + 0.25 * at(i + n);
                    samples.push(above + 0.25 * at(i + row) + 0.25 * at(i + row + n));
                }
            }
        }
        return Values { width: w, height: h, samples };
    }
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
                // Invisible texels do not contribute colour.
                samples.extend(weighted[..n - 1].iter().map(|v| v / alpha));
                samples.push(alpha);
            } else {
                samples.extend_from_slice(&plain[..n]);
            }
        }
    }
    Values { width: w, height: h, samples }
}

/// Conversion between image samples and scene values.
struct Curves {
    transfer: Transfer,
    /// Scene values of integer samples.
    decoded: Vec<f32>,
    /// For 8 bits, the nearest sample to each of evenly spaced scene values.
    eight: Vec<u8>,
    channels: usize,
}

/// Entries of the table from scene values to 8 bits: five per narrowest interval of the curve.
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

    /// Whether a sample is alpha, to which no curve applies.
    #[inline]
    fn is_alpha(&self, i: usize) -> bool {
        matches!(self.channels, 2 | 4) && i % self.channels == self.channels - 1
    }

    #[inline]
    fn decode(&self, image: &Image, i: usize) -> f32 {
        let curve = |v: usize, max: f32| if self.is_alpha(i) { v as f32 / max } else { self.decoded[v] };
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
        let eight = |v: f32| self.eight[((v * STEPS as f32 + 0.5) as usize).min(STEPS)];
        let has_alpha = matches!(self.channels, 2 | 4);
        let pixels = match (self.eight.is_empty(), self.decoded.is_empty()) {
            (false, _) if !has_alpha => Pixels::U8(samples.iter().map(|v| eight(*v)).collect()),
            (false, _) => Pixels::U8(
                own()
                    .map(|(i, v)| if self.is_alpha(i) { (v * 255.0 + 0.5) as u8 } else { eight(*v) })
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
                // Except for the last levels, which are one texel wide.
                assert!(mipmap.memory() <= image.memory() / 3 + 16);
            }
        }
        let sixteen = Image { width: 4, height: 4, channels: 1, pixels: Pixels::U16(vec![12_345; 16]) };
        let mipmap = Mipmap::new(&sixteen, Transfer::Srgb);
        assert_eq!(mipmap.level(&sixteen, 2).pixels, Pixels::U16(vec![12_345]));
    }

    #[test]
    fn display_values_are_averaged_in_linear_light() {
        let pixels = Pixels::U8(vec![0, 255, 255, 0]);
        let image = Image { width: 2, height: 2, channels: 1, pixels };
        let half = |transfer| Mipmap::new(&image, transfer).levels[0].pixels.clone();
        // sRGB of one half is 187.5.
        assert_eq!(half(Transfer::Srgb), Pixels::U8(vec![188]));
        assert_eq!(half(Transfer::None), Pixels::U8(vec![128]));
    }

    #[test]
    fn colours_are_weighted_by_alpha() {
        let pixels = Pixels::U8(vec![200, 255, 10, 0]);
        let image = Image { width: 2, height: 1, channels: 2, pixels };
        assert_eq!(Mipmap::new(&image, Transfer::None).levels[0].pixels, Pixels::U8(vec![200, 128]));
        let unseen = Image { pixels: Pixels::U8(vec![200, 0, 10, 0]), ..image };
        assert_eq!(Mipmap::new(&unseen, Transfer::None).levels[0].pixels, Pixels::U8(vec![105, 0]));
    }

    #[test]
    fn taps_cover_the_ellipse() {
        let taps = |a: DVec2, b: DVec2| Taps::new(&Ellipse::new([a, b]), 8);
        // Smaller than a texel: the full image, one tap.
        let point = taps(DVec2::new(0.3, 0.0), DVec2::new(0.0, 0.1));
        assert_eq!((point.count, point.level, point.coarser), (1, 0, 0.0));
        // Round: one tap between levels.
        let round = taps(DVec2::new(0.0, 4.0), DVec2::new(-4.0, 0.0));
        assert_eq!((round.count, round.level), (1, 2));
        assert!(round.coarser < 1e-9);
        // Long: several taps; they extend as far as the axis minus their own width.
        let long = taps(DVec2::new(0.0, 8.0), DVec2::new(2.0, 0.0));
        assert_eq!((long.count, long.level), (4, 1));
        let offsets: Vec<_> = long.offsets().collect();
        assert!((offsets[3] - offsets[0]).length() - 6.0 < 1e-9);
        assert!(offsets.iter().sum::<DVec2>().length() < 1e-9);
        // Too long: wider taps.
        let longest = taps(DVec2::new(64.0, 0.0), DVec2::new(0.0, 1.0));
        assert_eq!((longest.count, longest.level), (16, 2));
        // The last level is the coarsest.
        assert_eq!(taps(DVec2::new(1e9, 0.0), DVec2::new(0.0, 1e9)).level, 7);
    }
}
