//! Passes: samples of tiles, and light paths in addition.
//!
//! ```text
//! pass ─► choose (first pass only) ─► Schedule
//!   without photons:  tiles and light paths of all sample indices in parallel
//!   with photons:     for each sample index: light paths ─► photon map ─► tiles
//! ```
//!
//! With photons, camera sample i merges with the photons of light paths of index i only. This makes the estimate
//! independent from sample to sample. A photon map must be complete before its camera samples start, so there are
//! two parallel parts per sample index.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use super::light::{LightBuffers, LightTasks};
use super::schedule::{PassRange, Schedule, TileTask};
use super::tile::TileBuffers;
use super::work::Work;
use super::{PassOptions, Renderer};
use crate::film::SampleSet;
use crate::integrator::{Photon, PhotonMap, RayStats};
use crate::schema::SceneError;

/// Time between two checks for a cancel while the integrator makes its choices.
const POLL: Duration = Duration::from_millis(2);

/// The end of another thread's work. Unlike a channel it needs no clock, which web pages do not have.
#[derive(Default)]
struct End {
    reached: Mutex<bool>,
    changed: Condvar,
}

impl End {
    /// Waits for it, at most this long. Returns whether it is reached.
    fn within(&self, time: Duration) -> bool {
        let reached = self.reached.lock().unwrap_or_else(PoisonError::into_inner);
        *reached || *self.changed.wait_timeout(reached, time).unwrap_or_else(PoisonError::into_inner).0
    }
}

/// Tells that the work has ended, also by a panic.
struct EndOnDrop(Arc<End>);

impl Drop for EndOnDrop {
    fn drop(&mut self) {
        *self.0.reached.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.changed.notify_all();
    }
}

impl Renderer {
    /// Adds up to `count` samples to every pixel, starting from the first index that some tile lacks. With adaptive
    /// sampling `count` is a mean, and a pass ends only where the film decides about its next samples. Returns whether the
    /// pass was completed; see [`Renderer::pass_over`].
    pub fn pass(&mut self, count: u32, options: &PassOptions<'_>) -> Result<bool, SceneError> {
        if self.film.identity().adaptive {
            let end = f64::from(count) + self.film.mean_samples();
            // The choice of photons decides how samples are distributed.
            while self.choose(options)? && self.allot(options.threads) {
                if !self.pass_over(&PassRange::all_tiles(0..u32::MAX), options)? {
                    return Ok(false);
                }
                if f64::from(self.film.mean_goal()) >= end {
                    return Ok(true);
                }
            }
            return Ok(self.is_complete());
        }
        let first = self.film.first_missing();
        self.pass_over(&PassRange::all_tiles(first..first.saturating_add(count)), options)
    }

    /// Decides how the next samples of an adaptive film are distributed, if it holds all of the last decision. Returns
    /// false if the picture is finished. A pass traces them.
    pub fn allot(&mut self, threads: usize) -> bool {
        if !self.film.has_reached_goals() {
            return true;
        }
        let options = PassOptions { threads, cancel: &AtomicBool::new(false), progress: None };
        // Each sample index of any tile would need the photons of all light paths of that index.
        let evenly = self.prepared.integrator.finds_photons();
        self.film.allot(evenly, Work::new(&options).threads())
    }

