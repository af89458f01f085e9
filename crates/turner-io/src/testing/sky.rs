//! A clear sky with a soft sun: its radiance and its environment map.

use turner::math::DVec3;
use turner::math::elementary::{exp, sin_cos};

use crate::image::{ImageError, ImageFormat, Metadata, OutputImage, Transfer, encode};

const HORIZON: DVec3 = DVec3::new(0.9, 0.85, 0.8);
const ZENITH: DVec3 = DVec3::new(0.25, 0.4, 0.8);
const GROUND: DVec3 = DVec3::new(0.15, 0.13, 0.1);
const SUN: DVec3 = DVec3::new(60.0, 48.0, 32.0);
const TO_SUN: DVec3 = DVec3::new(0.48, 0.6, 0.64);
const SHARPNESS: f64 = 400.0;

/// Radiance from the unit direction `d`: from horizon to zenith by the square root of the height, the ground
/// below, and a sun of the shape exp(400 (cos θ − 1)).
fn radiance(d: DVec3) -> DVec3 {
    let sky = if d.y >= 0.0 { HORIZON.lerp(ZENITH, d.y.sqrt()) } else { GROUND };
    sky + SUN * exp(SHARPNESS * (d.dot(TO_SUN) - 1.0))
}

/// The sky as an equirectangular EXR with `rows` rows and twice as many columns (1024 rows for scene S4). Each
/// pixel is the radiance at its centre.
pub fn sky_exr(rows: u32) -> Result<Vec<u8>, ImageError> {
    let rows = rows.clamp(1, 4096);
    let mut pixels = Vec::new();
    for y in 0..rows {
        let (sin_theta, cos_theta) = sin_cos(std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(rows));
        for x in 0..2 * rows {
            let (sin_phi, cos_phi) = sin_cos(std::f64::consts::PI * (f64::from(x) + 0.5) / f64::from(rows));
            // The centre of the map is −z; +x lies to the right of it.
            let d = DVec3::new(-sin_phi * sin_theta, cos_theta, cos_phi * sin_theta);
            let [r, g, b] = radiance(d).to_array().map(|v| v as f32);
            pixels.push([r, g, b, 1.0]);
        }
    }
    let picture = OutputImage {
        width: 2 * rows,
        height: rows,
        alpha: false,
        linear: Some(&pixels),
        transfer: Transfer::Unstated,
        metadata: &Metadata::new(),
        threads: 0,
        ..OutputImage::default()
    };
    encode(&picture, ImageFormat::Exr)
}
