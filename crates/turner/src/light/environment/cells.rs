//! A partition of space into cells that hold about as many points each: a complete binary k-d tree.

use turner_bvh::lanes::{Block, LANES};

use crate::math::DVec3;

/// Maximum depth.
const MOST_LEVELS: u32 = 9;

/// The tree. The children of node i are 2i + 1 and 2i + 2; the leaves, which are not stored, follow the nodes.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    nodes: Vec<Split>,
    levels: u32,
}

/// Points below `at` along the axis belong to the first child.
#[derive(Clone, Copy, Debug, Default)]
struct Split {
    axis: u32,
    at: f64,
}

impl Cells {
    /// Cells of at least `each` of these points. The points are reordered.
    pub(super) fn new(points: &mut [DVec3], each: usize) -> Cells {
        let levels = (points.len() / each.max(1)).checked_ilog2().unwrap_or(0).min(MOST_LEVELS);
        let mut cells = Cells { nodes: vec![Split::default(); (1 << levels) - 1], levels };
        cells.split(0, points);
        cells
    }

    /// Splits a node's points at the median along their longest extent.
    fn split(&mut self, node: usize, points: &mut [DVec3]) {
        if node >= self.nodes.len() || points.is_empty() {
            return;
        }
        let (low, high) =
            points.iter().fold((points[0], points[0]), |(low, high), p| (low.min(*p), high.max(*p)));
        let size = (high - low).to_array();
        let axis = if size[0] >= size[1] && size[0] >= size[2] {
            0
        } else if size[1] >= size[2] {
            1
        } else {
            2
        };
        let middle = points.len() / 2;
        let along = |p: &DVec3| p.to_array()[axis];
        points.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
        self.nodes[node] = Split { axis: axis as u32, at: along(&points[middle]) };
        let (first, second) = points.split_at_mut(middle);
        self.split(2 * node + 1, first);
        self.split(2 * node + 2, second);
    }

    /// The number of cells.
    pub(super) fn len(&self) -> usize {
        1 << self.levels
    }

    /// The cell of a point. Every point has one.
    #[inline]
    pub(super) fn of(&self, p: DVec3) -> usize {
        let p = p.to_array();
        let mut node = 0;
        for _ in 0..self.levels {
            let Split { axis, at } = self.nodes[node];
            node = 2 * node + 1 + usize::from(p[axis as usize] >= at);
        }
        node - self.nodes.len()
    }

    /// The cells of eight points, by coordinate. The steps of all points down the tree overlap.
    #[inline]
    pub(super) fn of_block(&self, p: &[Block; 3]) -> [usize; LANES] {
        let mut nodes = [0; LANES];
        for _ in 0..self.levels {
            for (lane, node) in nodes.iter_mut().enumerate() {
                let Split { axis, at } = self.nodes[*node];
                *node = 2 * *node + 1 + usize::from(p[axis as usize].0[lane] >= at);
            }
        }
        nodes.map(|node| node - self.nodes.len())
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn cells_hold_equal_numbers_of_points() {
        let mut random = Random::new(7);
        let points: Vec<DVec3> = (0..4096).map(|_| DVec3::from(random.units::<3>())).collect();
        let cells = Cells::new(&mut points.clone(), 64);
        assert_eq!(cells.len(), 64);
        let mut counts = [0; 64];
        for p in &points {
            counts[cells.of(*p)] += 1;
        }
        assert_eq!(counts, [64; 64]);
        for points in points.chunks_exact(LANES) {
            let block =
                [0, 1, 2].map(|axis| Block(std::array::from_fn(|lane| points[lane].to_array()[axis])));
            let expected: [usize; LANES] = std::array::from_fn(|lane| cells.of(points[lane]));
            assert_eq!(cells.of_block(&block), expected);
        }
    }

    #[test]
    fn few_and_equal_points() {
        assert_eq!(Cells::new(&mut [], 64).of(DVec3::ONE), 0);
        let cells = Cells::new(&mut [DVec3::ONE; 1000], 64);
        for p in [DVec3::ONE, DVec3::ZERO, DVec3::NAN, DVec3::splat(f64::INFINITY)] {
            assert!(cells.of(p) < cells.len());
        }
    }
}
