//! Rendering: tiles in parallel, each pixel and sample on its own.

mod adaptive;
mod order;
mod pixel;
mod single;
mod tile;

pub use pixel::{MAX_LISTED, PixelRecord, SampleRecord, Square, pixel};
pub(crate) use single::{camera_point, place_of, sample_id};
pub use single::{camera_ray, sample};

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use crate::film::{BAND, Film, NonFinite, PixelRect};
use crate::integrator::RayStats;
use crate::scene::Scene;
use crate::scene::error::{ErrorCode, SceneError};
use order::TileOrder;
use tile::TileBuffers;

/// Edge of a tile in pixels; a row of tiles is a band of the film.
const TILE: u32 = BAND;

/// How a pass is run; none of it changes the picture.
#[derive(Clone, Copy)]
pub struct PassOptions<'a> {
    /// Threads; 0 takes all there are.
    pub threads: usize,
    /// Becomes true when rendering should stop; tiles under way are finished.
    pub cancel: &'a AtomicBool,
    /// Called with (tiles done, tiles of this pass) from any thread.
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
        let film = Film::new(&scene.film)?;
        let order = TileOrder::new(tiles(&film.region).len());
        Ok(Renderer { scene, film, stats: RayStats::default(), next_sample: 0, order })
    }

    /// Samples each pixel gets in all. Adaptive subdivision counts as one, however many rays it takes.
    pub fn samples_per_pixel(&self) -> u32 {
        self.scene.film.samples_per_pixel()
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
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            n => n,
        }
        .min(tiles.len())
        .max(1);
        let order = self.order.dearest_first();
        let costs: Vec<AtomicU64> = self.order.costs().iter().map(|&c| AtomicU64::new(c)).collect();
        let next = AtomicUsize::new(0);
        let done = AtomicUsize::new(0);
        let failed = AtomicBool::new(false);
        let region = self.film.region;
        let bands: Vec<_> = self.film.bands_mut().iter_mut().map(Mutex::new).collect();
        // What the workers counted, added once per worker.
        let counts = Mutex::new((NonFinite::default(), RayStats::default()));
        let scene = self.scene;
        let work = || {
            let mut buffers = TileBuffers::new(scene);
            while !(options.cancel.load(Ordering::Relaxed) || failed.load(Ordering::Relaxed)) {
                let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                let (tile, before) = (&tiles[index], buffers.stats.total());
                buffers.render(tile, samples.clone());
                costs[index].store(buffers.stats.total() - before, Ordering::Relaxed);
                let band = &bands[((tile.y - region.y) / BAND) as usize];
                buffers.deposit(tile, &mut band.lock().unwrap_or_else(|e| e.into_inner()));
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                if let Some(progress) = options.progress {
                    progress(done, tiles.len());
                }
            }
            let mut counts = counts.lock().unwrap_or_else(|e| e.into_inner());
            counts.0.merge(&buffers.non_finite);
            counts.1.merge(&buffers.stats);
        };
        let guarded = || {
            let result = catch_unwind(AssertUnwindSafe(work));
            if result.is_err() {
                failed.store(true, Ordering::Relaxed);
            }
            result.map_err(panic_message)
        };
        let mut failure = None;
        if threads == 1 {
            failure = guarded().err();
        } else {
            std::thread::scope(|scope| {
                let workers: Vec<_> = (0..threads).map(|_| scope.spawn(guarded)).collect();
                for worker in workers {
                    if let Err(message) = worker.join().unwrap_or_else(|e| Err(panic_message(e))) {
                        failure.get_or_insert(message);
                    }
                }
            });
        }
        drop(bands);
        let counts = counts.into_inner().unwrap_or_else(|e| e.into_inner());
        self.film.non_finite.merge(&counts.0);
        self.stats.merge(&counts.1);
        if let Some(message) = failure {
            let message = format!("a fault while rendering: {message}");
            return Err(SceneError::new(ErrorCode::Internal, message)
                .help("this is a bug in Turner: please report it"));
        }
        self.order.set_costs(costs.into_iter().map(AtomicU64::into_inner));
        let complete = done.load(Ordering::Relaxed) == tiles.len();
        if complete {
            self.next_sample = samples.end;
        }
        Ok(complete)
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

fn panic_message(payload: Box<dyn std::any::Any + Send>) -> String {
    match payload.downcast::<String>() {
        Ok(s) => *s,
        Err(payload) => payload.downcast_ref::<&str>().map_or("unknown".to_owned(), |s| (*s).to_owned()),
    }
}
