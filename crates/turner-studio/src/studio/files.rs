//! Files: opening, reloading, saving, what a file is chosen for.

use std::path::Path;

use turner::schema::value::{Data, Span, Table, Value};
use turner_live::document::{Document, Opening, Watch};
use turner_live::engine::{Look, Stage};

use super::{After, Dialog, Purpose, Studio};
use crate::insight::Insight;
use crate::node::Node;
use crate::pixel::PixelValues;
use crate::task::Task;
use crate::viewport::ViewportState;

impl Studio {
    /// Does what a file was chosen for.
    pub fn chosen(&mut self, purpose: Purpose, path: &Path) {
        match purpose {
            Purpose::Open => self.leave(After::Open(path.to_owned())),
            Purpose::Save => {
                let after = self.take_after_save();
                self.save_to(path, after);
            }
            Purpose::Model => {
                let added = self.document.add_model(path);
                if let Some(path) = self.check(added) {
                    self.selection = Node::of_path(&path, &self.document.desc().names());
                }
            }
            Purpose::Picture => self.save_picture(path),
            Purpose::Key(key, is_texture) => {
                let name = path.strip_prefix(self.document.folder()).unwrap_or(path);
                let data = Data::String(name.to_string_lossy().into_owned());
                let data = match is_texture {
                    true => {
                        let mut table = Table::default();
                        table.set("type", Span::NONE, Value::new(Data::String("image".into())));
                        table.set("file", Span::NONE, Value::new(data));
                        Data::Table(table)
                    }
                    false => data,
                };
                let result = self.document.set("Choose a file", None, &[(key, data)]);
                self.check(result);
            }
        }
    }

    /// Writes the shown picture to a file, in a thread.
    fn save_picture(&mut self, path: &Path) {
        let Some(frame) = self.frame.clone() else {
            self.say("There is no picture yet");
            return;
        };
        let path = if path.extension().is_none() { path.with_extension("png") } else { path.to_owned() };
        self.picture = Some(Task::start(&self.wake, move |_| {
            let samples = match frame.stage {
                Stage::Preview => 0,
                Stage::Film { samples, .. } => samples,
                Stage::Settled => frame.stand.prepared.view.film.samples_per_pixel(),
            };
            let software = format!("Turner {}", env!("CARGO_PKG_VERSION"));
            let header = [("Software", software), ("turner:samples", samples.to_string())];
            let metadata =
                header.map(|(key, value)| (key.to_owned(), value.as_str().into())).into_iter().collect();
            let transfer = match frame.transform.transfer {
                turner::color::Transfer::None => turner_io::image::Transfer::Unstated,
                _ => turner_io::image::Transfer::Srgb,
            };
            let options = turner_io::SaveOptions { metadata, transfer, ..Default::default() };
            let saved = turner_io::save_with(&path, &*frame.picture, &options);
            let finished = frame.stage == Stage::Settled;
            saved.map(|()| (path, finished)).map_err(|error| error.to_string())
        }));
    }

    /// Starts reading a file. The scene stays until it is read.
    pub fn open(&mut self, path: &Path) {
        self.problem = None;
        self.opening = Some((Opening::start(path.to_owned(), self.waker()), false));
    }

    /// The file that is being read.
    pub fn opening(&self) -> Option<&Path> {
        self.opening.as_ref().map(|(opening, _)| opening.path())
    }

    /// Reads the scene's file again.
    pub fn reload(&mut self) {
        if let Some(path) = self.document.path() {
            self.opening = Some((Opening::start(path.to_owned(), self.waker()), true));
        }
    }

    /// Asks about unsaved changes, if there are any, and then does `after`.
    pub fn leave(&mut self, after: After) {
        if matches!(after, After::Quit) && self.jobs.is_busy() && !self.jobs.held {
            self.dialog = Some(Dialog::Jobs);
            return;
        }
        match self.document.is_changed() {
            true => self.dialog = Some(Dialog::Unsaved(after)),
            false => self.proceed(after),
        }
    }

    /// Does what the question about unsaved changes was about.
    pub fn proceed(&mut self, after: After) {
        match after {
            After::Open(path) => self.open(&path),
            After::New => self.show(Document::empty()),
            After::Start(start) => match Document::start(start) {
                Ok(document) => self.show(document),
                Err(error) => self.problem = Some(error),
            },
            After::Quit => self.quit = true,
        }
    }

    /// Shows another document.
    pub fn show(&mut self, document: Document) {
        self.recovery.clear();
        self.document = document;
        self.select(None, false);
        self.look = Look::default();
        self.problem = None;
        self.message = None;
        self.viewport = ViewportState::default();
        self.insight = Insight::default();
        self.pixel = PixelValues::default();
        self.watch();
        if let Some(path) = self.document.path() {
            self.settings.add_recent(path);
            self.settings.save(&self.home);
        }
        let doubts = self.document.warnings().len();
        if doubts > 0 {
            let first = self.document.warnings()[0].message.clone();
            let more = if doubts > 1 { format!(" (and {} more)", doubts - 1) } else { String::new() };
            self.say(format!("{first}{more}"));
        }
    }

    pub(super) fn watch(&mut self) {
        let context = self.wake.clone();
        let wake = move || context.request_repaint();
        self.watch = Watch::new(&self.document, wake);
    }

    /// Starts saving to a file, and does `after` once it is saved.
    pub fn save_to(&mut self, path: &Path, after: Option<After>) {
        let path = match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("toml") => path.to_owned(),
            // A model or a scene of another renderer is saved beside it, as a scene of Turner.
            _ => path.with_extension("toml"),
        };
        self.after_save = after;
        self.watch = None;
        self.saving = Some(self.document.save(&path, self.waker()));
    }

    /// Saves to the scene's file, or asks for one.
    pub fn save(&mut self, after: Option<After>) {
        match self.document.path().map(Path::to_owned) {
            Some(path) => self.save_to(&path, after),
            None => {
                self.after_save = after;
                let name = self.document.folder().join("untitled.toml");
                self.dialog =
                    Some(Dialog::File { purpose: Purpose::Save, name: name.to_string_lossy().into_owned() });
            }
        }
    }

    /// What follows the save that the file dialog is about.
    pub fn take_after_save(&mut self) -> Option<After> {
        self.after_save.take()
    }

    pub(super) fn poll_opening(&mut self) {
        let Some((opening, is_reload)) = self.opening.take() else { return };
        match opening.poll() {
            None => self.opening = Some((opening, is_reload)),
            Some(Ok(document)) if is_reload => {
                self.problem = None;
                self.document.reloaded(document);
                self.watch();
            }
            Some(Ok(document)) => self.show(document),
            // The last good scene stays.
            Some(Err(error)) => {
                if is_reload {
                    self.document.not_reloaded(&error);
                    self.watch();
                }
                self.problem = Some(error);
            }
        }
    }
}
