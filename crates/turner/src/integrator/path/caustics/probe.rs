//! The pilot run for caustics: how much light and noise light paths account for, and what they cost. A few light paths
//! and camera paths with fixed seeds measure both, so the result is the same on every run.

use super::arrivals::{Arrival, Arrivals, FEW, STRATIFIED};
use super::photons::Photon;
use super::pilot::{PilotRun, UNKNOWN, cell_at};
use super::pilot_light::PilotLight;
use super::strategy::CausticsStrategy;
use crate::integrator::path::Context;
use crate::math::DVec2;

/// Number of light paths, and of additional ones if those leave any doubt.
const PATHS: u32 = 2048;
const MORE: u32 = 6 * PATHS;

/// Minimum fraction of the image's light for caustics to count.
const MIN_FRACTION: f64 = 1e-3;

/// Maximum cost for the same noise, relative to no light paths, at which light paths pay. The estimate is right within a
/// factor of 1.5 or so, and where nothing is gained nothing should be lost.
const MAX_COST: f64 = 0.6;

/// The results are certain enough if at least this many light paths of equal contribution have found the light. Where a
/// few bright ones have, most of a picture's pixels get nothing.
const CERTAIN: f64 = 50.0;

/// Photons are used only for at least this fraction of the image's light, and if the camera paths of the pilot run miss
/// at least this part of it.
const MIN_BY_PHOTONS: f64 = 2e-3;
const MIN_MISSED: f64 = 0.5;

/// Numbers of light paths per camera path that are considered.
const RATIOS: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0];

/// Cost of the start of a light path, of its ray and of a scattering event on it, in rays of camera paths with their
/// shading. Measured; right within a factor of 1.5.
const START_COST: f64 = 0.5;
const RAY_COST: f64 = 1.0;
const SCATTERING_COST: f64 = 2.2;

/// Cost of the reverse densities of a camera path, whose glossy and textured surfaces then are shaded by scalar code,
/// relative to the path. Measured: 0.1 to 0.9.
const REVERSE_COST: f64 = 0.3;

/// Further cost of a scattering event on a thin film, whose interference colours are expensive. Right within a factor of
/// about 2; measured with mirrors with thin films and with IridescenceSuzanne of glTF's sample models.
const FILM_COST: f64 = 6.0;

/// The result.
pub(super) struct ProbeResult {
    /// Best number of light paths per camera path, without photons and with them.
    pub(super) ratio: f64,
    pub(super) ratio_with_photons: f64,
    /// Whether light paths pay.
    pub(super) pays: bool,
    /// Cost for the same noise relative to no light paths; `None` where only light paths find some of the light.
    pub(super) gain: Option<f64>,
    /// Cost of a light path, in camera paths with their shading.
    pub(super) price: f64,
    /// Fractions of the image's light: what light paths contribute, what only they find, what photons contribute.
    pub(super) contribution: f64,
    pub(super) light_paths_only: f64,
    pub(super) by_photons: f64,
    /// Whether photons pay.
    pub(super) photons_pay: bool,
    /// For each caustic target, the weight with which to choose it.
    pub(super) groups: Vec<f64>,
}

/// Cost of a light path in rays of camera paths, when targets are chosen by these weights: paths to targets that matter may
/// be longer than most.
fn price_of(context: Context<'_>, strategy: &CausticsStrategy, groups: &[f64]) -> f64 {
    let mut strategy = strategy.clone();
    let _ = strategy.caustic_targets.choose_by(groups);
    let light = PilotLight::trace(context, &strategy, u64::MAX / 4, PATHS);
    let (rays, n) = (light.rays as f64, f64::from(PATHS));
    let scatterings = SCATTERING_COST * light.scatterings as f64 + FILM_COST * light.films as f64;
    START_COST + (RAY_COST * rays + scatterings) / n
}

