//! One sample on its own.

use super::tile::TileBuffers;
use crate::integrator::path::group;
use crate::integrator::{Prepared, Radiance};
use crate::schema::{ErrorCode, SceneError};
use crate::view::{camera_point, place_of, sample_id, take_points};

/// The radiance of sample `index` (from 0) of the pixel in column `x`, row `y` (from 0, top left), before the
/// film's `clamp_sample`. It equals the sample of the rendered picture bit for bit.
///
/// Errors ([`ErrorCode::OutOfRange`]): a pixel outside the picture, a sample index out of range, adaptive
/// anti-aliasing, whose samples have no index.
pub fn sample(p: &Prepared, x: u32, y: u32, index: u32) -> Result<Radiance, SceneError> {
    p.choose();
    let view = &p.view;
    let id = sample_id(view, x, y, index)?;
    let mut buffers = TileBuffers::new(p);
    if p.integrator.shares_paths() {
        let points = group(view, id).map(|id| (id, place_of(view, &id).into()));
        take_points(view, &mut buffers.samples, points);
    } else {
        camera_point(view, id, place_of(view, &id), &mut buffers.samples);
    }
    buffers.prepare(id.index);
    buffers.trace();
    let own = buffers.samples.ids.iter().position(|other| *other == id);
    let radiance = own.and_then(|own| buffers.radiance.get(own).copied());
    radiance.ok_or_else(|| SceneError::new(ErrorCode::Internal, "a sample gave no radiance"))
}
