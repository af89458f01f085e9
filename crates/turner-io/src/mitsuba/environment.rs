//! Environment maps. Mitsuba puts the pixel centres of the first and the last row at the poles (`poles = "centers"`) and
//! begins half a turn on. Only a map that is mirrored or sheared is resampled.

use std::f64::consts::{PI, TAU};

use turner::color::srgb_decode;
use turner::image::Image;
use turner::light::{EnvironmentDesc, MapPoles};
use turner::math::elementary::{acos, atan2};
use turner::math::{DMat3, DVec3};

use super::assembly::Assembly;
use crate::scene_import::{Place, environment_light};

/// The image `name` under the light's transform as an environment light.
pub(super) fn light(
    scene: &mut Assembly<'_>,
    name: &str,
    to_world: DMat3,
    place: Place,
) -> Option<EnvironmentDesc> {
    let id = scene.image(name, place)?;
    let own = EnvironmentDesc { file: Some(id), poles: MapPoles::Centers, ..EnvironmentDesc::default() };
    if let Some(turned) = own.turned_by(to_world * DMat3::from_rotation_y(PI)) {
        return Some(turned);
    }
    let message = "an environment map that is mirrored or sheared: its image is resampled";
    scene.stock.report.approximated(place, message);
    let source = scene.images.get(id.index())?.data.clone();
    let look = EncodedView { image: &source, is_encoded: source.is_display_encoded() };
    let size = [source.width, source.height];
    let image =
        environment_light::equirectangular(&mut scene.stock, size, to_world, place, |d| look.towards(d))?;
    let file = Some(scene.add_image(name, image));
    Some(EnvironmentDesc { file, ..EnvironmentDesc::default() })
}

/// An environment map with Mitsuba's lookup.
struct EncodedView<'a> {
    image: &'a Image,
    is_encoded: bool,
}

impl EncodedView<'_> {
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
    use std::sync::Arc;
    use turner::image::Pixels;
    use turner::schema::{Asset, ImageId};

    #[test]
    fn directions_are_mitsubas() {
        // Results of Mitsuba 3.9.1 for an image whose pixels hold their own column and row.
        let pixels = (0..4).flat_map(|y| (0..8).flat_map(move |x| [x as f32, y as f32, 1.0])).collect();
        let image = Image { width: 8, height: 4, channels: 3, pixels: Pixels::F32(pixels) };
        let look = EncodedView { image: &image, is_encoded: false };
        let images = [Asset { uri: String::new(), data: Arc::new(image.clone()) }];
        let own = EnvironmentDesc {
            file: Some(ImageId(0)),
            poles: MapPoles::Centers,
            ..EnvironmentDesc::default()
        };
        let own = own.turned_by(DMat3::from_rotation_y(PI)).unwrap().prepare(&images, false).unwrap();
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
            let found = own.radiance(d);
            assert!((f64::from(found.r) - x).abs() + (f64::from(found.g) - y).abs() < 1e-4, "{d}: {found:?}");
        }
    }
}
