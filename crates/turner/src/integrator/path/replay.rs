//! Replay: one sample traced again with a record.

use super::path_batch::PathBatch;
use super::record::{DonorRecord, End, Off, PathRecord, SharedRecord};
use super::shared_paths::cluster;
use super::{Context, PathIntegrator};
use crate::color::Spectrum;
use crate::integrator::{CameraSamples, Prepared, PreparedIntegrator, Radiance, RayStats, Tracer};
use crate::math::DVec3;
use crate::sampler::SampleId;
use crate::schema::{ErrorCode, Remedy, SceneError};
use crate::view::{camera_point, place_of, sample_id, take_points};

/// Traces sample `index` (from 0) of the pixel in column `x`, row `y` (from 0, top left) as rendering does, and records
/// it.
///
/// The path is traced by the rendering code with the same random numbers: the record's radiance is the sample's, to the
/// last bit ([`crate::render::sample`]).
///
/// Errors: a pixel outside the image, a sample beyond `film.samples`, adaptive anti-aliasing, whose samples have no
/// index ([`ErrorCode::OutOfRange`]), and an integrator other than "path" and "direct" ([`ErrorCode::Conflict`]).
pub fn replay(p: &Prepared, x: u32, y: u32, index: u32) -> Result<PathRecord, SceneError> {
    integrator(p)?;
    let id = sample_id(&p.view, x, y, index)?;
    replay_at(p, id, place_of(&p.view, &id))
}

/// The integrator, if it is a path tracer.
fn integrator(p: &Prepared) -> Result<&PathIntegrator, SceneError> {
    p.path().ok_or_else(|| {
        let message = format!(
            "the integrator is \"{}\", but only \"path\" and \"direct\" can be replayed",
            p.integrator.name()
        );
        SceneError::new(ErrorCode::Conflict, message)
            .help("set `type = \"path\"` in [integrator]")
            .remedy(Remedy::set("integrator.type", "path"))
    })
}

/// As [`replay`], for a sample given by its ID and its position in the image, in pixels from the top left corner. The
/// samples of [`crate::render::pixel`] can be replayed with any anti-aliasing.
///
/// Errors: an integrator other than "path" and "direct" ([`ErrorCode::Conflict`]).
pub fn replay_at(p: &Prepared, id: SampleId, place: [f64; 2]) -> Result<PathRecord, SceneError> {
    p.choose(1);
    let integrator = integrator(p)?;
    let (scene, view) = (&*p.scene, &p.view);
    let context = integrator.context(scene, view);
    let mut samples = CameraSamples::default();
    camera_point(view, id, place, &mut samples);
    let ray = samples.rays.get(0);
    let mut record = PathRecord {
        id,
        place,
        origin: ray.map_or(DVec3::ZERO, |r| r.origin),
        direction: ray.map_or(DVec3::ZERO, |r| r.direction),
        time: samples.rays.time(0),
        vertices: Vec::new(),
        escape: None,
        way: None,
        shared: None,
        donated_from: None,
        donated_until: None,
        next_is_equiangular: false,
        end: End::Absorbed,
        radiance: Radiance { color: Spectrum::BLACK, alpha: 1.0 },
    };
    if ray.is_none_or(|ray| ray.t_max < 0.0) {
        record.end = End::OutsideField;
        record.radiance.alpha = if scene.background.transparent { 0.0 } else { 1.0 };
        return Ok(record);
    }
    let shared = in_cluster(context, id);
    let mut batch = PathBatch::new(context, record);
    if let Some(InCluster { densities, .. }) = &shared {
        batch.shared_paths.take_densities(*densities);
    }
    if let Some(photons) = integrator.photons(scene, view, id.index) {
        batch.find_photons(photons);
    }
    let mut out = Vec::new();
    batch.radiance(&samples, &mut out, &mut RayStats::default());
    let mut record = batch.record;
    if let Some(radiance) = out.first() {
        record.radiance = *radiance;
    }
    if let Some(InCluster { radiance, parts, .. }) = shared {
        record.radiance = radiance;
        record.shared = Some(SharedRecord { from: record.donated_from, until: record.donated_until, parts });
    }
    Ok(record)
}

/// A sample within its cluster.
struct InCluster {
    radiance: Radiance,
    /// The donor paths that contribute to it.
    parts: Vec<DonorRecord>,
    /// Of its own path, see [`SharedPaths::densities`](super::shared_paths::SharedPaths::densities).
    densities: [f64; 2],
}

/// The result of a sample within its cluster, where paths are shared.
fn in_cluster(context: Context<'_>, id: SampleId) -> Option<InCluster> {
    let view = context.view;
    let mut batch = PathBatch::new(context, Off);
    if !batch.shared_paths.is_on() {
        return None;
    }
    let mut samples = CameraSamples::default();
    take_points(
        view,
        &mut samples,
        cluster(view, id, context.cluster).map(|id| (id, place_of(view, &id).into())),
    );
    let mut out = Vec::new();
    batch.radiance(&samples, &mut out, &mut RayStats::default());
    let own = samples.ids.iter().position(|other| *other == id)?;
    let parts = batch.received_by(own).filter_map(|(from, p, part, share, radiance)| {
        let id = *samples.ids.get(from)?;
        Some(DonorRecord { id, p, part, radiance, share, contribution: share * radiance })
    });
    let densities = batch.shared_paths.densities(own);
    Some(InCluster { radiance: *out.get(own)?, parts: parts.collect(), densities })
}
