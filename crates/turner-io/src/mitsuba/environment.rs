//! Light from all around. Mitsuba puts the middles of a picture's first and last row on the poles; here a row's middle lies where its pixels' middles
//! are. Pictures are looked up again, in the world's directions.

use super::assembly::Assembly;
use crate::whole::{Place, Stock};
use std::f64::consts::{PI, TAU};
use turner::color::srgb_decode;
use turner::image::{Image, Pixels};
use turner::math::elementary::{acos, atan2, sin_cos, sin_cos_turns};
use turner::math::{DMat3, DVec3};
use turner::scene::ImageId;

/// Looks per pixel along either side.
const LOOKS: u32 = 2;
/// The most rows of a picture that is made.
const MAX_ROWS: u32 = 8192;

/// The same light from everywhere: a picture of white.
pub(super) fn constant(stock: &mut Stock<'_>) -> ImageId {
    let image = Image { width: 2, height: 1, channels: 3, pixels: Pixels::F32(vec![1.0; 6]) };
    stock.add_image("", image)
}

/// The picture `name` seen through a transform to the world.
pub(super) fn picture(
    scene: &mut Assembly<'_>,
    name: &str,
    to_world: DMat3,
    place: Place,
) -> Option<ImageId> {
    let id = scene.image(name, place)?;
    let source = scene.images.get(id.index())?.data.clone();
    let finer = scene.finer(source.height);
    let columns = source.width.saturating_mul(finer).clamp(2, 2 * MAX_ROWS);
    let rows = source.height.saturating_mul(finer).clamp(2, MAX_ROWS);
    let to_light = to_world.inverse();
    let count = (rows as usize) * (columns as usize) * 3;
    let mut pixels: Vec<f32> = Vec::new();
    if !to_light.is_finite() || pixels.try_reserve_exact(count).is_err() {
        let message = "a picture of the surroundings whose transform cannot be undone, or too large";
        scene.report.ignored(place, message);
        return None;
    }
    let look = Look { image: &source, is_encoded: source.is_display_encoded() };
    for y in 0..rows {
        for x in 0..columns {
            let mut color = [0.0; 3];
            for i in 0..LOOKS * LOOKS {
                let (i, j) = (i % LOOKS, i / LOOKS);
                let u = (f64::from(x) + (f64::from(i) + 0.5) / f64::from(LOOKS)) / f64::from(columns);
                let v = (f64::from(y) + (f64::from(j) + 0.5) / f64::from(LOOKS)) / f64::from(rows);
                let own = (to_light * direction(u, v)).normalize_or(DVec3::Y);
                color.iter_mut().zip(look.towards(own)).for_each(|(c, f)| *c += f);
            }
            pixels.extend(color.map(|c| (c / f64::from(LOOKS * LOOKS)) as f32));
        }
    }
    let image = Image { width: columns, height: rows, channels: 3, pixels: Pixels::F32(pixels) };
    Some(scene.add_image(name, image))
}

/// The direction in the world of a place in an equirectangular picture, as environments here have it.
fn direction(u: f64, v: f64) -> DVec3 {
    let (sin_theta, cos_theta) = sin_cos(PI * v);
    let (sin_phi, cos_phi) = sin_cos_turns(u - 0.5);
    DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
}

/// A picture of the surroundings as Mitsuba looks at it.
struct Look<'a> {
    image: &'a Image,
    is_encoded: bool,
}

impl Look<'_> {
    /// The light from a unit direction.
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

    #[test]
    fn directions_are_mitsubas() {
        // What Mitsuba 3.9.1 answers for a picture whose pixels are their own columns and rows.
        let pixels = (0..4).flat_map(|y| (0..8).flat_map(move |x| [x as f32, y as f32, 1.0])).collect();
        let image = Image { width: 8, height: 4, channels: 3, pixels: Pixels::F32(pixels) };
        let look = Look { image: &image, is_encoded: false };
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