/// Measures a strategy that has as many light paths as pixels.
pub(super) fn probe(context: Context<'_>, strategy: &CausticsStrategy) -> ProbeResult {
    let view = context.view;
    let pixels = f64::from(view.film.width) * f64::from(view.film.height);
    let size = DVec2::new(f64::from(view.film.width), f64::from(view.film.height));
    let mut arrivals = Arrivals { paths_of_strategy: strategy.paths as f64, ..Arrivals::default() };
    // Indices that no render reaches.
    let mut first = u64::MAX / 2;
    let mut photons = Vec::new();
    let mut trace = |count: u32, arrivals: &mut Arrivals| {
        arrivals.paths += f64::from(count);
        let light = PilotLight::trace(context, strategy, first, count);
        for (splat, weight, group) in light.splats {
            let light = f64::from(splat.color.luminance());
            if light > 0.0 && light.is_finite() {
                let cell = cell_at(splat.place / size);
                arrivals.list.push(Arrival { light, weight, cell, group });
            }
        }
        photons.extend(light.photons);
        first += u64::from(count);
    };
    trace(PATHS, &mut arrivals);
    let mut pilot = PilotRun::new(context, Some(strategy)).with_light(arrivals.usual_light(pixels));
    // Stop if there is little light, and little noise from it even if a rare bright path was missed.
    let is_little = arrivals.light(pixels) < MIN_FRACTION * pilot.mean.max(1e-30)
        && arrivals.noise_without(&pilot, pixels) < 0.01 * pilot.variance;
    if !is_little {
        trace(MORE, &mut arrivals);
        pilot = pilot.with_light(arrivals.usual_light(pixels));
    }
    let groups: Vec<f64> = (0u32..)
        .zip(arrivals.noise_of_groups(&pilot, strategy.caustic_targets.len()))
        .map(|(g, m)| (m * strategy.caustic_targets.probability(g)).sqrt())
        .collect();
    let price = price_of(context, strategy, &groups) / pilot.rays.max(1.0);
    let of_image = |light: f64| light / pilot.mean.max(1e-30);
    let light_paths_only = of_image(arrivals.light_paths_only(pixels));
    // Light of near-specular lobes is found by other strategies too, and is no reason for photons.
    photons.retain(|photon: &Photon| photon.by_delta);
    let photons = pilot.photons(context, strategy, photons, arrivals.paths);
    let noise = arrivals.noise(&pilot);
    // Squared error times time per sample.
    let cost = |ratio: f64, photon_variance: f64| {
        let paths = strategy.paths as f64 / pixels;
        let light = noise.error(pixels, ratio) + photon_variance * paths / ratio;
        (STRATIFIED * pilot.variance + light) * (1.0 + REVERSE_COST + price * ratio)
    };
    let best = |photon_variance: f64| {
        let costs = RATIOS.map(|ratio| (cost(ratio, photon_variance), ratio));
        costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((1.0, 1.0))
    };
    let ((least, ratio), (least_with_photons, ratio_with_photons)) = (best(0.0), best(photons.variance));
    let seen = || {
        let without = PilotRun::new(context, None).with_light(arrivals.usual_light(pixels));
        (without.variance - pilot.variance).max(0.0)
    };
    let mut of_camera = arrivals.error_without(&pilot, pixels, UNKNOWN, seen);
    if view.film.removes_fireflies() {
        // What is rare is removed: its light is missing, but does not make noise.
        of_camera = of_camera.min(arrivals.error_if_missing(&pilot, pixels));
    }
    let without = STRATIFIED * pilot.variance + of_camera;
    let gain = least / without;
    let are_certain = arrivals.effective(&pilot) > CERTAIN;
    let pays = light_paths_only > MIN_FRACTION || gain < MAX_COST && are_certain;
    // Light that only photons find is missing in all pixels, at best evenly.
    let missing = photons.missed * photons.light;
    let photons_alone_pay = least_with_photons < MAX_COST * (without + FEW * missing * missing);
    let photons_pay = photons.light > MIN_BY_PHOTONS
        && photons.missed > MIN_MISSED
        && photons.effective > CERTAIN
        && (pays || photons_alone_pay);
    ProbeResult {
        ratio,
        ratio_with_photons,
        pays,
        gain: (light_paths_only <= MIN_FRACTION).then_some(gain),
        price,
        contribution: of_image(arrivals.light(pixels)),
        light_paths_only,
        by_photons: photons.light,
        photons_pay,
        groups,
    }
}
