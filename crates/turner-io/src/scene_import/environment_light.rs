//! Environment maps of other renderers, resampled to equirectangular maps of world directions.

use std::f64::consts::PI;

use turner::image::{Image, Pixels};
use turner::math::elementary::{sin_cos, sin_cos_turns};
use turner::math::{DMat3, DVec3};
use turner::schema::ImageId;

use super::{CommonParts, Place};

/// Samples per pixel along each side.
const LOOKS: u32 = 2;
/// Most threads that resample.
const MAX_THREADS: usize = 64;
/// Most rows of a resampled map.
pub(crate) const MAX_ROWS: u32 = 8192;

/// The environment map of a constant light: white.
pub(crate) fn white(stock: &mut CommonParts<'_>) -> ImageId {
    let image = Image { width: 2, height: 1, channels: 3, pixels: Pixels::F32(vec![1.0; 6]) };
    stock.add_image("", image)
}

/// An equirectangular environment map of about `size` (columns, rows; small maps are enlarged). `light` is the
/// radiance from a direction in the light's own space. `None`, which is reported, if the transform is not
/// invertible or memory is short.
pub(crate) fn equirectangular(
    stock: &mut CommonParts<'_>,
    size: [u32; 2],
    to_world: DMat3,
    place: Place,
    light: impl Fn(DVec3) -> [f64; 3] + Sync,
) -> Option<Image> {
    let finer = stock.finer(size[1]);
    let made = resampled(size.map(|n| n.saturating_mul(finer)), to_world, stock.options.threads, light);
    if made.is_none() {
        let message = "an environment map that is too large or whose transform is not invertible";
        stock.report.ignored(place, message);
    }
    made
}

/// An equirectangular environment map of a number of columns and rows, at most 16384 and 8192. `light` is the radiance
/// from a direction in the light's own space; `threads` is 0 for all. `None` if the transform is not invertible or memory
/// is short.
pub(crate) fn resampled(
    size: [u32; 2],
    to_world: DMat3,
    threads: usize,
    light: impl Fn(DVec3) -> [f64; 3] + Sync,
) -> Option<Image> {
    let (columns, rows) = (size[0].clamp(2, 2 * MAX_ROWS), size[1].clamp(2, MAX_ROWS));
    let to_light = to_world.inverse();
    let count = (rows as usize) * (columns as usize) * 3;
    let mut pixels: Vec<f32> = Vec::new();
    if !to_light.is_finite() || pixels.try_reserve_exact(count).is_err() {
        return None;
    }
    pixels.resize(count, 0.0);
    let fill = |first: usize, part: &mut [f32]| {
        for (i, pixel) in part.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let at = first + i;
            let (x, y) = ((at % columns as usize) as f64, (at / columns as usize) as f64);
            let mut color = [0.0; 3];
            for i in 0..LOOKS * LOOKS {
                let (i, j) = (i % LOOKS, i / LOOKS);
                let u = (x + (f64::from(i) + 0.5) / f64::from(LOOKS)) / f64::from(columns);
                let v = (y + (f64::from(j) + 0.5) / f64::from(LOOKS)) / f64::from(rows);
                let own = (to_light * direction(u, v)).normalize_or(DVec3::Y);
                color.iter_mut().zip(light(own)).for_each(|(c, f)| *c += f);
            }
            *pixel = color.map(|c| (c / f64::from(LOOKS * LOOKS)) as f32);
        }
    };
    let available = || turner_host::thread::available();
    let threads = if threads == 0 { available() } else { threads };
    let each = (count / 3).div_ceil(threads.min(MAX_THREADS)).max(1 << 14);
    turner_host::thread::scope(|scope| {
        let mut parts = pixels.chunks_mut(3 * each).enumerate();
        let own = parts.next();
        for (i, part) in parts {
            let fill = &fill;
            scope.spawn(move || fill(i * each, part));
        }
        own.into_iter().for_each(|(i, part)| fill(i * each, part));
    });
    Some(Image { width: columns, height: rows, channels: 3, pixels: Pixels::F32(pixels) })
}

/// The world direction at (u, v) of an equirectangular map: the centre is −z, u grows towards +x, v = 0 is +y.
pub(crate) fn direction(u: f64, v: f64) -> DVec3 {
    let (sin_theta, cos_theta) = sin_cos(PI * v);
    let (sin_phi, cos_phi) = sin_cos_turns(u - 0.5);
    DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
}
