//! A coarse preview before the first pass.

use std::sync::Mutex;
use std::sync::atomic::Ordering;

use super::tile::TileBuffers;
use super::work::Work;
use super::{PassOptions, Renderer};
use crate::film::Preview;
use crate::integrator::RayStats;
use crate::sampler::SampleId;
use crate::schema::SceneError;
use crate::view::place;

impl Renderer {
    /// Traces sample 0 of every fourth pixel in both directions. [`Renderer::develop`] shows each of them in its
    /// block of 4 x 4 pixels until these have samples. The film's sums do not change, so the finished picture is
    /// the same as without a preview. The pass that traces sample 0 reuses these samples. Where pixels depend on
    /// one another (shared paths, photons, adaptive anti-aliasing) it traces them again. Blocks far from one another
    /// come first, so that a preview that is cancelled is coarser, but whole: after a 64th of its samples. Returns
    /// whether the preview is complete; what is traced is shown in any case.
    pub fn preview_pass(&mut self, options: &PassOptions<'_>) -> Result<bool, SceneError> {
        let mut empty = Preview::new(self.film.region);
        empty.is_chosen = self.prepared.integrator.has_chosen();
        let rows = empty.rows();
        let preview = Mutex::new(empty.clone());
        let rays = Mutex::new(RayStats::default());
        let work = Work::new(options);
        work.parts.store(rows.len(), Ordering::Relaxed);
        let p = &self.prepared;
        let complete = work.run(rows.len(), |mut tasks| {
            let mut buffers = TileBuffers::new(p);
            let mut values = Vec::new();
            let stop = tasks.stop();
            while let Some(row) = tasks.next().and_then(|task| rows.get(task)) {
                let seed = u64::from(p.view.film.seed);
                let mut ids =
                    empty.positions(*row).map(|(x, y)| SampleId { x, y, index: 0, seed }).peekable();
                values.clear();
                while ids.peek().is_some() && !stop.is_set() {
                    let batch: Vec<_> = ids.by_ref().take(BATCH).collect();
                    let points: Vec<_> =
                        batch.into_iter().map(|id| (id, place(&p.view, &buffers.filter, &id))).collect();
                    values.extend(buffers.trace_points(points.into_iter()).iter().map(|r| {
                        let [red, green, blue] = r.color.to_array();
                        [red, green, blue, r.alpha]
                    }));
                }
                if ids.peek().is_some() {
                    tasks.mark_unfinished();
                }
                let mut preview = preview.lock().unwrap_or_else(|e| e.into_inner());
                preview.set(*row, values.iter().copied());
            }
            rays.lock().unwrap_or_else(|e| e.into_inner()).merge(&buffers.stats);
        });
        self.stats.merge(&rays.into_inner().unwrap_or_else(|e| e.into_inner()));
        self.film.set_preview(Some(preview.into_inner().unwrap_or_else(|e| e.into_inner())));
        complete
    }
}

/// Samples per batch: as many as pixels in a tile.
const BATCH: usize = 256;
