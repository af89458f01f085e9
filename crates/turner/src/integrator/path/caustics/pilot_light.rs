//! The light paths of the pilot run.

use super::light_path_batch::LightPathBatch;
use super::photons::Photon;
use super::strategy::CausticsStrategy;
use crate::film::Splat;
use crate::integrator::path::Context;
use crate::integrator::{RayStats, tasks};

/// Light paths that are traced together.
const TOGETHER: u32 = 1024;

/// The contributions, photons and costs of light paths.
#[derive(Default)]
pub(super) struct PilotLight {
    /// Contributions: the splat, its MIS weight and the caustic target.
    pub(super) splats: Vec<(Splat, f64, u32)>,
    pub(super) photons: Vec<Photon>,
    /// Numbers of rays and of scattering events, and of those on surfaces with a thin film.
    pub(super) rays: u64,
    pub(super) scatterings: u64,
    pub(super) films: u64,
}

impl PilotLight {
    /// Traces `count` light paths from the index `first` on.
    pub(super) fn trace(
        context: Context<'_>,
        strategy: &CausticsStrategy,
        first: u64,
        count: u32,
    ) -> PilotLight {
        let parts = tasks::map(
            count.div_ceil(TOGETHER) as usize,
            context.threads,
            || (),
            |(), part| {
                let done = part as u32 * TOGETHER;
                let mut batch = LightPathBatch::new(context, strategy);
                let (mut stats, mut splats) = (RayStats::default(), Vec::new());
                let paths = TOGETHER.min(count - done);
                batch.advance(first + u64::from(done), paths, &mut stats, |splat, weight, group| {
                    splats.push((splat, weight, group));
                });
                let (scatterings, films) = (batch.scatterings, batch.films);
                PilotLight { splats, photons: batch.take_photons(), rays: stats.light, scatterings, films }
            },
        );
        let mut all = PilotLight::default();
        for part in parts {
            all.splats.extend(part.splats);
            all.photons.extend(part.photons);
            all.rays += part.rays;
            all.scatterings += part.scatterings;
            all.films += part.films;
        }
        all
    }
}
