//! The work of a pass: the missing samples of each tile, and the missing light paths.
//!
//! A film knows for each tile the set of its sample indices, and for the picture the set of its light paths. A
//! pass traces (requested) minus (held). So passes may overlap, be cancelled, or run on other machines, and every
//! sample counts once. Light paths reach all pixels, not one tile; those of a sample index are traced with tile
//! 0. Ranges that cover each tile and index once therefore cover each light path once.

use std::ops::Range;

use crate::film::{Film, Half};

/// A set of tiles of a film, by index: row by row from the top left ([`crate::film::TileGrid`]).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum TileSet {
    /// All tiles.
    #[default]
    All,
    /// These tiles. Indices out of range and duplicates are ignored.
    Some(Vec<u32>),
}

impl TileSet {
    /// The indices below `count`, in ascending order.
    fn indices(&self, count: usize) -> Vec<usize> {
        match self {
            TileSet::All => (0..count).collect(),
            TileSet::Some(tiles) => {
                let mut indices: Vec<usize> =
                    tiles.iter().map(|t| *t as usize).filter(|t| *t < count).collect();
                indices.sort_unstable();
                indices.dedup();
                indices
            }
        }
    }
}

/// A range of sample indices over a set of tiles. The light paths of a sample index belong to tile 0, so ranges
/// that cover each sample of each tile once also cover each light path once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassRange {
    /// Sample indices. Those beyond the samples per pixel are ignored.
    pub samples: Range<u32>,
    /// Tiles.
    pub tiles: TileSet,
}

impl PassRange {
    /// A range of sample indices over all tiles.
    pub fn all_tiles(samples: Range<u32>) -> PassRange {
        PassRange { samples, tiles: TileSet::All }
    }
}

/// The part of a [`PassRange`] that a film does not hold.
pub(super) struct Schedule {
    pub(super) samples: Range<u32>,
    /// In ascending order.
    tiles: Vec<usize>,
    light_paths: u64,
    /// One more than the last sample index whose light paths are traced.
    light_end: u32,
}

impl Schedule {
    pub(super) fn new(range: &PassRange, film: &Film) -> Schedule {
        let all = film.index_goal();
        let samples = range.samples.start.min(all)..range.samples.end.min(all);
        Schedule {
            samples,
            tiles: range.tiles.indices(film.tiles().count()),
            light_paths: film.identity().light_paths,
            light_end: if film.identity().adaptive { film.mean_goal() } else { all },
        }
    }

    /// For each tile the indices in `samples` that it lacks; complete tiles are omitted. Where the halves of a tile lack
    /// different samples, each is a task.
    pub(super) fn tiles(&self, film: &Film, samples: &Range<u32>) -> Vec<TileTask> {
        let missing = |tile: usize, half: Half| {
            let end = u64::from(samples.end).min(film.goal(tile, half));
            film.held_half(tile, half).missing(u64::from(samples.start)..end)
        };
        let mut tasks = Vec::new();
        for &tile in &self.tiles {
            let [even, odd] = Half::BOTH.map(|half| missing(tile, half));
            if even == odd {
                tasks.push(TileTask { tile, half: None, missing: even });
            } else {
                tasks.push(TileTask { tile, half: Some(Half::Even), missing: even });
                tasks.push(TileTask { tile, half: Some(Half::Odd), missing: odd });
            }
        }
        tasks.retain(|task| !task.missing.is_empty());
        tasks
    }

    /// The total number of missing samples, summed over tiles.
    pub(super) fn missing(&self, film: &Film) -> usize {
        let count = |task: &TileTask| task.missing.iter().map(|r| (r.end - r.start) as usize).sum::<usize>();
        self.tiles(film, &self.samples).iter().map(count).sum()
    }

    /// The light paths of a range of sample indices.
    pub(super) fn light(&self, samples: &Range<u32>) -> Range<u64> {
        self.light_paths * u64::from(samples.start)..self.light_paths * u64::from(samples.end)
    }

    /// The light paths of `samples` that the film lacks and that belong to this pass.
    pub(super) fn missing_light(&self, film: &Film, samples: &Range<u32>) -> Vec<Range<u64>> {
        match film.splats() {
            Some(splats) if self.tiles.first() == Some(&0) => {
                let end = samples.end.min(self.light_end).max(samples.start);
                splats.held().missing(self.light(&(samples.start..end)))
            }
            _ => Vec::new(),
        }
    }
}

/// A tile and the samples to trace.
pub(super) struct TileTask {
    pub(super) tile: usize,
    /// One half of its pixels; `None` for all of them.
    pub(super) half: Option<Half>,
    pub(super) missing: Vec<Range<u64>>,
}