    /// Adds samples to tiles and skips those that the film holds. Returns whether the pass was completed.
    ///
    /// The film is the same for any split into passes and any cancel: it keeps finished samples and knows their
    /// indices. Tiles are processed from the costliest of the last pass to the cheapest, so that no thread ends
    /// with a costly tile; in the first pass, row by row.
    ///
    /// Errors: a panic in a worker ([`ErrorCode::Internal`](crate::schema::ErrorCode::Internal)); samples
    /// finished before it stay in the film. No memory for the splats of light paths.
    pub fn pass_over(&mut self, range: &PassRange, options: &PassOptions<'_>) -> Result<bool, SceneError> {
        if !self.choose(options)? {
            return Ok(false);
        }
        let schedule = Schedule::new(range, &self.film);
        let samples = schedule.samples.clone();
        let work = Work::new(options);
        if !self.prepared.integrator.finds_photons() {
            let tiles = schedule.tiles(&self.film, &samples);
            let light = LightTasks::new(schedule.missing_light(&self.film, &samples));
            work.parts.store(tiles.len() + light.len(), Ordering::Relaxed);
            return self.part(tiles, &light, None, &work);
        }
        // Sample indices one after another, each after its light paths.
        let each = LightTasks::new(vec![schedule.light(&(0..1))]).len();
        work.parts.store(each * samples.len() + schedule.missing(&self.film), Ordering::Relaxed);
        for index in samples {
            let one = index..index + 1;
            let tiles = schedule.tiles(&self.film, &one);
            let missing = schedule.missing_light(&self.film, &one);
            if tiles.is_empty() {
                // Without tiles, light paths need no photon map.
                let light = LightTasks::new(missing);
                work.skip(each.saturating_sub(light.len()));
                if light.len() > 0 && !self.part(tiles, &light, None, &work)? {
                    return Ok(false);
                }
                continue;
            }
            let Some(photons) = self.trace_photons(index, schedule.light(&one), &missing, &work)? else {
                return Ok(false);
            };
            if !self.part(tiles, &LightTasks::new(Vec::new()), Some(photons), &work)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Lets the integrator make its choices on all threads if it has not. At the same time all threads but one trace a
    /// [preview](Renderer::preview_pass) with independent camera paths. Returns false if it was cancelled before the choices
    /// were made; this is possible with several threads only.
    fn choose(&mut self, options: &PassOptions<'_>) -> Result<bool, SceneError> {
        if self.prepared.integrator.has_chosen() {
            return self.take_choices();
        }
        let threads = Work::new(options).threads();
        if threads > 1 {
            let end = Arc::new(End::default());
            let (prepared, at_end) = (self.prepared.clone(), EndOnDrop(Arc::clone(&end)));
            // Not scoped: a cancel does not wait for it.
            let chooser = turner_host::thread::Builder::new().spawn(move || {
                prepared.choose(threads);
                drop(at_end);
            });
            if self.film.first_missing() == 0 && !self.film.has_preview() {
                let plain = PassOptions { threads: threads - 1, progress: None, ..*options };
                self.preview_pass(&plain)?;
            }
            // After a panic it ends without a choice, and the panic occurs again in the call below.
            while chooser.is_ok() && !end.within(POLL) {
                if options.cancel.load(Ordering::Relaxed) {
                    return Ok(false);
                }
            }
        }
        self.prepared.choose(threads);
        self.take_choices()
    }

    /// Makes room in the film for what the integrator chose. The choices may have been made by another renderer of the
    /// same scene, or while this one was cancelled.
    fn take_choices(&mut self) -> Result<bool, SceneError> {
        let light_paths = self.prepared.integrator.light_paths();
        let cluster = self.prepared.integrator.cluster();
        let own = self.film.identity();
        if own.light_paths == light_paths && own.cluster == cluster {
            return Ok(true);
        }
        self.film.take_light(light_paths)?;
        self.film.note_cluster(cluster);
        Ok(true)
    }

    /// Renders tiles and light paths in parallel.
    fn part(
        &mut self,
        mut tiles: Vec<TileTask>,
        light: &LightTasks,
        photons: Option<Arc<PhotonMap>>,
        work: &Work<'_>,
    ) -> Result<bool, SceneError> {
        self.order.costliest_first(&mut tiles);
        let costs: Vec<AtomicU64> = self.order.costs().iter().map(|&c| AtomicU64::new(c)).collect();
        let grid = self.film.tiles();
        let preview = self.film.take_preview();
        let estimates_error = self.film.identity().estimates_error;
        let film = self.film.share();
        // Ray counts, added once per worker.
        let rays = Mutex::new(RayStats::default());
        let p = &self.prepared;
        let complete = work.run(tiles.len() + light.len(), |mut tasks| {
            let mut buffers = TileBuffers::new(p);
            buffers.estimates_error = estimates_error;
            if let Some(photons) = &photons {
                buffers.find_photons(photons.clone());
            }
            // Preview samples from before the integrator's choices are shown, but are not samples of the picture.
            let keeps_samples = p.integrator.keeps_samples();
            buffers.reuse_preview(preview.as_ref().filter(|preview| preview.is_chosen || keeps_samples));
            let mut light_buffers = LightBuffers::new(p);
            let stop = tasks.stop();
            while let Some(task) = tasks.next() {
                let Some(TileTask { tile, half, missing }) = tiles.get(task) else {
                    let paths = light.get(task - tiles.len());
                    if paths.is_some_and(|paths| !light_buffers.render(paths, &film, stop)) {
                        tasks.mark_unfinished();
                    }
                    continue;
                };
                let before = buffers.stats.total();
                let finished = buffers.render(&grid.rect(*tile), *half, missing, stop);
                buffers.deposit((*tile, *half), &finished, &film);
                if finished.len() < missing.iter().map(|r| r.end - r.start).sum() {
                    tasks.mark_unfinished();
                } else {
                    costs[*tile].store(buffers.stats.total() - before, Ordering::Relaxed);
                }
            }
            buffers.stats.merge(&light_buffers.stats);
            rays.lock().unwrap_or_else(|e| e.into_inner()).merge(&buffers.stats);
        });
        drop(film);
        self.film.count_non_finite();
        self.stats.merge(&rays.into_inner().unwrap_or_else(|e| e.into_inner()));
        // Once every tile has a sample, the preview is no longer visible.
        self.film.set_preview(preview.filter(|_| self.film.first_missing() == 0));
        let complete = complete?;
        self.order.set_costs(costs.into_iter().map(AtomicU64::into_inner));
        Ok(complete)
    }

    /// Traces the light paths of a sample index and builds their photon map; `None` if it was stopped. The splats
    /// of light paths in `missing` are added to the film.
    fn trace_photons(
        &mut self,
        index: u32,
        paths: Range<u64>,
        missing: &[Range<u64>],
        work: &Work<'_>,
    ) -> Result<Option<Arc<PhotonMap>>, SceneError> {
        let mut lacking = SampleSet::default();
        missing.iter().for_each(|range| lacking.insert(range.clone()));
        let light = LightTasks::new(vec![paths]);
        let batches: Vec<Mutex<Vec<Photon>>> = (0..light.len()).map(|_| Mutex::default()).collect();
        let rays = Mutex::new(RayStats::default());
        let film = self.film.share();
        let p = &self.prepared;
        let complete = work.run(light.len(), |mut tasks| {
            let mut buffers = LightBuffers::new(p);
            let stop = tasks.stop();
            while let Some(task) = tasks.next() {
                let (Some(paths), Some(batch)) = (light.get(task), batches.get(task)) else { continue };
                match buffers.photons(&paths, &lacking.within(paths.clone()), &film, stop) {
                    Some(photons) => *batch.lock().unwrap_or_else(|e| e.into_inner()) = photons,
                    None => tasks.mark_unfinished(),
                }
            }
            rays.lock().unwrap_or_else(|e| e.into_inner()).merge(&buffers.stats);
        });
        drop(film);
        self.film.count_non_finite();
        self.stats.merge(&rays.into_inner().unwrap_or_else(|e| e.into_inner()));
        if !complete? {
            return Ok(None);
        }
        let batches = batches.into_iter().map(|batch| batch.into_inner().unwrap_or_else(|e| e.into_inner()));
        let photons: Vec<Photon> = batches.flatten().collect();
        Ok(p.integrator.photon_map(index, photons).map(Arc::new))
    }
}
