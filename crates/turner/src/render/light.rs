//! Light paths of a pass, in batches.

use std::ops::Range;
use std::sync::Mutex;

use crate::film::{Splat, Splats};
use crate::filter::Filter;
use crate::integrator::{LightTracer, Photon, RayStats};
use crate::scene::Scene;

/// Light paths of a batch: enough that what is shared is seldom locked, and that rays fill blocks.
const BATCH: u64 = 4096;

/// The light paths that belong to some samples of all pixels, in batches.
pub(super) struct LightTasks {
    first: u64,
    count: u64,
}

impl LightTasks {
    /// None.
    pub(super) const NONE: LightTasks = LightTasks { first: 0, count: 0 };

    pub(super) fn new(scene: &Scene, samples: &Range<u32>) -> LightTasks {
        let each = scene.integrator.integrator().light_paths(scene);
        LightTasks { first: each * u64::from(samples.start), count: each * samples.len() as u64 }
    }

    /// How many batches there are.
    pub(super) fn len(&self) -> usize {
        self.count.div_ceil(BATCH) as usize
    }

    /// The first light path of a batch, and their number.
    pub(super) fn get(&self, batch: usize) -> Option<(u64, u32)> {
        let begin = BATCH * batch as u64;
        let count = self.count.checked_sub(begin)?.min(BATCH);
        (count > 0).then_some((self.first + begin, count as u32))
    }
}

/// What a worker needs for light paths; kept from batch to batch.
pub(super) struct LightBuffers<'a> {
    tracer: Option<Box<dyn LightTracer + 'a>>,
    filter: Filter,
    splats: Vec<Splat>,
    pub(super) stats: RayStats,
}

impl<'a> LightBuffers<'a> {
    pub(super) fn new(scene: &'a Scene) -> LightBuffers<'a> {
        LightBuffers {
            tracer: scene.integrator.integrator().light_tracer(scene),
            filter: scene.film.filter(),
            splats: Vec::new(),
            stats: RayStats::default(),
        }
    }

    pub(super) fn trace(&mut self, first: u64, count: u32) {
        self.splats.clear();
        if let Some(tracer) = &mut self.tracer {
            tracer.trace(first, count, &mut self.splats, &mut self.stats);
        }
    }

    /// Adds what was traced, by `paths` light paths, to the film.
    pub(super) fn deposit(&self, paths: u64, splats: Option<&Mutex<&mut Splats>>) {
        if let Some(splats) = splats {
            let mut splats = splats.lock().unwrap_or_else(|e| e.into_inner());
            splats.add(&self.filter, paths, &self.splats);
        }
    }

    /// The photons of what was traced.
    pub(super) fn take_photons(&mut self) -> Vec<Photon> {
        self.tracer.as_mut().map(|tracer| std::mem::take(tracer.photons())).unwrap_or_default()
    }
}
