//! What all parts of the window share: document, engine, selection, messages, background work.

mod files;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use turner::SceneDesc;
use turner::schema::SceneError;
use turner_live::document::{
    Document, OpenError, Opening, Recovered, Recovery, Saving, Start, Watch, recovered,
};
use turner_live::engine::{Engine, Frame, Look, Order, Status};

use crate::actions::Action;
use crate::insight::Insight;
use crate::jobs::Queue;
use crate::layout::Panel;
use crate::node::Node;
use crate::panels::second::Second;
use crate::panels::swatch::Swatch;
use crate::pixel::PixelValues;
use crate::settings::Settings;
use crate::task::Task;
use crate::viewport::ViewportState;

/// A message for the user, at the lower edge until it is closed or followed by another.
#[derive(Clone, Debug)]
pub struct Message {
    /// The text.
    pub text: String,
    /// The remedy.
    pub help: Option<String>,
    /// Whether something went wrong.
    pub is_error: bool,
}

/// A question that waits for an answer.
#[derive(Clone, Debug)]
pub enum Dialog {
    /// Unsaved changes before something that would lose them.
    Unsaved(After),
    /// The name of a file.
    File {
        /// What it is for.
        purpose: Purpose,
        /// The name so far.
        name: String,
    },
    /// Unsaved work of an earlier session.
    Recovered(Vec<Recovered>),
    /// Renders that run, before the window closes.
    Jobs,
    /// The new name of a part.
    Rename {
        /// The part.
        node: Node,
        /// The name so far.
        name: String,
        /// Why the name cannot be taken.
        fault: Option<String>,
    },
}

/// What a file is chosen for.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// To open a scene.
    Open,
    /// To save the scene.
    Save,
    /// To add a model.
    Model,
    /// To save the picture.
    Picture,
    /// For a key of a part: its key path; with `true`, as an image texture.
    Key(String, bool),
}

/// What is done after the question about unsaved changes.
#[derive(Clone, Debug)]
pub enum After {
    /// Open a file.
    Open(PathBuf),
    /// Open a scene of the gallery.
    Start(&'static Start),
    /// A new scene.
    New,
    /// Close the window.
    Quit,
}

/// What was ordered last.
struct Ordered {
    desc: Arc<SceneDesc>,
    look: Look,
    size: [u32; 2],
    moving: bool,
    paused: bool,
    threads: usize,
}

impl Ordered {
    fn is(&self, other: &Ordered) -> bool {
        Arc::ptr_eq(&self.desc, &other.desc)
            && self.look == other.look
            && (self.size, self.moving) == (other.size, other.moving)
            && (self.paused, self.threads) == (other.paused, other.threads)
    }
}

/// See the module.
pub struct Studio {
    /// The scene.
    pub document: Document,
    /// The renderer's thread.
    pub engine: Engine,
    /// The newest frame that was taken from the engine.
    pub frame: Option<Arc<Frame>>,
    /// What the engine does.
    pub status: Status,
    /// What is shown of the scene.
    pub look: Look,
    /// Whether rendering waits.
    pub paused: bool,
    /// When something moved last.
    pub moved: Option<Instant>,
    /// The selected part; what the properties show.
    pub selection: Option<Node>,
    /// Further selected parts.
    pub also: Vec<Node>,
    /// The newest message.
    pub message: Option<Message>,
    /// Why the scene's file cannot be shown.
    pub problem: Option<OpenError>,
    /// A question that waits.
    pub dialog: Option<Dialog>,
    /// Renders to files.
    pub jobs: Queue,
    /// Remembered settings.
    pub settings: Settings,
    /// The folder of settings and recovery.
    pub home: PathBuf,
    /// The viewport's tools.
    pub viewport: ViewportState,
    /// The second view.
    pub second: Second,
    /// The picture of the selected material or texture.
    pub swatch: Swatch,
    /// What was found out about the picture.
    pub insight: Insight,
    /// AOVs of the pixel under the pointer.
    pub(crate) pixel: PixelValues,
    /// The desktop's file dialog while it is open.
    pub asking: Option<Task<Option<(Purpose, PathBuf)>>>,
    /// Actions to run at the end of the frame.
    pub queue: Vec<Action>,
    /// The panel to open with the next frame.
    pub reveal: Option<Panel>,
    /// Whether the keyboard goes to the properties with the next frame.
    pub focus_properties: bool,
    /// Whether the window should close.
    pub quit: bool,
    opening: Option<(Opening, bool)>,
    saving: Option<Saving>,
    picture: Option<Task<Result<(PathBuf, bool), String>>>,
    after_save: Option<After>,
    watch: Option<Watch>,
    recovery: Recovery,
    wake: egui::Context,
    ordered: Option<Ordered>,
    size: [u32; 2],
}

impl Studio {
    /// An empty scene. Settings and recovery are in `home`.
    pub fn new(wake: &egui::Context, home: PathBuf) -> Studio {
        let (context, of_jobs) = (wake.clone(), wake.clone());
        let settings = Settings::load(&home);
        let found = recovered(&home.join("recovery"));
        Studio {
            document: Document::empty(),
            engine: Engine::new(move || context.request_repaint()),
            frame: None,
            status: Status::default(),
            look: Look::default(),
            paused: false,
            moved: None,
            selection: None,
            also: Vec::new(),
            message: None,
            problem: None,
            dialog: (!found.is_empty()).then_some(Dialog::Recovered(found)),
            recovery: Recovery::new(&home.join("recovery")),
            jobs: Queue::new(&home, move || of_jobs.request_repaint()),
            settings,
            home,
            viewport: ViewportState::default(),
            second: Second::default(),
            swatch: Swatch::default(),
            insight: Insight::default(),
            pixel: PixelValues::default(),
            asking: None,
            queue: Vec::new(),
            reveal: None,
            focus_properties: false,
            quit: false,
            opening: None,
            saving: None,
            picture: None,
            after_save: None,
            watch: None,
            wake: wake.clone(),
            ordered: None,
            size: [640, 480],
        }
    }

