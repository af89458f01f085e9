//! Ray trees of the classic integrator: their size, and how many rays the limits cut.

use super::grid::Pixel;
use super::{Options, threads};
use crate::doctor::subject::Subject;
use crate::integrator::classic::{CutReason, RayEnd, RayKind, replay_at};
use crate::view::place_of;

/// Statistics of the ray trees of all pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TreeFacts {
    /// Number of ray trees.
    pub(super) samples: u64,
    /// Number of rays without shadow rays, and of shadow rays.
    pub(super) rays: u64,
    pub(super) shadow_rays: u64,
    /// Number of rays cut by the depth limit, and of rays dropped by the limit on the number of rays.
    pub(super) cut: u64,
    pub(super) dropped: u64,
    /// Maximum depth.
    pub(super) depth: u32,
}

/// Traces one sample of each pixel.
pub(super) fn of(scene: &Subject, pixels: &[Pixel], options: &Options<'_>) -> TreeFacts {
    let one = |pixel: &Pixel| {
        let id = pixel.sample(scene, 0);
        let mut f = TreeFacts { samples: 1, ..TreeFacts::default() };
        let Ok(tree) = replay_at(&scene.prepared, id, place_of(&scene.prepared.view, &id)) else { return f };
        f.rays = tree.rays.len() as u64 + tree.unwritten;
        f.dropped = tree.dropped;
        for ray in &tree.rays {
            f.depth = f.depth.max(ray.depth);
            debug_assert!(ray.depth > 0 || ray.kind == RayKind::Camera);
            let RayEnd::Hit(hit) = &ray.end else { continue };
            f.shadow_rays += hit.lights.len() as u64;
            f.cut +=
                hit.cut.iter().filter(|c| c.reason == CutReason::Depth && c.weight > 1e-3).count() as u64;
        }
        f
    };
    let all = threads::map(pixels, options.threads, &|| false, one);
    all.into_iter().flatten().fold(TreeFacts::default(), |a, b| TreeFacts {
        samples: a.samples + b.samples,
        rays: a.rays + b.rays,
        shadow_rays: a.shadow_rays + b.shadow_rays,
        cut: a.cut + b.cut,
        dropped: a.dropped + b.dropped,
        depth: a.depth.max(b.depth),
    })
}
