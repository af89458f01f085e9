//! The engine: a thread that turns descriptions into pictures while they are edited.
//!
//! ```text
//!  front end                          engine's thread
//!  order(…) ──► newest order ──► prepare (only what changed) ──► preview frames ──► film, sample after sample
//!     │              │                                                │                    │
//!     │              └─ stops the work on the last order              └──── Arc<Frame> ◄───┘
//!     └◄─ frame(), status(): the newest, without waiting
//! ```
//!
//! Two kinds of pictures follow one another. Preview frames ([`turner::preview`]) are approximate and never saved. The
//! film holds exactly the samples of `turner render`. Only the film settles, so the settled picture has the bytes of the
//! offline one.

mod board;
mod develop;
mod frame;
mod order;
mod pace;
mod settle;
mod stepper;
#[cfg(test)]
mod tests;
mod worker;

pub use frame::{Frame, Stage, Stand};
pub use order::{Display, Layers, Look, Order};
pub use stepper::Stepper;

use std::sync::Arc;
use turner_host::thread::JoinHandle;

use board::Board;

/// What the engine is doing.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// What it does, in words: "building BVHs", "rendering"; empty when it waits.
    pub doing: &'static str,
    /// The error of the newest order, which keeps its picture from being shown; the last good one stays.
    pub error: Option<EngineError>,
    /// Samples per pixel that all pixels of the film have, and those of the finished picture.
    pub samples: (u32, u32),
    /// Seconds of rendering since the order.
    pub seconds: f64,
    /// Seconds left to the finished picture, estimated from the samples so far.
    pub left: Option<f64>,
    /// Whether the film of the newest order is complete.
    pub settled: bool,
    /// The layers of light that the film holds apart.
    pub layers: Vec<String>,
}

/// Why an order has no picture.
#[derive(Clone, Debug)]
pub struct EngineError {
    /// The problem, in words.
    pub message: String,
    /// The remedy, if one is known.
    pub help: Option<String>,
    /// Whether it is a fault of the renderer, not of the scene.
    pub is_fault: bool,
}

/// Renders the newest order in a thread of its own. Dropping it stops the thread.
pub struct Engine {
    board: Arc<Board>,
    thread: Option<JoinHandle<()>>,
}

impl Engine {
    /// Starts the thread. `wake` is called from it whenever there is something new to show.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Engine {
        let board = Arc::new(Board::new(Box::new(wake)));
        let of_thread = Arc::clone(&board);
        let thread = turner_host::thread::Builder::new().name("engine".into());
        // Without a thread nothing is rendered, which the status says.
        let thread = thread.spawn(move || worker::run(&of_thread)).ok();
        if thread.is_none() {
            board.fail("no thread can be started".into(), None, true);
        }
        Engine { board, thread }
    }

    /// Replaces the newest order. Work on the last one stops within milliseconds, unless both ask for the same picture.
    pub fn order(&self, order: Order) -> u64 {
        self.board.post(order)
    }

    /// The newest frame.
    pub fn frame(&self) -> Option<Arc<Frame>> {
        self.board.frame()
    }

    /// What the engine is doing.
    pub fn status(&self) -> Status {
        self.board.status()
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.board.close();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
