//! An engine with a clock.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use turner_live::document::Document;
use turner_live::engine::{Engine, Frame, Order};

/// Time after which a frame is given up.
const PATIENCE: Duration = Duration::from_secs(60);

/// A document that is shown.
pub(super) struct Session {
    pub(super) document: Document,
    engine: Engine,
    woken: Receiver<()>,
    size: [u32; 2],
}

impl Session {
    pub(super) fn new(document: Document, size: [u32; 2]) -> Session {
        let (send, woken) = channel();
        let engine = Engine::new(move || {
            let _ = send.send(());
        });
        Session { document, engine, woken, size }
    }

    /// Orders the document's scene.
    pub(super) fn order(&self, moving: bool) -> u64 {
        let mut order = Order::new(Arc::clone(self.document.desc()));
        (order.size, order.moving) = (self.size, moving);
        self.engine.order(order)
    }

    /// The frame that is shown.
    pub(super) fn shown(&self) -> Option<Arc<Frame>> {
        self.engine.frame()
    }

    /// Waits until a frame is as wanted.
    pub(super) fn wait(&self, what: impl Fn(&Frame) -> bool) -> Result<Arc<Frame>, String> {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(frame) = self.engine.frame().filter(|frame| what(frame)) {
                return Ok(frame);
            }
            if let Some(error) = self.engine.status().error {
                return Err(error.message);
            }
            let left = end.saturating_duration_since(Instant::now());
            match self.woken.recv_timeout(left) {
                Ok(()) => {}
                Err(RecvTimeoutError::Timeout) => return Err("no picture within a minute".into()),
                Err(RecvTimeoutError::Disconnected) => return Err("the engine has ended".into()),
            }
        }
    }

    /// Milliseconds from `started`, when the user did something that was ordered as `number`, to its first frame.
    pub(super) fn first(&self, number: u64, started: Instant) -> Result<(f64, Arc<Frame>), String> {
        let frame = self.wait(|frame| frame.order >= number)?;
        Ok((started.elapsed().as_secs_f64() * 1e3, frame))
    }

    /// Waits until the film is rendered, as a user does before a still picture.
    pub(super) fn rest(&self, time: Duration) {
        std::thread::sleep(time);
        while self.woken.try_recv().is_ok() {}
    }
}
