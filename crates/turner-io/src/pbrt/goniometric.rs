//! Goniometric lights: a point light whose intensity in each direction is in an image, in the equal-area octahedral mapping
//! (see [`environment`](super::environment)). It becomes an IES profile, a table of intensities by angles.

use std::sync::Arc;

use turner::math::elementary::sin_cos;
use turner::math::{DAffine3, DVec3, radians};
use turner::schema::{LightProfile, ProfileFile};

use super::assembly::Assembly;
use super::environment::{EncodedView, lat_long_of, square_of};
use super::source::Place;

/// Fewest and most rows of the table.
const ROWS: std::ops::RangeInclusive<u32> = 90..=360;

/// The intensities of an image, and their mean over all directions.
pub(super) struct Intensities {
    pub(super) profile: ProfileFile,
    pub(super) mean: f64,
}

/// The axis of the profile, from which vertical angles are counted; the horizontal angle 0 is +x.
pub(super) const AXIS: DVec3 = DVec3::NEG_Y;

/// The image `name` as a profile in world space; `None`, which is reported, if it cannot be used.
pub(super) fn intensities(
    scene: &mut Assembly<'_>,
    name: &str,
    to_world: &DAffine3,
    place: Place,
) -> Option<Intensities> {
    let id = scene.image(name, place)?;
    let image = scene.images.get(id.index())?.data.clone();
    let to_light = to_world.matrix3.inverse();
    // Those of pbrt-v3 are latitude-longitude maps.
    let is_version3 = scene.frame.is_version3;
    if image.width != image.height && !is_version3 || !to_light.is_finite() {
        let message = "a goniometric light whose image is not square: rendered as a point light";
        scene.report.approximated(place, message);
        return None;
    }
    let rows = image.height.saturating_mul(2).clamp(*ROWS.start(), *ROWS.end());
    let columns = 2 * rows;
    if !scene.may_copy(4 * u64::from(rows + 1) * u64::from(columns + 1)) {
        let message = "the images of many goniometric lights take too much memory: rendered as a point light";
        scene.report.approximated(place, message);
        return None;
    }
    let look = EncodedView::new(&image);
    let grey = |[r, g, b]: [f64; 3]| (r + g + b) / 3.0;
    let angle = |i: u32, n: u32, full: f64| full * f64::from(i) / f64::from(n);
    let mut values = Vec::new();
    for column in 0..=columns {
        // The last column is the first one.
        let (sin_h, cos_h) = sin_cos(radians(angle(column % columns, columns, 360.0)));
        for row in 0..=rows {
            let (sin_v, cos_v) = sin_cos(radians(angle(row, rows, 180.0)));
            let own = to_light * DVec3::new(sin_v * cos_h, -cos_v, -sin_v * sin_h);
            // pbrt swaps y and z of the light's space.
            let own = DVec3::new(own.x, own.z, own.y).normalize_or(DVec3::Z);
            let uv = if is_version3 { lat_long_of(own) } else { square_of(own) };
            values.push(grey(look.at(uv)) as f32);
        }
    }
    // All pixels cover the same solid angle.
    let mut sum = 0.0;
    for y in 0..i64::from(image.height) {
        sum += (0..i64::from(image.width)).map(|x| grey(look.pixel(x, y))).sum::<f64>();
    }
    let vertical = (0..=rows).map(|i| angle(i, rows, 180.0)).collect();
    let horizontal = (0..=columns).map(|i| angle(i, columns, 360.0)).collect();
    let data = LightProfile::new(vertical, horizontal, values).ok()?;
    let mean = sum / (f64::from(image.width) * f64::from(image.height));
    Some(Intensities { profile: ProfileFile { uri: String::new(), data: Arc::new(data) }, mean })
}
