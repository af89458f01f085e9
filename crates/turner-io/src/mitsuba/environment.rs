//! Environment maps in Turner's projection. Mitsuba puts the pixel centres of the first and the last row at the poles; in
//! Turner the outer edges of these rows are at the poles. A map that is not tilted keeps its columns; others are resampled.

use std::f64::consts::{PI, TAU};

use turner::color::srgb_decode;
use turner::image::{Image, Pixels};
use turner::math::elementary::{acos, atan2};
use turner::math::{DMat3, DVec3};
use turner::schema::ImageId;

use super::assembly::Assembly;
use crate::scene_import::{Place, environment_light};

/// Maps of up to this many rows get twice as many, so that they stay as sharp.
const DOUBLED_ROWS: u32 = 2048;

/// The image `name` under the light's transform as an equirectangular map, and its rotation in degrees.
pub(super) fn picture(
    scene: &mut Assembly<'_>,
    name: &str,
    to_world: DMat3,
    place: Place,
) -> Option<(ImageId, f64)> {
    let id = scene.image(name, place)?;
    let source = scene.images.get(id.index())?.data.clone();
    let look = EncodedView { image: &source, is_encoded: source.is_display_encoded() };
    if let Some(rotation) = rotation_about_y(to_world)
        && let Some(image) = look.with_own_columns()
    {
        return Some((scene.add_image(name, image), rotation));
    }
    let size = [source.width, source.height];
    let image =
        environment_light::equirectangular(&mut scene.stock, size, to_world, place, |d| look.towards(d))?;
    Some((scene.add_image(name, image), 0.0))
}

/// The angle in degrees, if this is a rotation about +y, perhaps scaled.
fn rotation_about_y(m: DMat3) -> Option<f64> {
    let scale = m.y_axis.length();
    let near = |a: DVec3, b: DVec3| (a - scale * b).length() <= 1e-6 * scale;
    let (sin, cos) = (m.z_axis.x / scale, m.z_axis.z / scale);
    let is_rotation = scale > 0.0
        && near(m.y_axis, DVec3::Y)
        && near(m.x_axis, DVec3::new(cos, 0.0, -sin))
        && near(m.z_axis, DVec3::new(sin, 0.0, cos))
        && (sin * sin + cos * cos - 1.0).abs() < 1e-6;
    is_rotation.then(|| atan2(sin, cos).to_degrees())
}

/// An environment map with Mitsuba's lookup.
struct EncodedView<'a> {
    image: &'a Image,
    is_encoded: bool,
}

