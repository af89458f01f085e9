//! Environment map: the relation between directions and pixels, and filtered look-up.
//!
//! ```text
//!   (0,0)  u →                 zenith, +y
//!     +----------+----------+
//!   v |   -x     |    +x    |       u = 0.5 + φ / 2π,  φ from −z towards +x
//!   ↓ +----+-----o-----+----+       v = θ / π,         θ from the zenith
//!     |          |          |       o = −z, the left and right edges = +z
//!     +----------+----------+
//!                              nadir, −y
//! ```

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;
use std::sync::Arc;

use super::MapPoles;
use crate::color::{Spectrum, srgb_decode};
use crate::image::{Image, Pixels};
#[cfg(test)]
use crate::math::elementary::sin_cos;
use crate::math::elementary::{angle, atan2, cos, sin_cos_turns};
use crate::math::{DVec2, DVec3};

/// The direction at (u, v) of an equirectangular image with (0, 0) at its upper left corner: a unit vector.
#[cfg(test)]
pub(super) fn direction(uv: DVec2) -> DVec3 {
    let (sin_theta, cos_theta) = sin_cos(PI * uv.y);
    direction_at(uv.x, sin_theta, cos_theta)
}

/// The direction at column u, from the sine and cosine of its angle from the zenith.
pub(super) fn direction_at(u: f64, sin_theta: f64, cos_theta: f64) -> DVec3 {
    let (sin_phi, cos_phi) = sin_cos_turns(u - 0.5);
    DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
}

/// (u, v) in 0..=1 of a direction of any length. Straight up and down u is 0.5.
pub(super) fn coordinates(d: DVec3) -> DVec2 {
    let flat = (d.x * d.x + d.z * d.z).sqrt();
    let phi = if flat > 0.0 { atan2(d.x, -d.z) } else { 0.0 };
    DVec2::new(0.5 + phi / TAU, atan2(flat, d.y) / PI)
}

/// The same to within 1e-15, faster.
#[inline]
pub(super) fn coordinates_fast(d: DVec3) -> DVec2 {
    let flat = (d.x * d.x + d.z * d.z).sqrt();
    let phi = if flat > 0.0 { angle(d.x, -d.z) } else { 0.0 };
    DVec2::new(0.5 + phi * (1.0 / TAU), height(flat, d.y))
}

/// v from the sine and cosine of the angle from the zenith, both times any length.
#[inline]
pub(super) fn height(sin_theta: f64, cos_theta: f64) -> f64 {
    angle(sin_theta, cos_theta) * (1.0 / PI)
}

/// The solid angle of a pixel in each row of an image whose rows are equal steps in the angle from the zenith.
pub(super) fn solid_angles(width: u32, height: u32) -> impl Iterator<Item = f64> {
    let edge = move |y: u32| cos(PI * f64::from(y) / f64::from(height));
    (0..height).map(move |y| TAU / f64::from(width) * (edge(y) - edge(y + 1)))
}

/// The four texels of a bilinear look-up: indices of their first samples, and the weights of the second column and
/// row.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Taps {
    texels: [usize; 4],
    fx: f32,
    fy: f32,
}

/// An image whose samples are radiances.
#[derive(Debug)]
pub(super) struct EnvironmentMap {
    image: Arc<Image>,
    /// Radiance for each value of an integer sample; empty for floats.
    decoded: Box<[f32]>,
    invalid: u64,
    poles: MapPoles,
    uniform: Option<Spectrum>,
}

/// Whether all pixels are the same.
fn is_uniform(image: &Image) -> bool {
    fn all_same<T: PartialEq>(samples: &[T], channels: usize) -> bool {
        samples.len() <= channels || samples[channels..] == samples[..samples.len() - channels]
    }
    let channels = usize::from(image.channels);
    match &image.pixels {
        Pixels::U8(samples) => all_same(samples, channels),
        Pixels::U16(samples) => all_same(samples, channels),
        Pixels::F32(samples) => all_same(samples, channels),
    }
}

impl EnvironmentMap {
    /// From a consistent image.
    pub(super) fn new(image: Arc<Image>, poles: MapPoles) -> EnvironmentMap {
        let table = |most: u16| (0..=most).map(|v| srgb_decode(f32::from(v) / f32::from(most))).collect();
        let (decoded, invalid) = match &image.pixels {
            Pixels::U8(_) => (table(255), 0),
            Pixels::U16(_) => (table(u16::MAX), 0),
            Pixels::F32(samples) => {
                let n = usize::from(image.channels);
                let colors = if n < 3 { 1 } else { 3 };
                let bad = |pixel: &&[f32]| pixel[..colors].iter().any(|v| !is_light(*v));
                (Box::default(), samples.chunks_exact(n).filter(bad).count() as u64)
            }
        };
        let mut map = EnvironmentMap { image, decoded, invalid, poles, uniform: None };
        let is_uniform = invalid == 0 && map.image.width > 0 && is_uniform(&map.image);
        map.uniform = is_uniform.then(|| map.pixel(0, 0));
        map
    }

