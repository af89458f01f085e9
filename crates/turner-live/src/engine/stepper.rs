//! The engine without a thread of its own.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::board::Board;
use super::worker::Worker;
use super::{Frame, Order, Status};

/// Renders the newest order in the caller's thread, a piece of work at a time: for programs that must return to an event
/// loop, such as the worker of a web page. It gives the same frames as [`Engine`](super::Engine).
pub struct Stepper {
    board: Arc<Board>,
    worker: Worker,
}

impl Stepper {
    /// `slice` is the longest time of a step while the film is rendered. The preparation of a scene, the choices of its
    /// integrator and a preview frame are not divided.
    pub fn new(slice: Duration) -> Stepper {
        Stepper { board: Arc::new(Board::new(Box::new(|| {}))), worker: Worker::in_short_turns(slice) }
    }

    /// Replaces the newest order.
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

    /// The flag that ends the step that runs, for other threads. A step on a picture that moves is not ended.
    pub fn stop(&self) -> &AtomicBool {
        &self.board.stop
    }

    /// The same flag, for threads that outlive the borrow.
    pub fn stopper(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.board.stop)
    }

    /// Does the next piece of work. Returns whether there is more to do; while something moves there is always more.
    pub fn step(&mut self) -> bool {
        self.worker.turn(&self.board);
        !self.worker.rests(&self.board)
    }
}

impl Drop for Stepper {
    fn drop(&mut self) {
        self.board.close();
    }
}
