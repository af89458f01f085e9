//! Passes: samples of tiles, and light paths beside them.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use super::light::{LightBuffers, LightTasks};
use super::schedule::{PassRange, Schedule, TileTask};
use super::tile::TileBuffers;
use super::work::Work;
use super::{PassOptions, Renderer};
use crate::film::SampleSet;
use crate::integrator::{Photon, PhotonMap, RayStats};
use crate::schema::SceneError;

impl Renderer {
    /// Adds up to `count` samples to every pixel: the next ones from the first number that some tile lacks. Returns whether the
    /// pass came to its end; see [`Renderer::pass_over`].
    pub fn pass(&mut self, count: u32, options: &PassOptions<'_>) -> Result<bool, SceneError> {
        let first = self.film.first_missing();
        self.pass_over(&PassRange::all_tiles(first..first.saturating_add(count)), options)
    }

    /// Adds samples to tiles; what the film holds already is skipped. Returns whether the pass came to its end. The film is the
    /// same for any split into passes, cancelled where they may be: it keeps the samples that were finished and knows them. The tiles
    /// that took most rays in the last pass come first, so that no thread is left with a costly one at the end; in the first
    /// pass they come row by row. A fault in a worker is an error; what was finished before stays in the film.
    pub fn pass_over(&mut self, range: &PassRange, options: &PassOptions<'_>) -> Result<bool, SceneError> {
        self.choose(options)?;
        let schedule = Schedule::new(range, &self.film);
        let samples = schedule.samples.clone();
        let work = Work::new(options);
        if !self.prepared.integrator.finds_photons() {
            let tiles = schedule.tiles(&self.film, &samples);
            let light = LightTasks::new(schedule.missing_light(&self.film, &samples));
            work.parts.store(tiles.len() + light.len(), Ordering::Relaxed);
            return self.part(tiles, &light, None, &work);
        }
        // Samples of one number after another, each after its light paths.
        let each = LightTasks::new(vec![schedule.light(&(0..1))]).len();
        work.parts.store(each * samples.len() + schedule.missing(&self.film), Ordering::Relaxed);
        for index in samples {
            let one = index..index + 1;
            let tiles = schedule.tiles(&self.film, &one);
            let missing = schedule.missing_light(&self.film, &one);
            if tiles.is_empty() {
                // Light alone needs no photons.
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

    /// Lets the integrator choose what pays, if it has not yet, while the other threads trace a [preview](Renderer::preview_pass) by paths of the plain kind.
    fn choose(&mut self, options: &PassOptions<'_>) -> Result<(), SceneError> {
        if self.prepared.integrator.has_chosen() {
            return Ok(());
        }
        let prepared = self.prepared.clone();
        let threads = Work::new(options).threads();
        if threads > 1 && self.film.first_missing() == 0 && !self.film.has_preview() {
            std::thread::scope(|scope| {
                let chooser = scope.spawn(|| prepared.choose());
                let plain = PassOptions { threads: threads - 1, progress: None, ..*options };
                let shown = self.preview_pass(&plain);
                // A fault of its own shows again in the next line.
                let _ = chooser.join();
                shown
            })?;
        }
        prepared.choose();
        let light_paths = prepared.integrator.light_paths();
        if light_paths > 0 || prepared.integrator.shares_paths() {
            // Its samples are not those of this choice.
            self.film.set_preview(None);
        }
        self.film.take_light(light_paths)
    }

    /// Renders samples of tiles, and light paths beside them.
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
        let film = self.film.share();
        // What the workers counted, added once per worker.
        let rays = Mutex::new(RayStats::default());
        let p = &self.prepared;
        let complete = work.run(tiles.len() + light.len(), |mut tasks| {
            let mut buffers = TileBuffers::new(p);
            if let Some(photons) = &photons {
                buffers.find_photons(photons.clone());
            }
            buffers.keep_preview(preview.as_ref());
            let mut light_buffers = LightBuffers::new(p);
            let stop = tasks.stop();
            while let Some(task) = tasks.next() {
                let Some(TileTask { tile, missing }) = tiles.get(task) else {
                    let paths = light.get(task - tiles.len());
                    if paths.is_some_and(|paths| !light_buffers.render(paths, &film, stop)) {
                        tasks.leave_off();
                    }
                    continue;
                };
                let before = buffers.stats.total();
                let finished = buffers.render(&grid.rect(*tile), missing, stop);
                buffers.deposit(*tile, &finished, &film);
                if finished.len() < missing.iter().map(|r| r.end - r.start).sum() {
                    tasks.leave_off();
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
        // Once each tile has a sample nothing of the preview is seen.
        self.film.set_preview(preview.filter(|_| self.film.first_missing() == 0));
        let complete = complete?;
        self.order.set_costs(costs.into_iter().map(AtomicU64::into_inner));
        Ok(complete)
    }

    /// Traces the light paths of a sample, whose photons its camera paths find; `None` if they did not come to their end. What
    /// those in `missing` bring goes to the film.
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
                    None => tasks.leave_off(),
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
