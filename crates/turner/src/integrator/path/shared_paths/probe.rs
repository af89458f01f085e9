//! The pilot run for shared paths: whether they reduce noise enough to pay for their shadow rays.

use super::{CLUSTER, SharedPaths};
use crate::integrator::path::pilot_run::{OFFSETS, PilotRun};
use crate::integrator::path::{CausticsStrategy, Context, PathDesc, SharedPathsMode};
use crate::integrator::probing::is_cheap;

/// Numbers of pixels that may share paths.
const SIZES: [u32; 3] = [4, 8, CLUSTER as u32];

/// Cost of a shadow ray that joins two paths, in rays of paths with their shading: measured 0.1 to 0.43. Cost of sharing a
/// path, without those rays, relative to the path: 0.05 to 0.35.
const SHADOW_RAY_COST: f64 = 0.33;
const SHARING_COST: f64 = 0.14;

/// Maximum cost for the same noise, relative to separate paths. Costs near this limit were measured within a quarter of the
/// estimate; where sharing gains much, they were up to half as much again.
const MAX_COST: f64 = 0.97;

/// Costs that are in doubt: more clusters are traced.
const DOUBT: std::ops::Range<f64> = 0.85..1.15;

/// Paths that are shared, or not.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator::path) struct Sharing {
    /// Number of pixels that share paths; 1 if they do not.
    pub(in crate::integrator::path) size: u32,
    /// Noise and time, relative to separate paths.
    pub(in crate::integrator::path) noise: f64,
    pub(in crate::integrator::path) time: f64,
}

impl Sharing {
    /// Separate paths.
    pub(in crate::integrator::path) const NONE: Sharing = Sharing { size: 1, noise: 1.0, time: 1.0 };

    /// Cost for the same noise, relative to separate paths.
    fn cost(&self) -> f64 {
        self.noise * self.time
    }
}

/// Decides whether paths are shared, and among how many pixels. If that gains more than optional light paths, it replaces
/// them. Returns the remaining light paths, and how paths are shared.
pub(in crate::integrator::path) fn decide(
    context: Context<'_>,
    desc: &PathDesc,
    strategy: Option<CausticsStrategy>,
) -> (Option<CausticsStrategy>, Sharing) {
    let Context { scene, view, settings, .. } = context;
    if !settings.shared_paths {
        return (strategy, Sharing::NONE);
    }
    let is_possible = SharedPaths::is_possible(scene, view);
    if desc.shared_paths == SharedPathsMode::Always {
        let shares_paths = is_possible && strategy.is_none();
        return (strategy, Sharing { size: if shares_paths { CLUSTER as u32 } else { 1 }, ..Sharing::NONE });
    }
    let least = strategy.as_ref().map_or(Some(MAX_COST), |strategy| strategy.gain);
    // Scenes with expensive rays are not probed.
    let Some(least) = least.filter(|_| is_possible && is_cheap(scene, view)) else {
        return (strategy, Sharing::NONE);
    };
    match cheapest(context) {
        Some(sharing) if sharing.cost() < least.min(MAX_COST) => (None, sharing),
        _ => (strategy, Sharing::NONE),
    }
}

/// Shared paths of the least cost for the same noise; `None` where there is no noise.
fn cheapest(context: Context<'_>) -> Option<Sharing> {
    let modes = [1, CLUSTER as u32].map(|cluster| Context { cluster, ..context });
    let mut run = PilotRun::new(&modes, CLUSTER as u32);
    let mut least = None;
    for offset in OFFSETS {
        run.trace(offset);
        let [separate, shared] = [0, 1].map(|mode| run.rays(mode));
        let joined = (shared - separate).max(0.0) / separate;
        let noises = run.noises();
        let (separate, shared) = (noises[0], noises[1]);
        if separate > 0.0 && joined > 0.0 {
            let sharing = SIZES.map(|size| sharing(shared / separate, joined, size));
            least = sharing.into_iter().min_by(|a, b| a.cost().total_cmp(&b.cost()));
        }
        if least.is_none_or(|least| !DOUBT.contains(&least.cost())) {
            break;
        }
    }
    least
}

/// Clusters of `size` pixels. `noise` and `joined` are those of the largest clusters, relative to separate paths: the noise,
/// and the number of rays that join paths.
fn sharing(noise: f64, joined: f64, size: u32) -> Sharing {
    let (n, most) = (f64::from(size), CLUSTER as f64);
    // The part of the noise that is shared falls to 1/n.
    let falls = ((1.0 - noise) * most / (most - 1.0)).clamp(0.0, 1.0);
    let stays = (noise - falls / most).max(0.0);
    let time = 1.0 + SHARING_COST + SHADOW_RAY_COST * joined * (n - 1.0) / (most - 1.0);
    Sharing { size, noise: stays + falls / n, time }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cheapest_size(noise: f64, joined: f64) -> (f64, u32) {
        let all = SIZES.map(|size| (sharing(noise, joined, size).cost(), size));
        all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    #[test]
    fn the_size_follows_noise_and_rays() {
        // All noise falls: to a quarter, an eighth, a sixteenth.
        for size in SIZES {
            let expected = (1.0 + SHARING_COST) / f64::from(size);
            assert!((sharing(1.0 / 16.0, 0.0, size).cost() - expected).abs() < 1e-12, "{size}");
        }
        assert_eq!(cheapest_size(0.1, 1.5).1, 16);
        assert_eq!(cheapest_size(0.4, 1.3).1, 8);
        assert_eq!(cheapest_size(0.7, 1.8).1, 4);
        // Sharing that removes no noise costs its rays, and more where it adds noise.
        assert!(cheapest_size(1.0, 1.0).0 > 1.0 && cheapest_size(1.5, 1.0).0 > 1.5);
    }
}
