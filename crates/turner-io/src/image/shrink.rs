//! Downscales images by halves, with a box filter.
//!
//! A side of 2n pixels becomes n: 2 pixels are averaged. A side of 2n + 1 also becomes n: each new pixel is the mean
//! over exactly (2n + 1) / n old pixels, with fractional weights at the ends. So nothing shifts, and the mean of the
//! image is preserved.

use super::limits::buffer;
use super::{ColorOrData, ImageError};
use turner::color::{srgb_decode, srgb_encode};
use turner::image::{Image, Pixels};

/// Halves an image until no side is longer than `max` (at least 1).
pub(crate) fn to_fit(
    mut image: Image,
    max: u32,
    used_as: ColorOrData,
    name: &str,
) -> Result<Image, ImageError> {
    let max = max.max(1);
    while image.width > max || image.height > max {
        image = halve(&image, used_as, name)?;
    }
    Ok(image)
}

fn halve(image: &Image, used_as: ColorOrData, name: &str) -> Result<Image, ImageError> {
    let is_color = used_as == ColorOrData::Color;
    let pixels = match &image.pixels {
        Pixels::U8(v) if is_color => {
            let linear: Vec<f32> = (0..=u8::MAX).map(|v| srgb_decode(f32::from(v) / 255.0)).collect();
            let nearest = Nearest::new();
            let light = Light { decode: |v: u8| linear[usize::from(v)], encode: |v: f32| nearest.of(v) };
            Pixels::U8(means(image, v, &light, &eight(), name)?)
        }
        Pixels::U8(v) => Pixels::U8(means(image, v, &eight(), &eight(), name)?),
        Pixels::U16(v) if is_color => {
            let linear: Vec<f32> = (0..=u16::MAX).map(|v| srgb_decode(f32::from(v) / 65535.0)).collect();
            let light = Light {
                decode: |v: u16| linear[usize::from(v)],
                encode: |v: f32| (srgb_encode(v) * 65535.0 + 0.5) as u16,
            };
            Pixels::U16(means(image, v, &light, &sixteen(), name)?)
        }
        Pixels::U16(v) => Pixels::U16(means(image, v, &sixteen(), &sixteen(), name)?),
        Pixels::F32(v) => {
            let plain = Light { decode: |v: f32| v, encode: |v: f32| v };
            Pixels::F32(means(image, v, &plain, &plain, name)?)
        }
    };
    Ok(Image { width: half(image.width), height: half(image.height), channels: image.channels, pixels })
}

/// Conversions of samples to values that can be averaged, and back.
struct Light<D, E> {
    decode: D,
    encode: E,
}

fn eight() -> Light<impl Fn(u8) -> f32, impl Fn(f32) -> u8> {
    Light { decode: f32::from, encode: |v| (v + 0.5) as u8 }
}

fn sixteen() -> Light<impl Fn(u16) -> f32, impl Fn(f32) -> u16> {
    Light { decode: f32::from, encode: |v| (v + 0.5) as u16 }
}

/// Encodes linear values to the nearest 8-bit sRGB value without evaluating a power per pixel.
struct Nearest {
    /// Entry i is the linear value halfway between the codes i and i + 1; values above it become i + 1.
    midpoints: Vec<f32>,
    /// For each 4096th of the range, the code of its lower end.
    first: Vec<u8>,
}

impl Nearest {
    const STEPS: f32 = 4096.0;

    fn new() -> Nearest {
        let midpoints: Vec<f32> = (0..255_u8).map(|v| srgb_decode((f32::from(v) + 0.5) / 255.0)).collect();
        let value = |light: f32| midpoints.partition_point(|m| *m <= light) as u8;
        let first = (0..=4096_u16).map(|i| value(f32::from(i) / Self::STEPS)).collect();
        Nearest { midpoints, first }
    }

    fn of(&self, light: f32) -> u8 {
        let step = ((light * Self::STEPS) as usize).min(self.first.len() - 1);
        let mut value = self.first[step];
        while self.midpoints.get(usize::from(value)).is_some_and(|m| *m <= light) {
            value += 1;
        }
        value
    }
}

