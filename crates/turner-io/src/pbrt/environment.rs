//! Environment maps: pbrt's square images in the equal-area octahedral mapping (Clarberg 2008, "Fast equal-area
//! mapping of the (hemi)sphere using SIMD") become equirectangular maps of world directions.

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use turner::color::{Spectrum, srgb_decode};
use turner::image::Image;
use turner::math::elementary::{atan2, cos, sin};
use turner::math::{DMat3, DVec3};
use turner::schema::ImageId;

use super::assembly::Assembly;
use super::source::Place;
use crate::scene_import::environment_light;

/// The image `name` under the light's transform as an equirectangular map.
pub(super) fn equirectangular(
    scene: &mut Assembly<'_>,
    name: &str,
    to_world: DMat3,
    place: Place,
) -> Option<ImageId> {
    let id = scene.image(name, place)?;
    let source = scene.images.get(id.index())?.data.clone();
    let is_version3 = scene.frame.is_version3;
    if source.width != source.height && !is_version3 {
        let message = "an environment map that is not square: read as equirectangular (pbrt-v4 expects a square, equal-area octahedral map)";
        scene.report.doubtful(place, message);
    }
    let square = source.width == source.height && !is_version3;
    let look = EncodedView::new(&source);
    let light = |own: DVec3| if square { look.at(square_of(own)) } else { look.at(lat_long_of(own)) };
    let size = [source.height.saturating_mul(2), source.height];
    let image = environment_light::equirectangular(scene, size, to_world, place, light)?;
    Some(scene.add_image(name, image))
}

/// What pbrt takes for the illuminance of the image `name`: 2π / N times the sum of Y cos θ over those of its N pixels
/// that lie above the horizon of the light's own space. Each pixel covers 4π / N, so this is half of the irradiance.
pub(super) fn illuminance(scene: &mut Assembly<'_>, name: &str, place: Place) -> Option<f64> {
    let id = scene.image(name, place)?;
    let source = scene.images.get(id.index())?.data.clone();
    let look = EncodedView::new(&source);
    let (w, h) = (f64::from(source.width), f64::from(source.height));
    let mut sum = 0.0;
    for y in 0..source.height {
        let v = (f64::from(y) + 0.5) / h;
        for x in 0..source.width {
            // Cosine, and solid angle over 4π / N.
            let (cos_theta, share) = if source.width == source.height {
                (height_of([(f64::from(x) + 0.5) / w, v]), 1.0)
            } else {
                (cos(PI * v), 0.5 * PI * sin(PI * v))
            };
            if cos_theta > 0.0 {
                let [r, g, b] = look.pixel(i64::from(x), i64::from(y)).map(|c| c as f32);
                sum += f64::from(Spectrum::new(r, g, b).luminance()) * cos_theta * share;
            }
        }
    }
    Some(TAU * sum / (w * h))
}

/// The z coordinate of the direction at (u, v) of the octahedral square.
fn height_of([u, v]: [f64; 2]) -> f64 {
    let distance = 1.0 - (2.0 * u - 1.0).abs() - (2.0 * v - 1.0).abs();
    let r = 1.0 - distance.abs();
    (1.0 - r * r).copysign(distance)
}

/// (u, v) of a direction in the latitude-longitude maps of older pbrt versions, where z is up.
pub(super) fn lat_long_of(d: DVec3) -> [f64; 2] {
    let phi = atan2(d.y, d.x);
    let theta = atan2((d.x * d.x + d.y * d.y).sqrt(), d.z);
    [(phi / TAU).rem_euclid(1.0), theta / PI]
}

/// (u, v) of a unit direction in the octahedral square.
pub(super) fn square_of(d: DVec3) -> [f64; 2] {
    let [x, y, z] = d.abs().to_array();
    let r = (1.0 - z).max(0.0).sqrt();
    let (least, most) = (x.min(y), x.max(y));
    let phi = if most == 0.0 { 0.0 } else { atan2(least, most) * FRAC_2_PI };
    // Fraction of the quarter turn, from the x axis.
    let phi = if x < y { 1.0 - phi } else { phi };
    let (mut u, mut v) = (r - phi * r, phi * r);
    if d.z < 0.0 {
        // The hemisphere below folds outwards.
        (u, v) = (1.0 - v, 1.0 - u);
    }
    let signed = |v: f64, like: f64| if like < 0.0 { -v } else { v };
    [(signed(u, d.x) + 1.0) / 2.0, (signed(v, d.y) + 1.0) / 2.0]
}

/// An image with bilinear lookup.
pub(super) struct EncodedView<'a> {
    image: &'a Image,
    is_encoded: bool,
}

impl EncodedView<'_> {
    pub(super) fn new(image: &Image) -> EncodedView<'_> {
        EncodedView { image, is_encoded: image.is_display_encoded() }
    }

    /// The texel at a column and row. Beyond an edge of an octahedral map lies the texel mirrored at the centre
    /// of that edge.
    pub(super) fn pixel(&self, mut x: i64, mut y: i64) -> [f64; 3] {
        let (w, h) = (i64::from(self.image.width), i64::from(self.image.height));
        if w == h {
            if x < 0 || x >= w {
                x = if x < 0 { -x - 1 } else { 2 * w - 1 - x };
                y = h - 1 - y;
            }
            if y < 0 || y >= h {
                y = if y < 0 { -y - 1 } else { 2 * h - 1 - y };
                x = w - 1 - x;
            }
        } else {
            x = x.rem_euclid(w);
        }
        let c = self.image.rgb(x.clamp(0, w - 1) as u32, y.clamp(0, h - 1) as u32);
        c.map(|v| {
            let v = if self.is_encoded { srgb_decode(v) } else { v };
            if v.is_finite() { f64::from(v.max(0.0)) } else { 0.0 }
        })
    }

    /// The colour at (u, v).
    pub(super) fn at(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let (x, y) = (u * f64::from(self.image.width) - 0.5, v * f64::from(self.image.height) - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let mut sum = [0.0; 3];
        for (dx, dy, w) in [
            (0, 0, (1.0 - fx) * (1.0 - fy)),
            (1, 0, fx * (1.0 - fy)),
            (0, 1, (1.0 - fx) * fy),
            (1, 1, fx * fy),
        ] {
            sum.iter_mut().zip(self.pixel(x + dx, y + dy)).for_each(|(s, c)| *s += w * c);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use turner::math::elementary::sin_cos;

    /// The inverse, as in Clarberg 2008.
    fn sphere_of([u, v]: [f64; 2]) -> DVec3 {
        let (u, v) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let (up, vp) = (u.abs(), v.abs());
        let distance = 1.0 - (up + vp);
        let r = 1.0 - distance.abs();
        let phi = (if r == 0.0 { 1.0 } else { (vp - up) / r + 1.0 }) * PI / 4.0;
        let z = (1.0 - r * r).copysign(distance);
        let across = r * (2.0 - r * r).max(0.0).sqrt();
        let (s, c) = sin_cos(phi);
        DVec3::new(c.copysign(u) * across, s.copysign(v) * across, z)
    }

    #[test]
    fn squares_and_spheres_are_inverse() {
        for i in 0..40 {
            for j in 0..40 {
                let uv = [(f64::from(i) + 0.5) / 40.0, (f64::from(j) + 0.5) / 40.0];
                let d = sphere_of(uv);
                assert!((d.length() - 1.0).abs() < 1e-12 && (height_of(uv) - d.z).abs() < 1e-12);
                let back = square_of(d);
                assert!((back[0] - uv[0]).abs() + (back[1] - uv[1]).abs() < 1e-9, "{uv:?} {d} {back:?}");
            }
        }
    }
}
