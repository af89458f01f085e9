//! Rendering: tiles in parallel, each pixel and sample on its own.

mod adaptive;
mod light;
mod order;
mod pixel;
mod single;
mod tile;
mod work;

pub use pixel::{MAX_LISTED, PixelRecord, SampleRecord, Square, pixel};
pub(crate) use single::{camera_point, place_of, sample_id};
pub use single::{camera_ray, sample};
pub(crate) use tile::take_points;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use crate::film::{BAND, Film, NonFinite, Picture, PixelRect};
use crate::integrator::{Photon, PhotonMap, RayStats, show};
use crate::scene::Scene;
use crate::scene::error::SceneError;
use light::{LightBuffers, LightTasks};
use order::TileOrder;
use tile::TileBuffers;
use work::Work;

/// Edge of a tile in pixels; a row of tiles is a band of the film.
const TILE: u32 = BAND;

/// How a pass is run; none of it changes the picture.
#[derive(Clone, Copy)]
pub struct PassOptions<'a> {
    /// Threads; 0 takes all there are.
    pub threads: usize,
    /// Becomes true when rendering should stop; tiles under way are finished.
    pub cancel: &'a AtomicBool,
    /// Called with (parts done, parts of this pass) from any thread: tiles, and batches of light paths.
    pub progress: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

/// Renders a scene into a film, pass by pass.
pub struct Renderer<'a> {
    scene: &'a Scene,
    /// The sums so far.
    pub film: Film,
    /// Rays so far.
    pub stats: RayStats,
    next_sample: u32,
    order: TileOrder,
}

