//! Whether neighbours' paths make up for the shadow rays that join them: measured by a few paths, the same on every run.

use super::{CELL, Reuse, group};
use crate::integrator::path::record::Off;
use crate::integrator::path::settings::Settings;
use crate::integrator::path::wave::Wave;
use crate::integrator::path::{PathDesc, PathReuse};
use crate::integrator::{CameraSamples, RayStats, Tracer};
use crate::render::{place_of, take_points};
use crate::sampler::SampleId;
use crate::scene::Scene;

/// Groups that are looked at, along the picture's width and height.
const SIDE: u32 = 8;

/// What a shadow ray between neighbours takes, in rays of paths with all that belongs to them: measured.
const PRICE: f64 = 0.45;

/// Where it is dark, errors count by the mean luminance: by so much of its square.
const DARK: f64 = 0.1;

/// How much of the work for the same noise may be left.
const GAIN: f64 = 0.95;

/// Samples of pixels, two of each, with the rays they took.
struct Look {
    luminance: Vec<[f64; 2]>,
    rays: f64,
}

/// Whether a scene's pixels use one another's paths.
pub(crate) fn pays(scene: &Scene, desc: &PathDesc) -> bool {
    let settings = Settings::path(desc);
    if !settings.reuse || !Reuse::suits(scene) {
        return false;
    }
    if desc.reuse == PathReuse::Always {
        return true;
    }
    let (alone, together) = (Look::new(scene, settings, false), Look::new(scene, settings, true));
    let means =
        || alone.luminance.iter().zip(&together.luminance).map(|(a, b)| (a[0] + a[1] + b[0] + b[1]) / 4.0);
    let count = alone.luminance.len().max(1) as f64;
    let mean = means().sum::<f64>() / count;
    let dark = DARK * mean * mean;
    let noise = |look: &Look| -> f64 {
        look.luminance
            .iter()
            .zip(means())
            .map(|([a, b], mean)| (a - b) * (a - b) / (mean * mean + dark))
            .sum()
    };
    let joined = (together.rays - alone.rays).max(0.0) / alone.rays;
    noise(&together) * (1.0 + PRICE * joined) < GAIN * noise(&alone)
}

impl Look {
    fn new(scene: &Scene, settings: Settings, together: bool) -> Look {
        let film = &scene.film;
        let mut wave = Wave::new(settings, scene, Off);
        wave.reuse = Reuse::new(together);
        let mut look = Look { luminance: Vec::new(), rays: 0.0 };
        for cell in 0..SIDE * SIDE {
            let (column, row) = (cell % SIDE, cell / SIDE);
            let corner = |n: u32, size: u32| {
                let at = (u64::from(size) * (2 * u64::from(n) + 1) / u64::from(2 * SIDE)) as u32;
                at - at % CELL
            };
            let (x, y) = (corner(column, film.width), corner(row, film.height));
            let [first, second] = [0x51de, 0x9e37_79b9].map(|seed| {
                let id = SampleId { x, y, index: 0, seed };
                let mut samples = CameraSamples::default();
                let points = group(scene, id).map(|id| (id, place_of(scene, &id).into()));
                take_points(scene, &mut samples, points);
                let (mut out, mut stats) = (Vec::new(), RayStats::default());
                wave.radiance(&samples, &mut out, &mut stats);
                look.rays += stats.total() as f64;
                let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
                out.iter().map(|r| finite(f64::from(r.color.luminance()))).collect::<Vec<f64>>()
            });
            look.luminance.extend(first.into_iter().zip(second).map(|(a, b)| [a, b]));
        }
        look
    }
}
