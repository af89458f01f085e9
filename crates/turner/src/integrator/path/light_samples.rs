//! How many lights are sampled at the first surface of a path that is not specular.
//!
//! The camera ray and the hit cost more than a further light sample with its shadow ray. Where most of the noise comes from
//! the choice of the point on a light, as under an environment map or large lamps, several light samples have less noise for
//! the time. With n of them, noise and time are
//!
//! ```text
//!  noise(n) = stays + falls / n            time(n) = 1 + c·(n - 1)
//! ```
//!
//! A pilot run measures the noise for n = 1 and n = [`MEASURED`], which tells `stays` and `falls`, and counts the shadow rays,
//! which tell c. The n of the least noise(n)·time(n) is taken (splitting: Arvo and Kirk 1990, "Particle Transport and Image
//! Synthesis").

use super::pilot_run::{OFFSETS, PilotRun};
use super::{Context, LightSampling};
use crate::integrator::probing::is_cheap;

/// Numbers of light samples.
const NUMBERS: [u32; 6] = [1, 2, 3, 4, 6, 8];

/// The number that is measured beside 1.
const MEASURED: u32 = 4;

/// Cost of a light sample with its shadow ray, in rays of paths with their shading: measured 0.4 to 0.8, and up to 1.2 where
/// lights are sampled in vain.
const LIGHT_SAMPLE_COST: f64 = 0.75;

/// Maximum cost for the same noise, relative to one light sample.
const MAX_COST: f64 = 0.97;

/// Costs that are in doubt: more pixels are traced.
const DOUBT: std::ops::Range<f64> = 0.85..1.1;

/// Pixels of a cluster, where paths are not shared.
const PIXELS: u32 = 4;

/// The number of light samples: as asked, or what has the least noise for the time.
pub(super) fn decide(context: Context<'_>, asked: Option<u32>) -> u32 {
    let Context { scene, view, settings, strategy, .. } = context;
    if let Some(asked) = asked {
        return asked;
    }
    let is_sampled = settings.light_sampling != LightSampling::Bsdf
        && settings.max_depth > 0
        && strategy.is_none()
        && !scene.emitters.is_empty();
    // Scenes with expensive rays are not probed.
    if is_sampled && is_cheap(scene, view) { cheapest(context) } else { 1 }
}

/// The number of light samples with the least cost for the same noise.
fn cheapest(context: Context<'_>) -> u32 {
    let modes = [1, MEASURED].map(|light_samples| {
        let mut context = context;
        context.settings.light_samples = light_samples;
        context
    });
    let size = if context.cluster > 1 { context.cluster } else { PIXELS };
    let mut run = PilotRun::new(&modes, size);
    let mut least = (1.0, 1);
    for offset in OFFSETS {
        run.trace(offset);
        let noises = run.noises();
        // Without noise, or without further light samples, one is enough.
        if noises[0] <= 0.0 || run.rays(1) <= run.rays(0) {
            return 1;
        }
        let further = (run.rays(1) / run.rays(0) - 1.0) / f64::from(MEASURED - 1);
        let costs = NUMBERS.map(|number| (cost(noises[1] / noises[0], further, number), number));
        least = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(least);
        if !DOUBT.contains(&least.0) {
            break;
        }
    }
    if least.0 < MAX_COST { least.1 } else { 1 }
}

/// Cost for the same noise of `number` light samples, relative to one. `noise` is that of [`MEASURED`] ones, relative to one;
/// `further` is the number of rays of a further light sample, relative to all rays of a path.
fn cost(noise: f64, further: f64, number: u32) -> f64 {
    let (n, measured) = (f64::from(number), f64::from(MEASURED));
    let falls = ((1.0 - noise) * measured / (measured - 1.0)).clamp(0.0, 1.0);
    let stays = (noise - falls / measured).max(0.0);
    (stays + falls / n) * (1.0 + LIGHT_SAMPLE_COST * further * (n - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn best(noise: f64, further: f64) -> u32 {
        let costs = NUMBERS.map(|number| (cost(noise, further, number), number));
        costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
    }

    #[test]
    fn the_number_follows_noise_and_rays() {
        // All noise falls: as many as there are, if they cost little.
        assert!((cost(0.25, 0.0, 8) - 0.125).abs() < 1e-12);
        assert_eq!(best(0.25, 0.01), 8);
        // sqrt(falls / stays / cost of one) = 3.9
        assert_eq!(best(0.35, 0.1), 4);
        assert_eq!(best(0.7, 0.25), 2);
        assert_eq!(best(0.97, 0.3), 1);
        // More noise than with one: never.
        assert_eq!(best(1.3, 0.2), 1);
        assert!((cost(0.5, 0.3, 1) - 1.0).abs() < 1e-12);
    }
}
