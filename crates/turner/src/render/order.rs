//! The order in which threads receive tiles.

use std::cmp::Reverse;

use super::schedule::TileTask;

/// The costs of tiles in the last pass. The order does not change the picture, because sums are exact.
pub(super) struct TileOrder {
    /// Number of rays by tile index.
    costs: Vec<u64>,
}

impl TileOrder {
    /// Without known costs.
    pub(super) fn new(tiles: usize) -> TileOrder {
        TileOrder { costs: vec![0; tiles] }
    }

    pub(super) fn costs(&self) -> &[u64] {
        &self.costs
    }

    /// Sets the costs from the last pass.
    pub(super) fn set_costs(&mut self, costs: impl Iterator<Item = u64>) {
        self.costs.clear();
        self.costs.extend(costs);
    }

    /// Sorts tiles by descending cost; the sort is stable, so tiles of equal cost stay row by row.
    pub(super) fn costliest_first(&self, tasks: &mut [TileTask]) {
        tasks.sort_by_key(|task| Reverse(self.costs[task.tile]));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::color::Spectrum;
    use crate::description::{ObjectDesc, SceneDesc};
    use crate::film::Antialias;
    use crate::integrator::{IntegratorDesc, PathDesc};
    use crate::math::DVec3;
    use crate::render::{PassOptions, Renderer};
    use crate::schema::PrepareOptions;
    use crate::shape::{ShapeDesc, SphereDesc};

    /// A sphere on the right before a white background: only there light bounces.
    fn ball() -> SceneDesc {
        let mut desc = SceneDesc::default();
        (desc.film.width, desc.film.height) = (150, 100);
        (desc.film.antialias, desc.film.samples) = (Antialias::MonteCarlo, 6);
        desc.integrator = IntegratorDesc::Path(PathDesc::default());
        desc.background.color = Spectrum::WHITE;
        let ball = SphereDesc { center: DVec3::new(1.0, 0.0, 0.0), radius: 0.5 };
        desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere(ball)));
        desc
    }

    fn costliest_first(order: &TileOrder) -> Vec<usize> {
        let mut tasks: Vec<TileTask> =
            (0..order.costs.len()).map(|tile| TileTask { tile, half: None, missing: Vec::new() }).collect();
        order.costliest_first(&mut tasks);
        tasks.into_iter().map(|task| task.tile).collect()
    }

    #[test]
    fn equally_costly_tiles_come_row_by_row() {
        let mut order = TileOrder::new(4);
        assert_eq!(costliest_first(&order), [0, 1, 2, 3]);
        order.set_costs([5, 9, 5, 7].into_iter());
        assert_eq!(costliest_first(&order), [1, 3, 0, 2]);
    }

    #[test]
    fn the_second_pass_begins_with_the_costliest_tile() {
        let scene = ball().prepare(&PrepareOptions::default()).unwrap();
        let mut renderer = Renderer::new(scene.clone()).unwrap();
        let cancel = AtomicBool::new(false);
        let options = PassOptions { threads: 1, cancel: &cancel, progress: None };
        assert!(renderer.pass(1, &options).unwrap());
        let first = renderer.tile_costs().to_vec();
        assert_eq!(first.iter().sum::<u64>(), renderer.stats.total(), "every ray belongs to a tile");
        let costliest = *first.iter().max().unwrap();
        assert!(first[0] < costliest, "{first:?}");
        // A pass of more samples, stopped after two tiles: only their costs grow.
        let stop = |done: usize, _: usize| cancel.store(done == 2, Ordering::Relaxed);
        let options = PassOptions { progress: Some(&stop), ..options };
        assert!(!renderer.pass(4, &options).unwrap());
        let changed: Vec<usize> =
            (0..first.len()).filter(|&i| renderer.tile_costs()[i] > 2 * first[i]).collect();
        let mut expected = costliest_first(&TileOrder { costs: first })[..2].to_vec();
        expected.sort_unstable();
        assert_eq!(changed, expected);
    }

    #[test]
    fn the_picture_is_the_same_in_any_order() {
        let scene = ball().prepare(&PrepareOptions::default()).unwrap();
        let picture = |costs: fn(usize) -> u64, threads| {
            let mut renderer = Renderer::new(scene.clone()).unwrap();
            let cancel = AtomicBool::new(false);
            let tiles = renderer.order.costs.len();
            while !renderer.is_complete() {
                renderer.order.set_costs((0..tiles).map(costs));
                renderer.pass(2, &PassOptions { threads, cancel: &cancel, progress: None }).unwrap();
            }
            let picture = renderer.film.develop(&scene.view.film, 1).linear;
            picture.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>()
        };
        let in_rows = picture(|_| 0, 1);
        assert!(in_rows.iter().any(|p| *p != in_rows[0]), "the ball is seen");
        let orders: [fn(usize) -> u64; 3] = [|i| i as u64, |i| (i as u64 * 7919) % 31, |i| i as u64 % 2];
        for costs in orders {
            for threads in [1, 3] {
                assert!(picture(costs, threads) == in_rows);
            }
        }
    }
}