    /// Whether it is made from this image.
    pub(super) fn is_of(&self, image: &Arc<Image>, poles: MapPoles) -> bool {
        Arc::ptr_eq(&self.image, image) && self.poles == poles
    }

    /// The radiance of all pixels, if they are the same.
    #[inline]
    pub(super) fn uniform(&self) -> Option<Spectrum> {
        self.uniform
    }

    /// The luminance of the image, resampled where it has more or fewer rows than this range, or columns than twice as many.
    pub(super) fn scaled_to(&self, rows: RangeInclusive<u32>) -> EnvironmentMap {
        let (width, height) = self.size();
        let (least, most) = (*rows.start(), *rows.end());
        if width < 2 * least || height < least {
            return self.enlarged(width.clamp(2 * least, 2 * most), height.clamp(least, most));
        }
        self.reduced(most)
    }

    /// The luminance of the image, resampled to this number of columns and rows.
    fn enlarged(&self, columns: u32, rows: u32) -> EnvironmentMap {
        let centre = |i: u32, of: u32| (f64::from(i) + 0.5) / f64::from(of);
        let row = |y: u32| (0..columns).map(move |x| DVec2::new(centre(x, columns), centre(y, rows)));
        let values = (0..rows).flat_map(row).map(|uv| self.at(uv).luminance().min(f32::MAX)).collect();
        let image = Image { width: columns, height: rows, channels: 1, pixels: Pixels::F32(values) };
        EnvironmentMap::new(Arc::new(image), self.poles)
    }

    /// The luminance of the image, scaled down to at most so many rows, and twice as many columns.
    fn reduced(&self, rows: u32) -> EnvironmentMap {
        let (width, height) = self.size();
        let (columns, rows) = (width.min(2 * rows), height.min(rows));
        let part = |i: u32, parts: u32, of: u32| (u64::from(i) * u64::from(parts) / u64::from(of)) as usize;
        let of_column: Vec<usize> = (0..width).map(|x| part(x, columns, width)).collect();
        let mut sums = vec![[0.0_f32; 2]; columns as usize * rows as usize];
        for y in 0..height {
            let row = &mut sums[part(y, rows, height) * columns as usize..][..columns as usize];
            let mut add = |column: usize, color: Spectrum| {
                let [sum, count] = &mut row[column];
                (*sum, *count) = (*sum + color.luminance(), *count + 1.0);
            };
            let channels = usize::from(self.image.channels);
            match &self.image.pixels {
                // The same as below, without a choice per pixel.
                Pixels::F32(v) if channels >= 3 => {
                    let pixels = v[y as usize * width as usize * channels..].chunks_exact(channels);
                    for (column, pixel) in of_column.iter().zip(pixels) {
                        let [r, g, b] =
                            [pixel[0], pixel[1], pixel[2]].map(|v| if is_light(v) { v } else { 0.0 });
                        add(*column, Spectrum::new(r, g, b));
                    }
                }
                _ => (0..width).zip(&of_column).for_each(|(x, column)| add(*column, self.pixel(x, y))),
            }
        }
        let means = sums.into_iter().map(|[sum, count]| (sum / count).min(f32::MAX)).collect();
        let pixels = Pixels::F32(means);
        let image = Image { width: columns, height: rows, channels: 1, pixels };
        EnvironmentMap::new(Arc::new(image), self.poles)
    }

    /// Width and height.
    pub(super) fn size(&self) -> (u32, u32) {
        (self.image.width, self.image.height)
    }

    /// Pixels with a negative or non-finite sample.
    pub(super) fn invalid_pixels(&self) -> u64 {
        self.invalid
    }

    pub(super) fn memory(&self) -> usize {
        self.image.memory() + size_of_val(&*self.decoded)
    }

    /// Pixel (x, y), which must lie inside the image.
    #[inline]
    pub(super) fn pixel(&self, x: u32, y: u32) -> Spectrum {
        let n = usize::from(self.image.channels);
        let i = (y as usize * self.image.width as usize + x as usize) * n;
        let (g, b) = if n < 3 { (i, i) } else { (i + 1, i + 2) };
        let bands = match &self.image.pixels {
            Pixels::U8(v) => [v[i], v[g], v[b]].map(|v| self.decoded[usize::from(v)]),
            Pixels::U16(v) => [v[i], v[g], v[b]].map(|v| self.decoded[usize::from(v)]),
            Pixels::F32(v) => [v[i], v[g], v[b]].map(|v| if is_light(v) { v } else { 0.0 }),
        };
        Spectrum::from(bands)
    }