    fn waker(&self) -> impl FnOnce() + Send + 'static + use<> {
        let context = self.wake.clone();
        move || context.request_repaint()
    }

    /// The window's context.
    pub fn wake(&self) -> &egui::Context {
        &self.wake
    }

    /// Adds what a text describes.
    pub fn paste(&mut self, text: &str) {
        let pasted = self.document.paste(text);
        if let Some(paths) = self.check(pasted) {
            let names = self.document.desc().names();
            self.selection = paths.last().and_then(|path| Node::of_path(path, &names));
            self.say(format!("Pasted {}", paths.join(", ")));
        }
    }

    /// Selects a part, or nothing. With `more`, what is selected stays, and a part that is selected already is not any more.
    pub fn select(&mut self, node: Option<Node>, more: bool) {
        match node {
            Some(node) if more && self.is_selected(node) => {
                self.also.retain(|other| *other != node);
                if self.selection == Some(node) {
                    self.selection = self.also.pop();
                }
            }
            Some(node) if more => self.also.extend(self.selection.replace(node)),
            _ => {
                self.also.clear();
                self.selection = node;
            }
        }
    }

    /// Whether a part is selected.
    pub fn is_selected(&self, node: Node) -> bool {
        self.selection == Some(node) || self.also.contains(&node)
    }

    /// All selected parts that the scene has.
    pub fn selected(&self) -> Vec<Node> {
        let desc = self.document.desc();
        self.also.iter().copied().chain(self.selection).filter(|node| node.exists(desc)).collect()
    }

