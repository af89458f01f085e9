//! The choice of strategy for caustics: the number of light paths, their targets, and whether photons are used.

use super::Caustics;
use super::photons::Photon;
use super::pilot_light::PilotLight;
use super::probe::probe;
use crate::integrator::path::{Context, LightSampling, PathDesc};
use crate::integrator::probing::is_cheap;
use crate::math::DVec2;
use crate::scene::Scene;
use crate::scene::caustic_targets::CausticTargets;

/// Maximum number of light paths per sample index; photons take some 75 MB per million of them.
const MOST_PATHS: u64 = 1 << 20;

/// Light paths per camera path where the scene is not probed.
const UNPROBED: f64 = 0.25;

/// Cost and contribution of light paths, as the probe estimates them from a few paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Price {
    /// Cost of a sample with its fraction of the light paths, relative to the sample alone.
    pub(crate) work: f64,
    /// Fraction of the image's light that light paths contribute.
    pub(crate) contribution: f64,
    /// Fraction of the image's light that camera paths never find.
    pub(crate) light_paths_only: f64,
}

/// The light paths of an image.
#[derive(Clone, Debug)]
pub struct CausticsStrategy {
    /// The caustic targets that light paths are aimed at.
    pub caustic_targets: CausticTargets,
    /// Number of light paths per sample index (one sample of every pixel); greater than 0.
    pub paths: u64,
    /// Whether camera paths gather photons.
    pub merges: bool,
    /// Radius of the photons for the first sample, in scene units.
    pub first_radius: f64,
    /// Cost for the same noise relative to no light paths, where these are optional.
    pub(crate) gain: Option<f64>,
    /// What the probe measured; `None` where it was too expensive to run.
    pub(crate) price: Option<Price>,
    /// Width of the margin around the image in which splats still count (pixel filter), in pixels.
    pub(super) margin: f64,
}

impl CausticsStrategy {
    /// The strategy for a prepared scene; `None` for no light paths.
    pub(in crate::integrator::path) fn new(
        context: Context<'_>,
        desc: &PathDesc,
    ) -> Option<CausticsStrategy> {
        let Context { scene, view, .. } = context;
        // Light paths ignore scattering in media, and motion of the camera and of lights; not all cameras receive them.
        let stands_still = view.motion.is_none() && scene.light_motions.is_empty();
        let possible = desc.light_sampling == LightSampling::Both && scene.volumes.is_none() && stands_still;
        let possible = possible && view.camera.receives_light_paths();
        if desc.caustics == Caustics::Off || !possible {
            return None;
        }
        let caustic_targets = CausticTargets::new(scene)?;
        let pixels = u64::from(view.film.width) * u64::from(view.film.height);
        // Weighted samples lie inside the image, and so must splats.
        let margin = if view.film.weights_samples() { 0.0 } else { view.film.filter().radius() - 0.5 };
        let margin = margin.max(0.0);
        let paths = pixels.min(MOST_PATHS);
        let mut strategy = CausticsStrategy {
            caustic_targets,
            paths,
            merges: true,
            first_radius: 0.0,
            gain: None,
            price: None,
            margin,
        };
        if !is_cheap(scene, view) {
            // Light that only light paths find must be kept. Without photons light paths are always unbiased.
            strategy.merges = desc.caustics == Caustics::Full;
            strategy.paths = ((pixels as f64 * UNPROBED) as u64).clamp(1, MOST_PATHS);
            strategy.first_radius = desc.photon_radius.unwrap_or_else(|| radius_of(scene, None));
            return Some(strategy);
        }
        strategy.first_radius = desc.photon_radius.unwrap_or_else(|| strategy.guess_radius(context));
        let result = probe(context, &strategy);
        strategy.merges = match desc.caustics {
            Caustics::Full => true,
            Caustics::Auto => result.photons_pay,
            Caustics::LightTracing | Caustics::Off => false,
        };
        if desc.caustics == Caustics::Auto && !result.pays && !strategy.merges {
            return None;
        }
        strategy.gain = result.gain.filter(|_| desc.caustics == Caustics::Auto && !strategy.merges);
        // If the probe found nothing, all targets keep their probabilities.
        let _ = strategy.caustic_targets.choose_by(&result.groups);
        let ratio = if strategy.merges { result.ratio_with_photons } else { result.ratio };
        strategy.paths = ((pixels as f64 * ratio) as u64).clamp(1, MOST_PATHS);
        let only = result.light_paths_only;
        let light_paths_only = if strategy.merges { only.max(result.by_photons) } else { only };
        strategy.price = Some(Price {
            work: 1.0 + result.price * strategy.paths as f64 / pixels as f64,
            contribution: result.contribution.max(light_paths_only),
            light_paths_only,
        });
        Some(strategy)
    }
}

impl CausticsStrategy {
    /// A radius of a few pixels at the places where photons arrive.
    fn guess_radius(&self, context: Context<'_>) -> f64 {
        /// Number of light paths traced for the estimate.
        const PATHS: u32 = 2048;
        let Context { scene, view, .. } = context;
        let light = PilotLight::trace(context, self, u64::MAX - u64::from(PATHS), PATHS);
        let pixel = |photon: &Photon| {
            let seen = view.camera.project(&view.film, photon.p, DVec2::splat(0.5))?;
            Some(1.0 / seen.density.sqrt())
        };
        let mut sizes: Vec<f64> = light.photons.iter().filter_map(pixel).collect();
        sizes.sort_by(f64::total_cmp);
        radius_of(scene, sizes.get(sizes.len() / 2).copied())
    }
}

/// Photon radius where a pixel has this size in scene units, if that is known.
fn radius_of(scene: &Scene, size: Option<f64>) -> f64 {
    /// In pixels.
    const RADIUS: f64 = 2.5;
    let scale = scene.stats.bounds.map_or(1.0, |b| b.size().length());
    (RADIUS * size.unwrap_or(1e-3 * scale)).clamp(1e-7 * scale, 0.1 * scale).max(1e-30)
}

/// The strategy as reported with a rendered image.
impl std::fmt::Display for CausticsStrategy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} light paths per sample of all pixels", self.paths)?;
        match self.merges {
            true => write!(
                f,
                "; photons for caustics seen in mirrors or through glass, initial radius {:.4e} (slightly blurred)",
                self.first_radius
            ),
            false => Ok(()),
        }
    }
}