    /// Radiance from a direction: bilinear between pixel centres ([`MapPoles`]), wrapped at the left and right edges, clamped at the
    /// upper and lower ones.
    pub(super) fn radiance(&self, d: DVec3) -> Spectrum {
        self.at(coordinates(d))
    }

    /// Radiance at (u, v), each in 0..=1.
    #[inline]
    pub(super) fn at(&self, uv: DVec2) -> Spectrum {
        self.blend(&self.taps(uv))
    }

    /// The texels for (u, v), each in 0..=1.
    #[inline]
    pub(super) fn taps(&self, uv: DVec2) -> Taps {
        let (w, h) = self.size();
        // Offset by one pixel, so that truncation is floor: 0 stands for column and row −1.
        let x = uv.x * f64::from(w) - 0.5;
        let y = match self.poles {
            MapPoles::Edges => uv.y * f64::from(h) - 0.5,
            MapPoles::Centers => uv.y * f64::from(h - 1),
        };
        let (x1, y1) = ((x + 1.0) as u32, (y + 1.0) as u32);
        // Rounding may have carried a coordinate over the edge.
        let weight = |v: f64, above: u32| (v - (f64::from(above) - 1.0)).max(0.0) as f32;
        let (fx, fy) = (weight(x, x1), weight(y, y1));
        // The columns before and after lie at most one outside the image.
        let before = if x1 == 0 { w - 1 } else { (x1 - 1).min(w - 1) };
        let after = if x1 >= w { 0 } else { x1 };
        let (above, below) = (y1.saturating_sub(1).min(h - 1), y1.min(h - 1));
        let n = usize::from(self.image.channels);
        let texel = |x: u32, y: u32| (y as usize * w as usize + x as usize) * n;
        let texels = [texel(before, above), texel(after, above), texel(before, below), texel(after, below)];
        Taps { texels, fx, fy }
    }

    /// Prefetches the texels for [`EnvironmentMap::blend`]; the sum only keeps the reads alive.
    #[inline]
    pub(super) fn prefetch(&self, taps: &[Taps]) -> f32 {
        let Pixels::F32(v) = &self.image.pixels else { return 0.0 };
        let mut sum = 0.0;
        for taps in taps {
            for i in taps.texels {
                sum += v.get(i).copied().unwrap_or_default();
            }
        }
        sum
    }

    /// The radiance from the texels.
    #[inline]
    pub(super) fn blend(&self, &Taps { texels, fx, fy }: &Taps) -> Spectrum {
        if let Some(radiance) = self.uniform {
            return radiance;
        }
        let n = usize::from(self.image.channels);
        let blend =
            |pixels: [Spectrum; 4]| pixels[0].lerp(pixels[1], fx).lerp(pixels[2].lerp(pixels[3], fx), fy);
        let bands = |i: usize| if n < 3 { [i, i, i] } else { [i, i + 1, i + 2] };
        match &self.image.pixels {
            Pixels::F32(v) if self.invalid == 0 => {
                blend(texels.map(|i| Spectrum::from(bands(i).map(|i| v[i]))))
            }
            Pixels::F32(v) => {
                let light = |v: f32| if is_light(v) { v } else { 0.0 };
                blend(texels.map(|i| Spectrum::from(bands(i).map(|i| light(v[i])))))
            }
            Pixels::U8(v) => {
                blend(texels.map(|i| Spectrum::from(bands(i).map(|i| self.decoded[usize::from(v[i])]))))
            }
            Pixels::U16(v) => {
                blend(texels.map(|i| Spectrum::from(bands(i).map(|i| self.decoded[usize::from(v[i])]))))
            }
        }
    }

    /// The radiance integrated over all directions, pixel by pixel.
    pub(super) fn integral(&self) -> [f64; 3] {
        let (w, h) = self.size();
        let mut total = [0.0; 3];
        for (y, solid_angle) in (0..h).zip(solid_angles(w, h)) {
            let mut row = [0.0; 3];
            for x in 0..w {
                for (sum, v) in row.iter_mut().zip(self.pixel(x, y).to_array()) {
                    *sum += f64::from(v);
                }
            }
            for (total, row) in total.iter_mut().zip(row) {
                *total += row * solid_angle;
            }
        }
        total
    }
}

