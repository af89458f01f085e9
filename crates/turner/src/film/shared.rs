//! A film that several threads add to.

use std::ops::Range;
use std::sync::Mutex;

use super::band::Band;
use super::{Film, Half, NonFinite, PixelRect, SampleSet, Splat, Splats, TILE, TileGrid, TileSums};
use crate::color::Spectrum;
use crate::filter::Filter;

/// A film that several threads add to. Threads in different rows of tiles do not wait for each other. A lock is
/// taken once per tile or batch of light paths, never per sample.
pub struct SharedFilm<'a> {
    pub(super) grid: TileGrid,
    bands: Vec<Mutex<&'a mut Band>>,
    splats: Option<Mutex<&'a mut Splats>>,
}

impl Film {
    /// Shares the film among threads.
    pub fn share(&mut self) -> SharedFilm<'_> {
        SharedFilm {
            grid: self.tiles(),
            bands: self.bands.iter_mut().map(Mutex::new).collect(),
            splats: self.splats.as_mut().map(Mutex::new),
        }
    }
}

impl SharedFilm<'_> {
    /// Calls `work` with the band of a tile, the tile's column and its pixels.
    pub(super) fn in_band<T>(&self, tile: usize, work: impl FnOnce(&mut Band, usize, PixelRect) -> T) -> T {
        let (row, column) = (tile / self.grid.columns(), tile % self.grid.columns());
        let mut band = self.bands[row].lock().unwrap_or_else(|e| e.into_inner());
        let rect = band.tile(column);
        work(&mut band, column, rect)
    }

    /// Adds the sums of these samples to a tile, or to one half of it in an adaptive film, and to the border that their
    /// filter reaches. `rays` is the number of rays that were traced for samples with an index above 0. Returns false, and adds nothing, if the tile already holds one of them.
    pub fn deposit_sums(
        &self,
        (tile, half): (usize, Option<Half>),
        sums: &TileSums,
        samples: &SampleSet,
        non_finite: &NonFinite,
        rays: u64,
    ) -> bool {
        let added = self.in_band(tile, |band, column, _| {
            let added = band.record(column, half, samples, non_finite);
            if added {
                if let Some(adaptive) = band.adaptive.get_mut(column) {
                    adaptive.rays += rays;
                }
                band.add_sums(sums);
            }
            added
        });
        if added {
            let (own, top) = (tile / self.grid.columns(), self.grid.rect(0).y);
            let PixelRect { y, height, .. } = sums.rect();
            let (first, last) =
                (y.saturating_sub(top) / TILE, (y + height).saturating_sub(top).div_ceil(TILE));
            let reached = self.bands.iter().enumerate().take(last as usize).skip(first as usize);
            for (_, band) in reached.filter(|(row, _)| *row != own) {
                band.lock().unwrap_or_else(|e| e.into_inner()).add_sums(sums);
            }
        }
        added
    }

    /// Adds the sample with index 0 (colour times coverage, and coverage) to each pixel of a tile, row by row.
    /// Returns false, and adds nothing, if the tile already holds it.
    pub fn deposit_samples(
        &self,
        tile: usize,
        samples: impl Iterator<Item = (Spectrum, f32)> + Clone,
        non_finite: &NonFinite,
    ) -> bool {
        let mut first = SampleSet::default();
        first.insert(0..1);
        self.in_band(tile, |band, column, rect| {
            let added = band.record(column, None, &first, non_finite);
            if added {
                band.add_samples(&rect, samples);
            }
            added
        })
    }

    /// Adds the splats of these light paths. Returns false, and adds nothing, if the film already holds one of
    /// the paths or was not prepared by [`Film::take_light`].
    pub fn deposit_light(&self, filter: &Filter, paths: Range<u64>, splats: &[Splat]) -> bool {
        self.splats
            .as_ref()
            .is_some_and(|own| own.lock().unwrap_or_else(|e| e.into_inner()).add(filter, paths, splats))
    }
}
