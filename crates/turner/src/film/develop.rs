//! Developing: from sums to a picture.
//!
//! A pixel's scene value is its weighted mean plus the light of light paths. Its display value is round(255 ·
//! encode(tonemap(2^exposure · value / alpha))).

use super::exposure::{Luminances, factor};
use super::{Antialias, Film, FilmDesc};
use crate::color::{Spectrum, Tonemap, Transfer};

/// A rectangle of pixels; row 0 is at the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl PixelRect {
    /// Number of pixels.
    pub fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The rectangle with a border of `by` pixels, clipped to `limit`.
    pub fn grown(&self, by: u32, limit: &PixelRect) -> PixelRect {
        let x = self.x.saturating_sub(by).max(limit.x);
        let y = self.y.saturating_sub(by).max(limit.y);
        let right = (self.x + self.width + by).min(limit.x + limit.width);
        let bottom = (self.y + self.height + by).min(limit.y + limit.height);
        PixelRect { x, y, width: right - x, height: bottom - y }
    }
}

/// A developed picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear scene values, premultiplied: colour times coverage, and coverage, as in EXR and HDR files. NaN
    /// where no sample was finite.
    pub linear: Vec<[f32; 4]>,
    /// Display values with straight alpha, as in PNG and JPEG files. Each is round(255 ·
    /// encode(tonemap(2^exposure · linear / alpha))).
    pub display: Vec<[u8; 4]>,
    /// Whether any pixel has a coverage other than 1.
    pub has_alpha: bool,
    /// Pixels without samples and without a preview, because rendering was stopped. They are transparent black.
    pub missing: u64,
    /// The exposure of the display values in stops: that of the film, plus that of `auto_exposure`.
    pub exposure: f64,
}

impl Film {
    /// The picture from the samples so far.
    pub fn develop(&self, desc: &FilmDesc) -> Picture {
        let (width, height) = (self.crop.width, self.crop.height);
        let count = width as usize * height as usize;
        let mut picture = Picture {
            width,
            height,
            linear: Vec::with_capacity(count),
            display: Vec::with_capacity(count),
            has_alpha: false,
            missing: 0,
            exposure: desc.exposure,
        };
        for y in self.crop.y..self.crop.y + height {
            for x in self.crop.x..self.crop.x + width {
                let mean = match desc.antialias {
                    Antialias::Mean => self.mean_of_neighbours(x, y),
                    _ => self.pixel(x, y),
                };
                let linear = mean.unwrap_or_else(|| {
                    picture.missing += 1;
                    [0.0; 4]
                });
                picture.has_alpha |= linear[3] != 1.0;
                picture.linear.push(linear);
            }
        }
        if desc.auto_exposure {
            let mut luminances = Luminances::default();
            picture.linear.iter().for_each(|pixel| luminances.add(*pixel));
            picture.exposure += luminances.exposure();
        }
        let curve = Curve::new(desc.transfer, desc.tonemap, picture.exposure);
        picture.display.extend(picture.linear.iter().map(|pixel| curve.display(*pixel)));
        picture
    }

    fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let Some([r, g, b, alpha]) = self.sum(x, y).mean() else { return self.preview.as_ref()?.pixel(x, y) };
        let Some(splats) = self.splats() else { return Some([r, g, b, alpha]) };
        let [dr, dg, db] = splats.mean(x, y);
        Some([r + dr, g + dg, b + db, alpha])
    }

    /// The quick filter of document 002: the mean over the pixel and those of its eight neighbours that lie in the
    /// picture.
    fn mean_of_neighbours(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        self.pixel(x, y)?;
        let (mut sum, mut count) = ([0.0f64; 4], 0u32);
        for ny in y.saturating_sub(1).max(self.region.y)..=(y + 1).min(self.region.y + self.region.height - 1)
        {
            for nx in
                x.saturating_sub(1).max(self.region.x)..=(x + 1).min(self.region.x + self.region.width - 1)
            {
                if let Some(v) = self.pixel(nx, ny) {
                    for (s, v) in sum.iter_mut().zip(v) {
                        *s += f64::from(v);
                    }
                    count += 1;
                }
            }
        }
        Some(sum.map(|s| (s / f64::from(count)) as f32))
    }
}

/// Exposure, tone mapping and transfer curve, to 8 bits.
struct Curve {
    transfer: Transfer,
    tonemap: Tonemap,
    /// 2^exposure.
    factor: f32,
    /// For sRGB: entry i - 1 is the smallest linear value that becomes i, so no pixel needs a power.
    thresholds: Vec<f32>,
}

