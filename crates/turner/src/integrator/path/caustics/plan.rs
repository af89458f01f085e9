//! How many light paths there are, and what they are aimed at.

use super::Caustics;
use super::light::LightWave;
use super::photons::Photon;
use super::probe::probe;
use crate::integrator::RayStats;
use crate::integrator::path::probing::is_cheap;
use crate::integrator::path::settings::Settings;
use crate::integrator::path::{Context, LightSampling, PathDesc};
use crate::math::DVec2;
use crate::scene::Scene;
use crate::scene::casters::Casters;
use crate::view::View;

/// The most light paths to a sample of all pixels: photons take some 75 MB per million of them.
const MOST_PATHS: u64 = 1 << 20;

/// Light paths to each camera path where no probe says how many pay.
const UNPROBED: f64 = 0.25;

/// The share of the picture's light that photons must bring to be found.
const LEAST_BY_PHOTONS: f64 = 1e-3;

/// What light paths cost and bring, as the probe estimates it from a few paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Price {
    /// Work of a sample with its share of light paths, over that of the sample alone.
    pub(crate) work: f64,
    /// Fraction of the picture's light that light paths bring.
    pub(crate) brings: f64,
    /// Fraction of the picture's light that camera paths never find.
    pub(crate) alone: f64,
}

/// The light paths of a picture.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What they are aimed at.
    pub casters: Casters,
    /// How many there are to each sample of all pixels; greater than 0.
    pub paths: u64,
    /// Whether camera paths find photons.
    pub merges: bool,
    /// How far photons count for the first sample, in scene units.
    pub first_radius: f64,
    /// Work for the same noise, over that without light paths, where these are a matter of choice.
    pub(crate) gain: Option<f64>,
    /// What the probe measured; `None` where it was too expensive to run.
    pub(crate) price: Option<Price>,
    /// How far beyond the picture's edge light still counts for it, in pixels.
    pub(super) margin: f64,
}

impl Plan {
    /// For a scene that is otherwise ready; `None` where there are none.
    pub(in crate::integrator::path) fn new(scene: &Scene, view: &View, desc: &PathDesc) -> Option<Plan> {
        let context = Context { scene, view, settings: Settings::path(desc), plan: None, shares: false };
        // Light paths do not know what media scatter.
        let possible = desc.light_sampling == LightSampling::Both && scene.volumes.is_none();
        if desc.caustics == Caustics::Off || !possible {
            return None;
        }
        let casters = Casters::new(scene)?;
        let pixels = u64::from(view.film.width) * u64::from(view.film.height);
        let margin = (view.film.filter().radius() - 0.5).max(0.0);
        let paths = pixels.min(MOST_PATHS);
        let mut plan =
            Plan { casters, paths, merges: true, first_radius: 0.0, gain: None, price: None, margin };
        if !is_cheap(scene, view) {
            // What light paths alone find must not be lost: without photons they are never wrong.
            plan.merges = desc.caustics == Caustics::Full;
            plan.paths = ((pixels as f64 * UNPROBED) as u64).clamp(1, MOST_PATHS);
            plan.first_radius = desc.photon_radius.unwrap_or_else(|| radius_of(scene, None));
            return Some(plan);
        }
        plan.first_radius = desc.photon_radius.unwrap_or_else(|| plan.guess_radius(context));
        let found = probe(context, &plan);
        plan.merges = match desc.caustics {
            Caustics::Full => true,
            Caustics::Auto => found.by_photons > LEAST_BY_PHOTONS,
            Caustics::LightTracing | Caustics::Off => false,
        };
        if desc.caustics == Caustics::Auto && !found.pays && !plan.merges {
            return None;
        }
        plan.gain = found.gain.filter(|_| desc.caustics == Caustics::Auto && !plan.merges);
        // Where nothing was found all groups are chosen as before.
        let _ = plan.casters.choose_by(&found.groups);
        let ratio = if plan.merges { found.ratio_with_photons } else { found.ratio };
        plan.paths = ((pixels as f64 * ratio) as u64).clamp(1, MOST_PATHS);
        let alone = if plan.merges { found.alone.max(found.by_photons) } else { found.alone };
        let brings = found.brings.max(alone);
        let per_sample = plan.paths as f64 / pixels as f64;
        plan.price = Some(Price { work: 1.0 + found.price * per_sample, brings, alone });
        Some(plan)
    }
}

impl Plan {
    /// A few pixels, where photons arrive.
    fn guess_radius(&self, context: Context<'_>) -> f64 {
        /// Photons looked at.
        const PATHS: u32 = 2048;
        let Context { scene, view, .. } = context;
        let mut wave = LightWave::new(context, self);
        wave.advance(u64::MAX - u64::from(PATHS), PATHS, &mut RayStats::default(), |_, _, _| {});
        let pixel = |photon: &Photon| {
            let seen = view.camera.project(&view.film, photon.p, DVec2::splat(0.5))?;
            Some(1.0 / seen.density.sqrt())
        };
        let mut sizes: Vec<f64> = wave.photons.iter().filter_map(pixel).collect();
        sizes.sort_by(f64::total_cmp);
        radius_of(scene, sizes.get(sizes.len() / 2).copied())
    }
}

/// How far photons count where pixels have this size, as far as that is known.
fn radius_of(scene: &Scene, size: Option<f64>) -> f64 {
    /// In pixels.
    const RADIUS: f64 = 2.5;
    let scale = scene.stats.bounds.map_or(1.0, |b| b.size().length());
    (RADIUS * size.unwrap_or(1e-3 * scale)).clamp(1e-7 * scale, 0.1 * scale).max(1e-30)
}

/// What a picture says of its making.
impl std::fmt::Display for Plan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} light paths to each sample of all pixels", self.paths)?;
        match self.merges {
            true => write!(
                f,
                "; photons behind mirrors and glass, radius {:.4e} at first: a little blurred",
                self.first_radius
            ),
            false => Ok(()),
        }
    }
}