fn is_light(v: f32) -> bool {
    v >= 0.0 && v.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(image: Image) -> EnvironmentMap {
        EnvironmentMap::new(Arc::new(image), MapPoles::Edges)
    }

    #[test]
    fn directions_and_pixels_correspond() {
        let cases = [
            (DVec2::new(0.5, 0.5), DVec3::NEG_Z),
            (DVec2::new(0.75, 0.5), DVec3::X),
            (DVec2::new(0.25, 0.5), DVec3::NEG_X),
            (DVec2::new(0.0, 0.5), DVec3::Z),
            (DVec2::new(0.3, 0.0), DVec3::Y),
            (DVec2::new(0.7, 1.0), DVec3::NEG_Y),
        ];
        for (uv, d) in cases {
            assert!((direction(uv) - d).length() < 1e-15, "{uv} {}", direction(uv));
        }
        for (u, v) in (1..20).flat_map(|u| (1..20).map(move |v| (f64::from(u) / 20.0, f64::from(v) / 20.0))) {
            let back = coordinates(direction(DVec2::new(u, v)) * 7.5);
            assert!((back - DVec2::new(u, v)).length() < 1e-14, "{u} {v} {back}");
        }
    }

    #[test]
    fn the_pixels_cover_the_sphere() {
        for (w, h) in [(1, 1), (8, 3), (200, 101)] {
            let total: f64 = solid_angles(w, h).map(|a| a * f64::from(w)).sum();
            assert!((total - 2.0 * TAU).abs() < 1e-12);
        }
    }

    #[test]
    fn lookups_at_pixel_centres_give_the_pixels() {
        for (w, h) in [(1, 1), (2, 1), (5, 4), (16, 8)] {
            let samples = (0..w * h * 3).map(|i| i as f32).collect();
            let map = plain(Image { width: w, height: h, channels: 3, pixels: Pixels::F32(samples) });
            for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
                let uv = DVec2::new((f64::from(x) + 0.5) / f64::from(w), (f64::from(y) + 0.5) / f64::from(h));
                let (found, expected) = (map.radiance(direction(uv)), map.pixel(x, y));
                assert!((found - expected).map(f32::abs).max_component() < 1e-4, "{x} {y}: {found:?}");
                assert_eq!(expected.r, ((y * w + x) * 3) as f32);
            }
        }
    }

    #[test]
    fn lookups_are_bilinear_wrapped_at_the_seam_and_clamped_at_the_poles() {
        let map = plain(Image {
            width: 4,
            height: 2,
            channels: 1,
            pixels: Pixels::F32(vec![0.0, 1.0, 2.0, 10.0, 100.0, 100.0, 100.0, 100.0]),
        });
        let at = |u, v| map.radiance(direction(DVec2::new(u, v))).g;
        assert!((at(0.25, 0.25) - 0.5).abs() < 1e-6);
        assert!((at(0.5, 0.5) - 50.75).abs() < 1e-4);
        // The seam is +z: half of the first and half of the last column, from either side.
        for u in [0.0, 1.0, 1e-12, 1.0 - 1e-12] {
            assert!((at(u, 0.25) - 5.0).abs() < 1e-5, "{u}");
        }
        assert_eq!(at(0.375, 0.0), map.radiance(DVec3::Y).g);
        assert_eq!(map.radiance(DVec3::NEG_Y).g, 100.0);
    }

    #[test]
    fn integers_are_srgb_and_invalid_floats_are_black_and_counted() {
        let map = |channels, pixels| plain(Image { width: 2, height: 1, channels, pixels });
        let eight = map(3, Pixels::U8(vec![255, 128, 0, 1, 2, 3]));
        assert_eq!(eight.pixel(0, 0), Spectrum::new(1.0, srgb_decode(128.0 / 255.0), 0.0));
        let sixteen = map(2, Pixels::U16(vec![32768, 0, 65535, 7]));
        assert_eq!(sixteen.pixel(0, 0), Spectrum::grey(srgb_decode(32768.0 / 65535.0)));
        assert_eq!(sixteen.pixel(1, 0), Spectrum::WHITE);
        let floats = map(4, Pixels::F32(vec![f32::NAN, -1.0, f32::INFINITY, 1.0, 1.0, 2.0, 3.0, f32::NAN]));
        assert_eq!((floats.pixel(0, 0), floats.pixel(1, 0)), (Spectrum::BLACK, Spectrum::new(1.0, 2.0, 3.0)));
        assert_eq!((floats.invalid_pixels(), eight.invalid_pixels()), (1, 0));
    }

    #[test]
    fn the_centres_of_the_outer_rows_may_be_the_poles() {
        let samples = (0..8 * 5).map(|i| (i / 8 * 10 + i % 8) as f32).collect();
        let image = Image { width: 8, height: 5, channels: 1, pixels: Pixels::F32(samples) };
        let map = EnvironmentMap::new(Arc::new(image), MapPoles::Centers);
        for (x, y) in (0..8).flat_map(|x| (0..5).map(move |y| (x, y))) {
            let uv = DVec2::new((f64::from(x) + 0.5) / 8.0, f64::from(y) / 4.0);
            assert!((map.at(uv).g - map.pixel(x, y).g).abs() < 1e-4, "{x} {y}");
        }
        // Three quarters of row 0 and a quarter of row 1.
        assert!((map.at(DVec2::new(0.5 / 8.0, 0.25 / 4.0)).g - 2.5).abs() < 1e-4);
    }
}