impl Curve {
    fn new(transfer: Transfer, tonemap: Tonemap, exposure: f64) -> Curve {
        let thresholds = match transfer {
            Transfer::None => Vec::new(),
            Transfer::Srgb => (1..=255u16).map(|i| threshold(transfer, i)).collect(),
        };
        Curve { transfer, tonemap, factor: factor(exposure), thresholds }
    }

    /// From premultiplied scene values to straight 8-bit display values; pixels with NaN are magenta.
    fn display(&self, [r, g, b, a]: [f32; 4]) -> [u8; 4] {
        if r.is_nan() || g.is_nan() || b.is_nan() {
            return [255, 0, 255, 255];
        }
        if a <= 0.0 {
            return [0; 4];
        }
        let straight = Spectrum::new(r, g, b).map(|v| if a == 1.0 { v } else { v / a });
        let shown = match self.tonemap {
            Tonemap::None if self.factor == 1.0 => straight,
            Tonemap::None => straight * self.factor,
            tonemap => tonemap.map(straight * self.factor),
        };
        let [r, g, b] = shown.to_array().map(|v| self.byte(v));
        [r, g, b, (a.min(1.0) * 255.0 + 0.5) as u8]
    }

    fn byte(&self, v: f32) -> u8 {
        match self.transfer {
            Transfer::None => quantise(self.transfer.encode(v)),
            Transfer::Srgb => self.thresholds.partition_point(|t| *t <= v) as u8,
        }
    }
}

fn quantise(encoded: f32) -> u8 {
    (f64::from(encoded) * 255.0 + 0.5) as u8
}

/// The smallest f32 that quantises to at least `i`, by bisection over the ordered bits of non-negative floats.
fn threshold(transfer: Transfer, i: u16) -> f32 {
    let (mut low, mut high) = (0u32, 1.0f32.to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        if u16::from(quantise(transfer.encode(f32::from_bits(middle)))) >= i {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    f32::from_bits(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_the_curve() {
        let curve = Curve::new(Transfer::Srgb, Tonemap::None, 0.0);
        for i in 0..=4000 {
            let v = i as f32 / 3900.0;
            assert_eq!(curve.byte(v), quantise(Transfer::Srgb.encode(v)), "{v}");
        }
        assert_eq!(curve.byte(-1.0), 0);
    }

    #[test]
    fn display_values_are_straight() {
        let curve = Curve::new(Transfer::None, Tonemap::None, 0.0);
        assert_eq!(curve.display([0.25, 0.5, 0.0, 0.5]), [128, 255, 0, 128]);
        assert_eq!(curve.display([0.2, 2.0, -1.0, 1.0]), [51, 255, 0, 255]);
        assert_eq!(curve.display([f32::NAN, 0.0, 0.0, 1.0]), [255, 0, 255, 255]);
    }

    #[test]
    fn exposure_is_in_stops_and_comes_before_the_curves() {
        let plain = Curve::new(Transfer::Srgb, Tonemap::None, 0.0);
        for stops in [-3.0, -1.0, 1.0, 5.0] {
            let exposed = Curve::new(Transfer::Srgb, Tonemap::None, stops);
            for i in 0..500 {
                let v = i as f32 / 400.0;
                let by_hand = if stops < 0.0 {
                    v / (1 << -stops as i32) as f32
                } else {
                    v * (1 << stops as i32) as f32
                };
                assert_eq!(exposed.display([v, v, v, 1.0]), plain.display([by_hand, by_hand, by_hand, 1.0]));
            }
        }
        let mapped = Curve::new(Transfer::None, Tonemap::Neutral, 2.0);
        // 0.15 · 4 − 0.04.
        assert_eq!(mapped.display([0.15, 0.15, 0.15, 1.0]), [143, 143, 143, 255]);
    }

    #[test]
    fn tone_mapping_sees_colours_without_their_alpha() {
        for tonemap in [Tonemap::Neutral, Tonemap::Agx, Tonemap::Aces] {
            let curve = Curve::new(Transfer::Srgb, tonemap, 0.5);
            for v in [0.02, 0.3, 0.9, 7.0f32] {
                let [r, g, b, _] = curve.display([v, v / 2.0, v / 4.0, 1.0]);
                let half = curve.display([v / 2.0, v / 4.0, v / 8.0, 0.5]);
                assert_eq!(half, [r, g, b, 128], "{tonemap:?} {v}");
            }
            assert_eq!(curve.display([f32::INFINITY, 0.0, 0.0, 1.0])[0], 255);
            assert_eq!(curve.display([f32::NAN, 0.0, 0.0, 1.0]), [255, 0, 255, 255]);
            assert_eq!(curve.display([3.0, 3.0, 3.0, 0.0]), [0; 4]);
        }
    }
}