    /// Says something.
    pub fn say(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), help: None, is_error: false });
    }

    /// Says what went wrong.
    pub fn fail(&mut self, error: &SceneError) {
        self.message =
            Some(Message { text: error.message.clone(), help: error.help.clone(), is_error: true });
    }

    /// Reports the error of a change, if it is one.
    pub fn check<T>(&mut self, result: Result<T, SceneError>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.fail(&error);
                None
            }
        }
    }

    /// Takes what threads have finished, and the newest frame. Never waits.
    pub fn poll(&mut self) {
        self.poll_opening();
        if let Some(saving) = self.saving.take() {
            match self.document.saved(&saving) {
                None => self.saving = Some(saving),
                Some(Ok(saved)) => {
                    let notes = saved.notes.join("; ");
                    let colon = if notes.is_empty() { "" } else { ": " };
                    self.say(format!("Saved {}{colon}{notes}", self.document.name()));
                    self.watch();
                    self.settings.add_recent(&saving.path);
                    self.settings.save(&self.home);
                    if let Some(after) = self.after_save.take() {
                        self.proceed(after);
                    }
                }
                Some(Err(error)) => {
                    self.after_save = None;
                    self.watch();
                    self.fail(&error);
                }
            }
        }
        if self.watch.as_ref().is_some_and(Watch::take) && self.opening.is_none() {
            match self.document.is_changed() {
                false => self.reload(),
                true => {
                    self.say("The file was changed by another program. Reload shows it; Save replaces it.")
                }
            }
        }
        if let Some(task) = &self.picture
            && let Some(result) = task.poll()
        {
            self.picture = None;
            match result.unwrap_or_else(|fault| Err(fault.to_owned())) {
                Ok((path, true)) => self.say(format!("Saved {}", path.display())),
                Ok((path, false)) => {
                    self.say(format!("Saved {}: the picture was not finished", path.display()))
                }
                Err(text) => self.message = Some(Message { text, help: None, is_error: true }),
            }
        }
        self.jobs.poll();
        self.status = self.engine.status();
        self.frame = self.engine.frame();
        let stand = self.frame.as_ref().map(|frame| &frame.stand);
        self.insight.poll(&self.wake, stand, self.viewport.explained);
        let has_fault = self.status.error.as_ref().is_some_and(|error| error.is_fault);
        self.recovery.keep(&self.document, has_fault);
    }

    /// Whether files are read or written.
    pub fn is_busy(&self) -> bool {
        self.opening.is_some() || self.saving.is_some()
    }

    /// The viewport has this many pixels.
    pub fn set_size(&mut self, size: [u32; 2]) {
        self.size = size;
    }

    /// Threads of each view: all, or half of them while there are two.
    pub fn threads(&self) -> usize {
        match (self.settings.threads, self.second.is_open()) {
            (0, true) => std::thread::available_parallelism().map_or(1, |n| (n.get() / 2).max(1)),
            (n, true) => (n / 2).max(1),
            (n, false) => n,
        }
    }

    /// Something moves: previews are fluent instead of fine.
    pub fn moving(&mut self) {
        self.moved = Some(Instant::now());
    }

    /// Whether something moved a moment ago.
    pub fn is_moving(&self) -> bool {
        self.moved.is_some_and(|at| at.elapsed().as_millis() < 150)
    }

    /// Orders the picture, if it is another one than last time.
    pub fn order(&mut self) {
        let moving = self.is_moving();
        if moving {
            self.wake.request_repaint_after(std::time::Duration::from_millis(160));
        }
        let wanted = Ordered {
            desc: Arc::clone(self.document.desc()),
            look: self.look.clone(),
            size: self.size,
            moving,
            paused: self.paused || self.jobs.pauses_view(),
            threads: self.jobs.view_threads(self.threads()),
        };
        if self.ordered.as_ref().is_some_and(|last| last.is(&wanted)) {
            return;
        }
        let mut order = Order::new(Arc::clone(self.document.desc()));
        order.look = self.look.clone();
        order.size = self.size;
        order.moving = moving;
        (order.paused, order.threads) = (wanted.paused, wanted.threads);
        self.engine.order(order);
        self.ordered = Some(wanted);
    }

    /// Before the program ends.
    pub fn close(&mut self) {
        if self.quit && !self.document.is_changed() {
            self.recovery.clear();
        } else if self.quit {
            // The user chose not to save.
            self.recovery.clear();
        } else {
            self.recovery.keep(&self.document, true);
            self.recovery.finish();
        }
        self.settings.save(&self.home);
    }
}