fn half(side: u32) -> u32 {
    (side / 2).max(1)
}

/// The old pixels under new pixel `i`, with their weights.
fn taps(i: u32, side: u32) -> [(usize, f32); 3] {
    let n = half(side);
    let whole = side as f32;
    let at = |k: u32| (2 * i + k).min(side - 1) as usize;
    match side {
        1 => [(0, 1.0), (0, 0.0), (0, 0.0)],
        _ if side.is_multiple_of(2) => [(at(0), 0.5), (at(1), 0.5), (at(1), 0.0)],
        _ => [(at(0), (n - i) as f32 / whole), (at(1), n as f32 / whole), (at(2), (i + 1) as f32 / whole)],
    }
}

/// Halves the samples, converting colour channels by `color` and alpha by `alpha`. Samples with weight 0 are skipped,
/// so that an infinite sample does not turn its neighbours into NaN.
fn means<T: Copy + Default, D: Fn(T) -> f32, E: Fn(f32) -> T, D2: Fn(T) -> f32, E2: Fn(f32) -> T>(
    image: &Image,
    samples: &[T],
    color: &Light<D, E>,
    alpha: &Light<D2, E2>,
    name: &str,
) -> Result<Vec<T>, ImageError> {
    let n = usize::from(image.channels);
    let (width, height) = (half(image.width), half(image.height));
    let row = image.width as usize * n;
    let mut out = buffer(width as usize * height as usize * n, name)?;
    let alpha_channel = if matches!(n, 2 | 4) { n - 1 } else { n };
    if image.width.is_multiple_of(2) && image.height.is_multiple_of(2) {
        // The usual case, several times as fast: blocks of 2 x 2 pixels with equal weights.
        for (out, rows) in out.chunks_exact_mut(width as usize * n).zip(samples.chunks_exact(2 * row)) {
            let (upper, lower) = rows.split_at(row);
            let pairs = upper.chunks_exact(2 * n).zip(lower.chunks_exact(2 * n));
            for (pixel, (a, b)) in out.chunks_exact_mut(n).zip(pairs) {
                for (c, sample) in pixel.iter_mut().enumerate() {
                    let four = [a[c], a[n + c], b[c], b[n + c]];
                    *sample = if c == alpha_channel {
                        (alpha.encode)(quarters(four, &alpha.decode))
                    } else {
                        (color.encode)(quarters(four, &color.decode))
                    };
                }
            }
        }
        return Ok(out);
    }
    let columns: Vec<_> = (0..width).map(|x| taps(x, image.width)).collect();
    for (y, out) in (0..height).zip(out.chunks_exact_mut(width as usize * n)) {
        let rows = taps(y, image.height);
        let pixels = out.chunks_exact_mut(n).zip(&columns);
        for (pixel, columns) in pixels {
            for (c, sample) in pixel.iter_mut().enumerate() {
                *sample = if c == alpha_channel {
                    (alpha.encode)(mean(&samples[c..], row, n, &rows, columns, &alpha.decode))
                } else {
                    (color.encode)(mean(&samples[c..], row, n, &rows, columns, &color.decode))
                };
            }
        }
    }
    Ok(out)
}

#[inline]
fn quarters<T: Copy>(samples: [T; 4], decode: impl Fn(T) -> f32) -> f32 {
    samples.iter().fold(0.0, |sum, v| sum + 0.25 * decode(*v))
}

