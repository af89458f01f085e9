//! Rendering: tiles in parallel, each pixel and sample on its own.

mod adaptive;
mod coarse;
mod light;
mod order;
mod pass;
mod pixel;
#[cfg(test)]
mod pixel_tests;
#[cfg(test)]
mod resume_tests;
mod schedule;
mod single;
mod tile;
mod work;

pub use pixel::{MAX_LISTED, PixelRecord, SampleRecord, Square, pixel};
pub use schedule::{PassRange, TileSet};
pub use single::sample;

use std::sync::atomic::AtomicBool;

use order::TileOrder;

use crate::film::{Film, Picture};
use crate::integrator::{Prepared, RayStats};
use crate::schema::{ErrorCode, SceneError};

/// How a pass is run; none of it changes the picture.
#[derive(Clone, Copy)]
pub struct PassOptions<'a> {
    /// Threads; 0 takes all there are.
    pub threads: usize,
    /// Becomes true when rendering should stop. Workers look at it after each sample number of a tile; what is finished stays
    /// in the film.
    pub cancel: &'a AtomicBool,
    /// Called with (parts done, parts of this pass) from any thread, while no lock is held: tiles, and batches of light paths.
    pub progress: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

/// Renders a scene into a film, pass by pass. It owns what it needs.
pub struct Renderer {
    prepared: Prepared,
    /// The sums so far.
    pub film: Film,
    /// Rays so far.
    pub stats: RayStats,
    order: TileOrder,
}

impl Renderer {
    /// A renderer with an empty film.
    pub fn new(prepared: Prepared) -> Result<Renderer, SceneError> {
        let mut film = Film::new(&prepared.view.film)?;
        film.take_light(prepared.integrator.light_paths())?;
        let order = TileOrder::new(film.tiles().count());
        Ok(Renderer { prepared, film, stats: RayStats::default(), order })
    }

    /// A renderer that goes on with a film of the same picture: one that was saved, or merged of others.
    ///
    /// Errors: the film is of another picture ([`ErrorCode::Conflict`]), but for the scene's fingerprint, which is not compared.
    pub fn resume(prepared: Prepared, film: Film) -> Result<Renderer, SceneError> {
        prepared.choose();
        let mut renderer = Renderer::new(prepared)?;
        let mut own = renderer.film.identity().clone();
        own.scene = film.identity().scene;
        let channels = (film.channels() != renderer.film.channels())
            .then(|| "it has channels that are not rendered".to_owned());
        match own.difference(film.identity()).or(channels) {
            Some(difference) => {
                let message = format!("the film is of another picture; {difference}");
                Err(SceneError::new(ErrorCode::Conflict, message))
            }
            None => {
                renderer.film = film;
                Ok(renderer)
            }
        }
    }

    /// What is rendered.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Samples each pixel gets in all. Adaptive subdivision counts as one, however many rays it takes.
    pub fn samples_per_pixel(&self) -> u32 {
        self.prepared.view.film.samples_per_pixel()
    }

    /// The picture as far as it is known, with what the integrator's numbers look like.
    pub fn develop(&self) -> Picture {
        let mut picture = self.film.develop(&self.prepared.view.film);
        self.prepared.integrator.show(&mut picture);
        picture
    }

    /// Whether all samples are in.
    pub fn is_complete(&self) -> bool {
        self.film.first_missing() >= self.samples_per_pixel()
    }

    /// The rays that each tile took in the last pass it was part of, row by row; 0 before its first.
    pub fn tile_costs(&self) -> &[u64] {
        self.order.costs()
    }
}
