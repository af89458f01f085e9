//! Traces one sample again, with a recorder.

use super::notes::Notes;
use super::prepared::ClassicIntegrator;
use super::radiance::TreeBatch;
use super::record::TreeRecord;
use crate::color::Spectrum;
use crate::integrator::{CameraSamples, Prepared, Radiance, RayStats, Tracer};
use crate::sampler::SampleId;
use crate::schema::{ErrorCode, SceneError};
use crate::view::{camera_point, place_of, sample_id};

/// Traces sample `index` (from 0) of the pixel in column `x`, row `y` (from 0, top left) and records it.
///
/// It runs the rendering code: the radiance of the record equals that of the sample ([`crate::render::sample`])
/// bit for bit.
///
/// Errors: a pixel outside the picture, a sample index out of range, adaptive anti-aliasing, whose samples have
/// no index ([`ErrorCode::OutOfRange`]), and an integrator other than "classic" ([`ErrorCode::Conflict`]).
pub fn replay(p: &Prepared, x: u32, y: u32, index: u32) -> Result<TreeRecord, SceneError> {
    let id = sample_id(&p.view, x, y, index)?;
    replay_at(p, id, place_of(&p.view, &id))
}

/// The same for a sample given by its id and its position in the picture, in pixels from the top left corner. The
/// samples of [`crate::render::pixel`] can be replayed with any anti-aliasing.
///
/// Errors: an integrator other than "classic" ([`ErrorCode::Conflict`]).
pub fn replay_at(p: &Prepared, id: SampleId, place: [f64; 2]) -> Result<TreeRecord, SceneError> {
    let (scene, view) = (&*p.scene, &p.view);
    let any: &dyn std::any::Any = &*p.integrator;
    let Some(ClassicIntegrator(integrator)) = any.downcast_ref() else {
        let message =
            format!("the integrator is \"{}\": only \"classic\" has a tree of rays", p.integrator.name());
        return Err(SceneError::new(ErrorCode::Conflict, message));
    };
    let mut samples = CameraSamples::default();
    camera_point(view, id, place, &mut samples);
    let mut tree = TreeRecord {
        id,
        place,
        rays: Vec::new(),
        unwritten: 0,
        dropped: 0,
        radiance: Radiance { color: Spectrum::BLACK, alpha: 1.0 },
        total: None,
    };
    if samples.rays.get(0).is_none_or(|ray| ray.t_max < 0.0) {
        tree.radiance.alpha = if scene.background.transparent { 0.0 } else { 1.0 };
        return Ok(tree);
    }
    let mut batch = TreeBatch::new(integrator, scene, view, Notes::new(tree));
    let mut out = Vec::new();
    batch.radiance(&samples, &mut out, &mut RayStats::default());
    let mut tree = batch.record.tree;
    if let Some(radiance) = out.first() {
        tree.radiance = *radiance;
    }
    Ok(tree)
}
