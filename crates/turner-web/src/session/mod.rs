//! A session: one document, one engine, and the calls of a page.

mod assist;
mod calls;
mod error;
mod events;
mod files;
mod gallery;
mod inspect;
mod look;
mod parts;
mod picture;
mod save;
mod values;

pub use calls::{CALLS, Call, Files, READS, REPLACES};
pub use error::{CallError, Place};
pub use events::Event;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use serde_json::Value as Json;
use turner::schema::Limits;
use turner_io::LoadOptions;
use turner_io::scene::LoadError;
use turner_live::document::Document;
use turner_live::engine::{Frame, Look, Order, Stepper};

use events::Sent;

use crate::picture::PictureJob;

/// Longest time of a step: what a page does between two steps waits for it.
const SLICE: Duration = Duration::from_millis(60);

/// The answer to a call.
#[derive(Debug, Default)]
pub struct Reply {
    /// The result.
    pub json: Json,
    /// The bytes of a saved file.
    pub bytes: Vec<u8>,
}

impl From<Json> for Reply {
    fn from(json: Json) -> Reply {
        Reply { json, bytes: Vec::new() }
    }
}

/// See the module.
pub struct Session {
    document: Document,
    /// Whether something was opened.
    is_open: bool,
    stepper: Stepper,
    look: Look,
    /// The most pixels that a preview needs: the size of the canvas.
    size: [u32; 2],
    moving: bool,
    paused: bool,
    threads: usize,
    limits: Limits,
    sent: Sent,
    /// A picture beside the document.
    job: Option<PictureJob>,
}

impl Session {
    /// A session with nothing open. `threads` render, 0 for all.
    pub fn new(threads: usize, limits: Limits) -> Session {
        Session {
            document: Document::empty(),
            is_open: false,
            stepper: Stepper::new(SLICE),
            look: Look::default(),
            size: [1280, 960],
            moving: false,
            paused: false,
            threads,
            limits,
            sent: Sent::default(),
            job: None,
        }
    }

    /// Makes a call of [`CALLS`]. `files` are the names and bytes of files that belong to it.
    ///
    /// Errors: an unknown call, wrong arguments, and those of the call.
    pub fn call(
        &mut self,
        name: &str,
        args: &Json,
        files: Vec<(String, Vec<u8>)>,
    ) -> Result<Reply, CallError> {
        let Some((_, call)) = CALLS.iter().find(|(own, _)| *own == name) else {
            let names: Vec<&str> = CALLS.iter().map(|(own, _)| *own).collect();
            let help = turner::schema::error::suggestion(name, &names);
            return Err(CallError { help, ..CallError::new(format!("there is no call \"{name}\"")) });
        };
        call(self, args, files)
    }

    /// Does the next piece of rendering. Returns whether there is more to do.
    pub fn step(&mut self) -> bool {
        self.stepper.step()
    }

    /// What is new since the last time.
    pub fn events(&mut self) -> Vec<Event> {
        events::new(self)
    }

    /// The flag that ends the step that runs, for other threads.
    pub fn stop(&self) -> &AtomicBool {
        self.stepper.stop()
    }

    /// The same flag, for threads that outlive the borrow.
    pub fn stopper(&self) -> Arc<AtomicBool> {
        self.stepper.stopper()
    }

    /// Opens a scene or a model on disk, with the files of its folder that it reads. They are then in memory: nothing is
    /// written, and later texts may name these files alone.
    ///
    /// Errors: those of reading it.
    pub fn open_path(&mut self, path: &Path) -> Result<(), LoadError> {
        let document = Document::read_into_memory(path, &self.load_options())?;
        self.show(document);
        Ok(())
    }

    /// Orders the picture of the document as it is.
    fn order(&mut self) {
        if !self.is_open {
            return;
        }
        self.stepper.order(Order {
            look: self.look.clone(),
            size: self.size,
            moving: self.moving,
            paused: self.paused,
            threads: self.threads,
            ..Order::new(Arc::clone(self.document.desc()))
        });
    }

    /// Shows another document.
    fn show(&mut self, document: Document) {
        (self.document, self.is_open, self.moving) = (document, true, false);
        self.look = Look::default();
        self.sent.forget();
        self.order();
    }

    fn load_options(&self) -> LoadOptions {
        LoadOptions { threads: self.threads, limits: self.limits.clone(), ..LoadOptions::default() }
    }

    /// The shown picture.
    fn frame(&self) -> Result<Arc<Frame>, CallError> {
        self.stepper.frame().filter(|_| self.is_open).ok_or_else(|| CallError::new("there is no picture yet"))
    }
}
