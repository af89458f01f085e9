//! What a pass does: which samples of which tiles, and which light paths.

use std::ops::Range;

use crate::film::Film;

/// Tiles of a film, by number: row by row from the top left ([`crate::film::TileGrid`]).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum TileSet {
    /// All.
    #[default]
    All,
    /// These; numbers beyond the film's tiles and repeated ones count for nothing.
    Some(Vec<u32>),
}

impl TileSet {
    /// The numbers below `count`, in rising order.
    fn numbers(&self, count: usize) -> Vec<usize> {
        match self {
            TileSet::All => (0..count).collect(),
            TileSet::Some(tiles) => {
                let mut numbers: Vec<usize> =
                    tiles.iter().map(|t| *t as usize).filter(|t| *t < count).collect();
                numbers.sort_unstable();
                numbers.dedup();
                numbers
            }
        }
    }
}

/// Samples of tiles. Light paths of a sample number belong to tile 0, so ranges that cover each sample of each tile once cover
/// each light path once, too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassRange {
    /// Sample numbers; those beyond the picture's samples count for nothing.
    pub samples: Range<u32>,
    /// Tiles.
    pub tiles: TileSet,
}

impl PassRange {
    /// Sample numbers of all tiles.
    pub fn all_tiles(samples: Range<u32>) -> PassRange {
        PassRange { samples, tiles: TileSet::All }
    }
}

/// What of a [`PassRange`] a film does not hold yet.
pub(super) struct Schedule {
    pub(super) samples: Range<u32>,
    /// In rising order.
    tiles: Vec<usize>,
    light_paths: u64,
}

impl Schedule {
    pub(super) fn new(range: &PassRange, film: &Film) -> Schedule {
        let all = film.identity().samples;
        let samples = range.samples.start.min(all)..range.samples.end.min(all);
        Schedule {
            samples,
            tiles: range.tiles.numbers(film.tiles().count()),
            light_paths: film.identity().light_paths,
        }
    }

    /// The samples that each tile lacks, of the numbers asked for; tiles that lack none are left out.
    pub(super) fn tiles(&self, film: &Film, samples: &Range<u32>) -> Vec<TileTask> {
        let asked = u64::from(samples.start)..u64::from(samples.end);
        let tasks =
            self.tiles.iter().map(|&tile| TileTask { tile, missing: film.held(tile).missing(asked.clone()) });
        tasks.filter(|task| !task.missing.is_empty()).collect()
    }

    /// How many samples tiles lack in all.
    pub(super) fn missing(&self, film: &Film) -> usize {
        let count = |task: &TileTask| task.missing.iter().map(|r| (r.end - r.start) as usize).sum::<usize>();
        self.tiles(film, &self.samples).iter().map(count).sum()
    }

    /// Numbers of the light paths that go with samples.
    pub(super) fn light(&self, samples: &Range<u32>) -> Range<u64> {
        self.light_paths * u64::from(samples.start)..self.light_paths * u64::from(samples.end)
    }

    /// Those of them that the film lacks and that this pass is to bring.
    pub(super) fn missing_light(&self, film: &Film, samples: &Range<u32>) -> Vec<Range<u64>> {
        match film.splats() {
            Some(splats) if self.tiles.first() == Some(&0) => splats.held().missing(self.light(samples)),
            _ => Vec::new(),
        }
    }
}

/// A tile and the samples to be traced for it.
pub(super) struct TileTask {
    pub(super) tile: usize,
    pub(super) missing: Vec<Range<u64>>,
}