impl<'a> Renderer<'a> {
    /// A renderer with an empty film.
    pub fn new(scene: &'a Scene) -> Result<Renderer<'a>, SceneError> {
        let mut film = Film::new(&scene.film)?;
        if scene.integrator.integrator().light_paths(scene) > 0 {
            film.take_light()?;
        }
        let order = TileOrder::new(tiles(&film.region).len());
        Ok(Renderer { scene, film, stats: RayStats::default(), next_sample: 0, order })
    }

    /// Samples each pixel gets in all. Adaptive subdivision counts as one, however many rays it takes.
    pub fn samples_per_pixel(&self) -> u32 {
        self.scene.film.samples_per_pixel()
    }

    /// The picture as far as it is known, with what the integrator's numbers look like.
    pub fn develop(&self) -> Picture {
        let mut picture = self.film.develop(&self.scene.film);
        show(&self.scene.integrator, &mut picture);
        picture
    }

    /// Whether all samples are in.
    pub fn is_complete(&self) -> bool {
        self.next_sample >= self.samples_per_pixel()
    }

    /// The rays that each tile took in the last pass it was part of, row by row; 0 before its first.
    pub fn tile_costs(&self) -> &[u64] {
        self.order.costs()
    }

    /// Adds up to `count` samples to every pixel. Returns whether the pass came to its end. The film is the same
    /// for any split into passes. The tiles that took most rays in the last pass come first, so that no thread is left with a
    /// dear one at the end; in the first pass they come row by row. A fault in a worker is an error; finished tiles stay in the film.
    pub fn pass(&mut self, count: u32, options: &PassOptions<'_>) -> Result<bool, SceneError> {
        let samples = self.next_sample..self.samples_per_pixel().min(self.next_sample.saturating_add(count));
        let tiles = tiles(&self.film.region);
        let light = LightTasks::new(self.scene, &samples);
        let work = Work::new(options);
        if !self.scene.integrator.integrator().finds_photons(self.scene) {
            work.parts.store(tiles.len() + light.len(), Ordering::Relaxed);
            return self.part(samples, &tiles, &light, None, &work);
        }
        // Samples of one number after another, each after its light paths.
        let parts = light.len() + samples.len() * tiles.len();
        work.parts.store(parts, Ordering::Relaxed);
        for index in samples {
            let one = index..index + 1;
            let light = LightTasks::new(self.scene, &one);
            let Some(photons) = self.trace_photons(index, &light, &work)? else { return Ok(false) };
            if !self.part(one, &tiles, &LightTasks::NONE, Some(photons), &work)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Renders samples of all tiles, and light paths beside them.
    fn part(
        &mut self,
        samples: Range<u32>,
        tiles: &[PixelRect],
        light: &LightTasks,
        photons: Option<Arc<PhotonMap>>,
        work: &Work<'_>,
    ) -> Result<bool, SceneError> {
        let order = self.order.dearest_first();
        let costs: Vec<AtomicU64> = self.order.costs().iter().map(|&c| AtomicU64::new(c)).collect();
        let region = self.film.region;
        let (bands, splats) = self.film.parts_mut();
        let bands: Vec<_> = bands.iter_mut().map(Mutex::new).collect();
        let splats = splats.map(Mutex::new);
        // What the workers counted, added once per worker.
        let counts = Mutex::new((NonFinite::default(), RayStats::default()));
        let scene = self.scene;
        let complete = work.run(tiles.len() + light.len(), |tasks| {
            let mut buffers = TileBuffers::new(scene);
            if let Some(photons) = &photons {
                buffers.find_photons(photons.clone());
            }
            let mut light_buffers = LightBuffers::new(scene);
            for task in tasks {
                let Some(&index) = order.get(task) else {
                    if let Some((first, count)) = light.get(task - order.len()) {
                        light_buffers.trace(first, count);
                        light_buffers.deposit(u64::from(count), splats.as_ref());
                    }
                    continue;
                };
                let (tile, before) = (&tiles[index], buffers.stats.total());
                buffers.render(tile, samples.clone());
                costs[index].store(buffers.stats.total() - before, Ordering::Relaxed);
                let band = &bands[((tile.y - region.y) / BAND) as usize];
                buffers.deposit(tile, &mut band.lock().unwrap_or_else(|e| e.into_inner()));
            }
            buffers.stats.merge(&light_buffers.stats);
            let mut counts = counts.lock().unwrap_or_else(|e| e.into_inner());
            counts.0.merge(&buffers.non_finite);
            counts.1.merge(&buffers.stats);
        });
        drop((bands, splats));
        let counts = counts.into_inner().unwrap_or_else(|e| e.into_inner());
        self.film.non_finite.merge(&counts.0);
        self.film.count_splats();
        self.stats.merge(&counts.1);
        let complete = complete?;
        self.order.set_costs(costs.into_iter().map(AtomicU64::into_inner));
        if complete {
            self.next_sample = samples.end;
        }
        Ok(complete)
    }

    /// Traces the light paths of a sample, whose photons its camera paths find; `None` if they did not come to their end.
    fn trace_photons(
        &mut self,
        index: u32,
        light: &LightTasks,
        work: &Work<'_>,
    ) -> Result<Option<Arc<PhotonMap>>, SceneError> {
        let scene = self.scene;
        let (_, splats) = self.film.parts_mut();
        let splats = splats.map(Mutex::new);
        let batches: Vec<Mutex<Vec<Photon>>> = (0..light.len()).map(|_| Mutex::default()).collect();
        let stats = Mutex::new(RayStats::default());
        let complete = work.run(light.len(), |tasks| {
            let mut buffers = LightBuffers::new(scene);
            for task in tasks {
                let Some((first, count)) = light.get(task) else { continue };
                buffers.trace(first, count);
                buffers.deposit(u64::from(count), splats.as_ref());
                if let Some(batch) = batches.get(task) {
                    *batch.lock().unwrap_or_else(|e| e.into_inner()) = buffers.take_photons();
                }
            }
            stats.lock().unwrap_or_else(|e| e.into_inner()).merge(&buffers.stats);
        });
        self.film.count_splats();
        self.stats.merge(&stats.into_inner().unwrap_or_else(|e| e.into_inner()));
        if !complete? {
            return Ok(None);
        }
        let batches = batches.into_iter().map(|batch| batch.into_inner().unwrap_or_else(|e| e.into_inner()));
        let photons: Vec<Photon> = batches.flatten().collect();
        Ok(scene.caustics.as_ref().map(|plan| Arc::new(PhotonMap::new(plan, index, photons))))
    }
}

fn tiles(region: &PixelRect) -> Vec<PixelRect> {
    let mut tiles = Vec::new();
    let (right, bottom) = (region.x + region.width, region.y + region.height);
    for y in (region.y..bottom).step_by(TILE as usize) {
        for x in (region.x..right).step_by(TILE as usize) {
            tiles.push(PixelRect { x, y, width: TILE.min(right - x), height: TILE.min(bottom - y) });
        }
    }
    tiles
}
