//! How many lights are sampled at the first surface of a path that is not specular.
//!
//! The camera ray and the hit cost more than a further light sample with its shadow ray. Where most of the noise comes from
//! the choice of the point on a light, as under an environment map or a large area light, several light samples have less noise
//! for the time (splitting: Arvo and Kirk 1990, "Particle Transport and Image Synthesis"). With n of them, noise and time are
//!
//! ```text
//!  noise(n) = stays + falls / n            time(n) = 1 + c·(n - 1)
//! ```
//!
//! A pilot run measures the noise for n = 1 and n = [`MEASURED`], which tells `stays` and `falls`, and counts the shadow rays,
//! which tell c. The n of the least noise(n)·time(n) is taken. Where paths are shared, less noise stays.

use super::learn_environment::Sky;
use super::pilot_run::{OFFSETS, PilotRun};
use super::settings::Settings;
use super::shared_paths::Sharing;
use super::{Context, LightSampling};
use crate::integrator::probing::is_cheap;

/// Numbers of samples of direct light, of which one may be the direction of the path.
const NUMBERS: [u32; 6] = [1, 2, 3, 4, 6, 8];

/// The number that is measured beside 1.
const MEASURED: u32 = 4;

/// Cost of a light sample with its shadow ray, in rays of paths with their shading: measured 0.4 to 0.8, and up to 1.2 where
/// lights are sampled in vain.
const LIGHT_SAMPLE_COST: f64 = 0.75;

/// Of all numbers whose cost is at most this multiple of the least, the smallest is chosen. The noise of direct light falls
/// faster with the number of samples per pixel than other noise, so the pilot run overestimates it a little.
const SMALLEST: f64 = 1.05;

/// The least cost of several light samples relative to one. In this range the choice is uncertain, so the pilot run traces
/// more pixels.
const DOUBT: std::ops::Range<f64> = 0.85..1.03;

/// Noise with [`MEASURED`] light samples relative to the noise with one. Above this ratio, light samples do not cause the
/// noise.
const UNCHANGED: f64 = 0.98;

/// Pixels of a cluster.
const PIXELS: u32 = 4;

/// The number of light samples: that of the description, or the number with the least noise for the time.
pub(super) fn decide(context: Context<'_>, sharing: Sharing, asked: Option<u32>) -> u32 {
    let Context { scene, view, settings, strategy, .. } = context;
    if asked.is_some() {
        return settings.light_samples;
    }
    let is_sampled = settings.light_sampling != LightSampling::Bsdf
        && settings.max_depth > 0
        && strategy.is_none()
        && !scene.emitters.is_empty();
    // Scenes with expensive rays are not probed.
    if is_sampled && is_cheap(scene, view) {
        cheapest(context, sharing, |light_samples| settings.with_light_samples(light_samples))
    } else {
        1
    }
}

/// The number of light samples under a uniform sky. There the BSDF-sampled direction of a path and the cosine-weighted
/// directions of n light samples are n + 1 samples of the same light. `settings` are those without regard to the sky.
pub(super) fn decide_under_uniform_sky(
    context: Context<'_>,
    settings: Settings,
    sharing: Sharing,
    asked: Option<u32>,
) -> u32 {
    let Context { scene, view, strategy, .. } = context;
    if strategy.is_some() || settings.max_depth == 0 {
        return 0;
    }
    if asked.is_some() {
        return settings.light_samples;
    }
    if !is_cheap(scene, view) {
        return 0;
    }
    cheapest(context, sharing, |samples| settings.under(Sky::Uniform, samples - 1)) - 1
}

/// The number of samples of direct light with the least noise times time; a smaller number if its cost is nearly the same.
fn cheapest(context: Context<'_>, sharing: Sharing, with: impl Fn(u32) -> Settings) -> u32 {
    let modes = [1, MEASURED].map(|samples| Context { settings: with(samples), ..context });
    let mut run = PilotRun::new(&modes, PIXELS);
    let mut number = 1;
    for offset in OFFSETS {
        run.trace(offset);
        let noises = run.noises();
        // The picture has no noise, or no light is sampled.
        if noises[0] <= 0.0 || run.rays(1) <= run.rays(0) {
            return 1;
        }
        let further = (run.rays(1) / run.rays(0) - 1.0) / f64::from(MEASURED - 1);
        let costs = costs(noises[1] / noises[0], further, sharing);
        number = smallest(&costs);
        let several = costs.iter().skip(1).map(|cost| cost.0 / costs[0].0).fold(f64::INFINITY, f64::min);
        if !DOUBT.contains(&several) || noises[1] > UNCHANGED * noises[0] {
            break;
        }
    }
    number
}

/// Cost (noise times time, relative to one light sample and separate paths) of each number of light samples. `noise` is the
/// noise with [`MEASURED`] light samples relative to the noise with one. `further` is the number of shadow rays that one more
/// light sample adds, relative to all rays of a path. Both are measured without shared paths.
fn costs(noise: f64, further: f64, sharing: Sharing) -> [(f64, u32); NUMBERS.len()] {
    let measured = f64::from(MEASURED);
    let falls = ((1.0 - noise) * measured / (measured - 1.0)).clamp(0.0, sharing.noise);
    let stays = sharing.noise - falls;
    NUMBERS.map(|number| {
        let n = f64::from(number);
        ((stays + falls / n) * (sharing.time + LIGHT_SAMPLE_COST * further * (n - 1.0)), number)
    })
}

/// The smallest number whose cost is near the least.
fn smallest(costs: &[(f64, u32)]) -> u32 {
    let least = costs.iter().map(|cost| cost.0).fold(f64::INFINITY, f64::min);
    costs.iter().find(|cost| cost.0 <= SMALLEST * least).map_or(1, |cost| cost.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn best(noise: f64, further: f64) -> u32 {
        smallest(&costs(noise, further, Sharing::NONE))
    }

    #[test]
    fn the_number_follows_noise_and_rays() {
        // Shadow rays that cost nothing, and noise from light samples alone: the largest number.
        assert_eq!(best(0.25, 0.0), 8);
        // The optimum, sqrt(falls / stays / c), is 6; the cost of 4 is within 5 % of it.
        assert_eq!(best(0.35, 0.22), 4);
        assert_eq!(best(0.6, 0.2), 2);
        assert_eq!(best(0.9, 0.2), 1);
        // More light samples have more noise: one.
        assert_eq!(best(1.3, 0.2), 1);
        let costs = costs(0.25, 0.2, Sharing::NONE);
        assert!((costs[0].0 - 1.0).abs() < 1e-12 && (costs[1].0 - 0.5 * 1.15).abs() < 1e-12);
    }

    #[test]
    fn shared_paths_leave_the_noise_of_lights() {
        let sharing = Sharing { size: 16, noise: 0.5, time: 1.6 };
        assert_eq!(best(0.7, 0.25), 2);
        assert_eq!(smallest(&costs(0.7, 0.25, sharing)), 4);
    }
}
