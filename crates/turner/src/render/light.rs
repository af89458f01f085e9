//! Light paths of a pass, in batches.
//!
//! Light paths of a sample index are numbered `light_paths * index ..`; the film keeps the set of those that it
//! holds.

use std::ops::Range;

use super::work::Stop;
use crate::film::{SharedFilm, Splat};
use crate::filter::Filter;
use crate::integrator::{LightTracer, Photon, Prepared, RayStats};

/// Light paths per batch: enough to fill SIMD blocks and to lock the film rarely.
const BATCH: u64 = 4096;

/// Light paths between two checks for a cancel, where no photons are stored.
const SLICE: u64 = 512;

/// Ranges of light paths, divided into batches.
pub(super) struct LightTasks {
    /// For each range, the number of batches before it.
    ranges: Vec<(usize, Range<u64>)>,
    batches: usize,
}

impl LightTasks {
    pub(super) fn new(ranges: Vec<Range<u64>>) -> LightTasks {
        let mut batches = 0;
        let mut counted = Vec::with_capacity(ranges.len());
        for range in ranges {
            let count = (range.end - range.start).div_ceil(BATCH) as usize;
            counted.push((batches, range));
            batches += count;
        }
        LightTasks { ranges: counted, batches }
    }

    /// Number of batches.
    pub(super) fn len(&self) -> usize {
        self.batches
    }

    /// The light paths of a batch.
    pub(super) fn get(&self, batch: usize) -> Option<Range<u64>> {
        let of = self.ranges.partition_point(|(before, _)| *before <= batch).checked_sub(1)?;
        let (before, range) = self.ranges.get(of)?;
        let begin = range.start + BATCH * (batch - before) as u64;
        (begin < range.end).then_some(begin..range.end.min(begin + BATCH))
    }
}

/// A worker's state for light paths, reused from batch to batch.
pub(super) struct LightBuffers<'a> {
    tracer: Option<Box<dyn LightTracer + 'a>>,
    filter: Filter,
    splats: Vec<Splat>,
    pub(super) stats: RayStats,
}

impl<'a> LightBuffers<'a> {
    pub(super) fn new(p: &'a Prepared) -> LightBuffers<'a> {
        LightBuffers {
            tracer: p.integrator.light_tracer(&p.scene, &p.view),
            filter: p.view.film.filter(),
            splats: Vec::new(),
            stats: RayStats::default(),
        }
    }

    /// Returns false if it was stopped.
    fn trace(&mut self, paths: &Range<u64>, stop: Stop<'_>) -> bool {
        self.splats.clear();
        let stop = || stop.is_set();
        let tracer = self.tracer.as_mut();
        tracer.is_none_or(|t| t.trace(paths.clone(), &stop, &mut self.splats, &mut self.stats))
    }

    /// Traces light paths and adds their splats to the film, slice by slice. Returns false if it was stopped.
    pub(super) fn render(&mut self, mut paths: Range<u64>, film: &SharedFilm<'_>, stop: Stop<'_>) -> bool {
        while !paths.is_empty() {
            let slice = paths.start..paths.end.min(paths.start + SLICE);
            paths.start = slice.end;
            if !self.trace(&slice, stop) {
                return false;
            }
            film.deposit_light(&self.filter, slice, &self.splats);
        }
        true
    }

    /// Traces one batch without slices, because photons must be in the order of the light paths, and returns its
    /// photons; `None` if it was stopped. Only the splats of the light paths in `missing` are added to the film.
    pub(super) fn photons(
        &mut self,
        paths: &Range<u64>,
        missing: &[Range<u64>],
        film: &SharedFilm<'_>,
        stop: Stop<'_>,
    ) -> Option<Vec<Photon>> {
        if missing != [paths.clone()] {
            // The film already holds some of these light paths: trace the others separately for their splats.
            missing.iter().for_each(|part| _ = self.render(part.clone(), film, stop));
        }
        if !self.trace(paths, stop) {
            return None;
        }
        if missing == [paths.clone()] {
            film.deposit_light(&self.filter, paths.clone(), &self.splats);
        }
        self.tracer.as_mut().map(|tracer| std::mem::take(tracer.photons()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_the_light_paths() {
        let ranges = vec![5..6, 10_000..10_000 + 2 * BATCH, 50_000..50_000 + BATCH + 1];
        let tasks = LightTasks::new(ranges.clone());
        assert_eq!((tasks.len(), tasks.get(5), LightTasks::new(Vec::new()).get(0)), (5, None, None));
        let batches = (0..5).map(|i| tasks.get(i).unwrap());
        assert!(batches.clone().all(|b| b.end - b.start <= BATCH));
        assert!(batches.flatten().eq(ranges.into_iter().flatten()));
    }
}