/// The weighted mean of the samples under a new pixel. Samples are `row` apart between rows and `n` between columns.
#[inline]
fn mean<T: Copy>(
    samples: &[T],
    row: usize,
    n: usize,
    rows: &[(usize, f32); 3],
    columns: &[(usize, f32); 3],
    decode: impl Fn(T) -> f32,
) -> f32 {
    let mut sum = 0.0;
    for (y, wy) in rows.iter().filter(|(_, w)| *w > 0.0) {
        for (x, wx) in columns.iter().filter(|(_, w)| *w > 0.0) {
            sum += wy * wx * decode(samples[y * row + x * n]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use ColorOrData::{Color, Data};

    fn image(width: u32, height: u32, channels: u8, pixels: Pixels) -> Image {
        Image { width, height, channels, pixels }
    }

    #[test]
    fn colours_are_averaged_as_light_and_data_as_numbers() {
        let black_and_white = image(2, 2, 1, Pixels::U8(vec![0, 255, 255, 0]));
        let data = to_fit(black_and_white.clone(), 1, Data, "x").unwrap();
        assert_eq!(data.pixels, Pixels::U8(vec![128]));
        // sRGB of half the light is 188.
        let color = to_fit(black_and_white, 1, Color, "x").unwrap();
        assert_eq!(color.pixels, Pixels::U8(vec![188]));
        let sixteen = image(2, 1, 1, Pixels::U16(vec![0, 65535]));
        assert_eq!(to_fit(sixteen.clone(), 1, Data, "x").unwrap().pixels, Pixels::U16(vec![32768]));
        // 65535 · (1.055 · 0.5^(1/2.4) − 0.055)
        assert_eq!(to_fit(sixteen, 1, Color, "x").unwrap().pixels, Pixels::U16(vec![48192]));
        let floats = image(2, 2, 1, Pixels::F32(vec![1.0, 2.0, 3.0, 1000.0]));
        assert_eq!(to_fit(floats, 1, Color, "x").unwrap().pixels, Pixels::F32(vec![251.5]));
    }

    #[test]
    fn alpha_is_never_curved() {
        let picture = image(2, 1, 4, Pixels::U8(vec![0, 0, 0, 0, 255, 255, 255, 255]));
        let small = to_fit(picture, 1, Color, "x").unwrap();
        assert_eq!(small.pixels, Pixels::U8(vec![188, 188, 188, 128]));
        let grey = image(2, 1, 2, Pixels::U8(vec![0, 0, 255, 255]));
        assert_eq!(to_fit(grey, 1, Color, "x").unwrap().pixels, Pixels::U8(vec![188, 128]));
    }

    #[test]
    fn a_constant_stays_and_every_value_survives() {
        for v in 0..=255_u8 {
            for used_as in [Color, Data] {
                let small = to_fit(image(5, 3, 3, Pixels::U8(vec![v; 45])), 2, used_as, "x").unwrap();
                assert_eq!((small.width, small.height), (2, 1));
                assert_eq!(small.pixels, Pixels::U8(vec![v; 6]), "{used_as:?}");
            }
        }
    }

    #[test]
    fn the_nearest_value_is_the_nearest() {
        let nearest = Nearest::new();
        for i in 0..=100_000_u32 {
            let light = i as f32 / 100_000.0;
            let value = nearest.of(light);
            assert_eq!(usize::from(value), nearest.midpoints.partition_point(|m| *m <= light));
            assert!((f32::from(value) - srgb_encode(light) * 255.0).abs() < 0.5001, "{light}: {value}");
        }
    }

    #[test]
    fn odd_sides_keep_the_mean_and_the_place() {
        let ramp: Vec<f32> = (0..7).map(|v| v as f32).collect();
        let small = to_fit(image(7, 1, 1, Pixels::F32(ramp)), 3, Data, "x").unwrap();
        let Pixels::F32(v) = small.pixels else { panic!("floats stay floats") };
        // The first third covers pixels 0 and 1 and a third of pixel 2: 5/3 over 7/3 pixels.
        for (found, expected) in v.iter().zip([5.0 / 7.0, 3.0, 37.0 / 7.0]) {
            assert!((found - expected).abs() < 1e-6, "{v:?}");
        }
        assert!((v.iter().sum::<f32>() / 3.0 - 3.0).abs() < 1e-6);
    }

    #[test]
    fn halved_until_it_fits_and_no_further() {
        let picture = image(64, 2, 1, Pixels::U8(vec![9; 128]));
        let sizes: Vec<_> = [64, 63, 16, 1, 0]
            .iter()
            .map(|&max| to_fit(picture.clone(), max, Data, "x").unwrap())
            .map(|i| (i.width, i.height, i.is_consistent()))
            .collect();
        assert_eq!(sizes, [(64, 2, true), (32, 1, true), (16, 1, true), (1, 1, true), (1, 1, true)]);
    }
}
