//! Which cells of a grid the surface crosses, and which blocks of cells contain such cells: empty space is left in large
//! steps.

use super::lattice::Lattice;

/// Sides of blocks as powers of two, the largest first. The last are single cells.
const LEVELS: [u32; 4] = [6, 4, 2, 0];

/// A bit for each block: whether it contains a cell with corners on both sides of the surface.
#[derive(Clone, Debug)]
struct Level {
    shift: u32,
    /// Blocks along x and y.
    size: [usize; 2],
    words: Vec<u64>,
}

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct CrossedCells {
    levels: [Level; 4],
    /// The box of crossed cells: its first cell, and the one after its last; `None` if there are none.
    pub(super) range: Option<[[usize; 3]; 2]>,
}

fn blocks(cells: [usize; 3], shift: u32) -> [usize; 3] {
    cells.map(|n| ((n - 1) >> shift) + 1)
}

impl Level {
    fn new(cells: [usize; 3], shift: u32) -> Level {
        let [x, y, z] = blocks(cells, shift);
        Level { shift, size: [x, y], words: vec![0; (x * y * z).div_ceil(64)] }
    }

    fn bit(&self, cell: [usize; 3]) -> (usize, u64) {
        let [x, y, z] = cell.map(|i| i >> self.shift);
        let i = x + self.size[0] * (y + self.size[1] * z);
        (i / 64, 1 << (i % 64))
    }

    fn mark(&mut self, cell: [usize; 3]) {
        let (word, bit) = self.bit(cell);
        if let Some(word) = self.words.get_mut(word) {
            *word |= bit;
        }
    }

    fn is_crossed(&self, cell: [usize; 3]) -> bool {
        let (word, bit) = self.bit(cell);
        self.words.get(word).is_some_and(|word| word & bit != 0)
    }
}

impl CrossedCells {
    /// Bytes for a grid of cells.
    pub(super) fn bytes(cells: [usize; 3]) -> u64 {
        let bits = |shift: u32| blocks(cells, shift).iter().map(|n| *n as u64).product::<u64>();
        LEVELS.iter().map(|shift| 8 * bits(*shift).div_ceil(64)).sum()
    }

    /// Looks at the signs of all values.
    pub(super) fn new(lattice: &Lattice) -> CrossedCells {
        let [_, ny, nz] = lattice.cells;
        let mut found = CrossedCells { levels: LEVELS.map(|s| Level::new(lattice.cells, s)), range: None };
        for z in 0..nz {
            for y in 0..ny {
                let [a, b] = [lattice.row(y, z), lattice.row(y + 1, z)];
                let [c, d] = [lattice.row(y, z + 1), lattice.row(y + 1, z + 1)];
                // Values below the level among the four of each x.
                let below = a
                    .zip(b)
                    .zip(c.zip(d))
                    .map(|((a, b), (c, d))| u32::from(a) + u32::from(b) + u32::from(c) + u32::from(d));
                let mut before = None;
                for (x, count) in below.enumerate() {
                    if before.is_some_and(|before: u32| !matches!(before + count, 0 | 8)) {
                        found.mark([x - 1, y, z]);
                    }
                    before = Some(count);
                }
            }
        }
        found
    }

    fn mark(&mut self, cell: [usize; 3]) {
        self.levels.iter_mut().for_each(|level| level.mark(cell));
        let [low, high] = self.range.get_or_insert([cell, cell]);
        for axis in 0..3 {
            low[axis] = low[axis].min(cell[axis]);
            high[axis] = high[axis].max(cell[axis] + 1);
        }
    }

    /// The side, as a power of two, of the largest block around a cell that the surface does not cross; `None` if it
    /// crosses the cell.
    pub(super) fn empty_block(&self, cell: [usize; 3]) -> Option<u32> {
        self.levels.iter().find(|level| !level.is_crossed(cell)).map(|level| level.shift)
    }

    /// Bytes beyond its own size.
    pub(super) fn memory(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level.words[..])).sum()
    }
}
