//! One sample on its own.

use std::ops::Range;

use super::pixel::SampleRecord;
use super::tile::TileBuffers;
use crate::integrator::path::cluster;
use crate::integrator::{Prepared, Radiance};
use crate::schema::{ErrorCode, SceneError};
use crate::view::{camera_point, place_of, sample_id, take_points};

/// The radiance of sample `index` (from 0) of the pixel in column `x`, row `y` (from 0, top left), before the
/// film's `clamp_sample`. It equals the sample of the rendered picture bit for bit.
///
/// Errors ([`ErrorCode::OutOfRange`]): a pixel outside the picture, a sample index out of range, adaptive
/// anti-aliasing, whose samples have no index.
pub fn sample(p: &Prepared, x: u32, y: u32, index: u32) -> Result<Radiance, SceneError> {
    let samples = pixel_samples(p, x, y, index..index.saturating_add(1))?;
    let none = || SceneError::new(ErrorCode::Internal, "a sample gave no radiance");
    samples.first().map(|s| s.radiance).ok_or_else(none)
}

/// Samples of one pixel without the others: those with the indices `indices`, as far as the pixel has them. Each equals the
/// sample of the picture bit for bit, and all have the same weight. A pixel filter is not applied.
///
/// Errors ([`ErrorCode::OutOfRange`]): a pixel outside the picture, no index that the pixel has, adaptive anti-aliasing,
/// whose samples have no index.
pub fn pixel_samples(
    p: &Prepared,
    x: u32,
    y: u32,
    indices: Range<u32>,
) -> Result<Vec<SampleRecord>, SceneError> {
    p.choose(1);
    let view = &p.view;
    sample_id(view, x, y, indices.start)?;
    let last = indices.end.min(view.film.samples_per_pixel());
    let mut buffers = TileBuffers::new(p);
    let mut out: Vec<SampleRecord> = Vec::new();
    for index in indices.start..last {
        let id = sample_id(view, x, y, index)?;
        let place = place_of(view, &id);
        if p.integrator.shares_paths() {
            let points = cluster(view, id, p.integrator.cluster()).map(|id| (id, place_of(view, &id).into()));
            buffers.samples.clear();
            take_points(view, &mut buffers.samples, points);
        } else {
            buffers.samples.clear();
            camera_point(view, id, place, &mut buffers.samples);
        }
        buffers.prepare(index);
        buffers.trace();
        let own = buffers.samples.ids.iter().position(|other| *other == id);
        let radiance = own.and_then(|own| buffers.radiance.get(own).copied());
        let none = || SceneError::new(ErrorCode::Internal, "a sample gave no radiance");
        out.push(SampleRecord { id, place, weight: 1.0, radiance: radiance.ok_or_else(none)? });
    }
    let weight = 1.0 / out.len() as f64;
    out.iter_mut().for_each(|s| s.weight = weight);
    Ok(out)
}