impl EncodedView<'_> {
    /// The map with the same columns, half a turn on, and rows as Turner places them; `None` if the number of columns is
    /// odd or memory is short.
    fn with_own_columns(&self) -> Option<Image> {
        let (width, height) = (self.image.width, self.image.height);
        let rows = if height <= DOUBLED_ROWS { 2 * height } else { height };
        let count = (width as usize).checked_mul(rows as usize)?.checked_mul(3)?;
        let mut pixels: Vec<f32> = Vec::new();
        if !width.is_multiple_of(2) || pixels.try_reserve_exact(count).is_err() {
            return None;
        }
        for row in 0..rows {
            let y = (f64::from(row) + 0.5) / f64::from(rows) * (f64::from(height) - 1.0);
            let (above, f) = (y.floor() as i64, y - y.floor());
            for column in 0..i64::from(width) {
                let x = column + i64::from(width / 2);
                let (a, b) = (self.pixel(x, above), self.pixel(x, above + 1));
                pixels.extend(a.iter().zip(b).map(|(a, b)| (a * (1.0 - f) + b * f) as f32));
            }
        }
        Some(Image { width, height: rows, channels: 3, pixels: Pixels::F32(pixels) })
    }

    /// Radiance from a unit direction.
    fn towards(&self, d: DVec3) -> [f64; 3] {
        let u = atan2(d.x, -d.z) / TAU;
        let v = acos(d.y.clamp(-1.0, 1.0)) / PI;
        let (w, h) = (f64::from(self.image.width), f64::from(self.image.height));
        let (x, y) = (u * w - 0.5, v * (h - 1.0));
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let mut sum = [0.0; 3];
        for (dx, dy, weight) in [
            (0, 0, (1.0 - fx) * (1.0 - fy)),
            (1, 0, fx * (1.0 - fy)),
            (0, 1, (1.0 - fx) * fy),
            (1, 1, fx * fy),
        ] {
            sum.iter_mut().zip(self.pixel(x + dx, y + dy)).for_each(|(s, c)| *s += weight * c);
        }
        sum
    }

    fn pixel(&self, x: i64, y: i64) -> [f64; 3] {
        let (w, h) = (i64::from(self.image.width), i64::from(self.image.height));
        let c = self.image.rgb(x.rem_euclid(w) as u32, y.clamp(0, h - 1) as u32);
        c.map(|v| {
            let v = if self.is_encoded { srgb_decode(v) } else { v };
            if v.is_finite() { f64::from(v.max(0.0)) } else { 0.0 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use turner::image::Pixels;

    #[test]
    fn rotations_about_the_vertical_axis_are_found() {
        for degrees in [0.0, 30.0, 90.0, -120.0, 180.0] {
            let m = DMat3::from_rotation_y(turner::math::radians(degrees)) * 2.5;
            let found = rotation_about_y(m).unwrap();
            assert!((found - degrees).abs() < 1e-9 || (found + degrees).abs() < 1e-9 && degrees == 180.0);
        }
        let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        for other in [DMat3::from_rotation_x(0.1), mirrored, DMat3::ZERO, DMat3::from_rotation_z(3.0)] {
            assert_eq!(rotation_about_y(other), None);
        }
    }

    #[test]
    fn a_map_with_its_own_columns_has_the_same_light() {
        let pixels = (0..6 * 12 * 3).map(|i| (i * i % 31) as f32).collect();
        let image = Image { width: 12, height: 6, channels: 3, pixels: Pixels::F32(pixels) };
        let look = EncodedView { image: &image, is_encoded: false };
        let own = look.with_own_columns().unwrap();
        assert_eq!((own.width, own.height), (12, 12));
        for y in 0..12 {
            for x in 0..12 {
                let (u, v) = ((f64::from(x) + 0.5) / 12.0, (f64::from(y) + 0.5) / 12.0);
                let found = look.towards(environment_light::direction(u, v));
                for (a, b) in found.iter().zip(own.rgb(x, y)) {
                    assert!((a - f64::from(b)).abs() < 1e-4, "{x}, {y}: {a} and {b}");
                }
            }
        }
    }

    #[test]
    fn directions_are_mitsubas() {
        // Results of Mitsuba 3.9.1 for an image whose pixels hold their own column and row.
        let pixels = (0..4).flat_map(|y| (0..8).flat_map(move |x| [x as f32, y as f32, 1.0])).collect();
        let image = Image { width: 8, height: 4, channels: 3, pixels: Pixels::F32(pixels) };
        let look = EncodedView { image: &image, is_encoded: false };
        for (d, x, y) in [
            (DVec3::NEG_Z, 3.5, 1.5),
            (DVec3::Z, 3.5, 1.5),
            (DVec3::X, 1.5, 1.5),
            (DVec3::NEG_X, 5.5, 1.5),
            (DVec3::new(0.2, 0.3, -1.0), 1.74068, 1.22679),
            (DVec3::new(1.0, 0.0, -1.0), 0.5, 1.5),
            (DVec3::new(0.0, 1.0, -1.0), 3.5, 0.75),
        ] {
            let found = look.towards(d.normalize());
            assert!((found[0] - x).abs() + (found[1] - y).abs() < 1e-4, "{d}: {found:?}");
        }
    }
}
