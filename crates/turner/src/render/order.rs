//! In which order tiles are handed to threads.

use std::cmp::Reverse;

/// What tiles cost in the last pass. The picture does not depend on it: sums are exact.
pub(super) struct TileOrder {
    /// Rays, by the number of the tile.
    costs: Vec<u64>,
}

impl TileOrder {
    /// Of tiles of which nothing is known.
    pub(super) fn new(tiles: usize) -> TileOrder {
        TileOrder { costs: vec![0; tiles] }
    }

    pub(super) fn costs(&self) -> &[u64] {
        &self.costs
    }

    /// What the last pass found.
    pub(super) fn set_costs(&mut self, costs: impl Iterator<Item = u64>) {
        self.costs.clear();
        self.costs.extend(costs);
    }

    /// The numbers of the tiles, the dearest first; equally dear ones row by row.
    pub(super) fn dearest_first(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.costs.len()).collect();
        order.sort_by_key(|&tile| Reverse(self.costs[tile]));
        order
    }
}
