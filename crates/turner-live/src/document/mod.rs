//! A document: a scene that is edited, with its history, its file and its state on disk.
//!
//! Every change goes through [`Document::edit`] or [`Document::set`]. It makes a new description; the old one goes to the
//! history, so undo and redo exchange pointers and cannot lose anything. Meshes and images are shared between
//! descriptions.

mod history;
mod memory;
mod open;
mod recovery;
mod save;
mod starts;
mod watch;

pub use open::{OpenError, Opening, readable};
pub use recovery::{Recovered, Recovery, recovered};
pub use save::Saving;
pub use starts::{STARTS, Start};
pub use watch::Watch;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tempfile::TempDir;
use turner::SceneDesc;
use turner::description::ModelDesc;
use turner::schema::value::Data;
use turner::schema::{Asset, KeyEdit, SceneError, Warning};
use turner_io::assets::{AssetSource, FolderAssets, MemoryAssets};
use turner_io::scene::{SceneFiles, Sources};

use history::History;

/// A scene while it is edited.
pub struct Document {
    desc: Arc<SceneDesc>,
    history: History,
    /// The description on disk.
    saved: Arc<SceneDesc>,
    /// Its file; `None` for a scene that was never saved.
    path: Option<PathBuf>,
    /// Its name, if it has no file.
    title: String,
    /// The folder that relative files are read from.
    folder: PathBuf,
    /// Its files, if they are not on disk.
    memory: Option<Arc<MemoryAssets>>,
    /// Holds the files of a scene of the gallery.
    _temporary: Option<Arc<TempDir>>,
    opened: Option<Arc<turner_io::edit::Opened>>,
    sources: Arc<Sources>,
    /// Its files as they were when they were read or written.
    stamps: Arc<Vec<(PathBuf, watch::Stamp)>>,
    revision: u64,
}

impl Document {
    /// An empty scene: physically based, with the default studio's lights and floor.
    pub fn empty() -> Document {
        let text = "[integrator]\ntype = \"path\"\n\n[studio]\n";
        let assets = turner_io::assets::MemoryAssets::default();
        let loaded =
            turner_io::scene::load_text(text.to_owned(), "untitled.toml", &assets, &Default::default());
        let desc = loaded.map(|loaded| loaded.desc).unwrap_or_default();
        let folder = std::env::current_dir().unwrap_or_default();
        Document::of(desc, "Untitled".into(), folder)
    }

    /// A document without a file.
    pub fn of(desc: SceneDesc, title: String, folder: PathBuf) -> Document {
        let desc = Arc::new(desc);
        Document {
            saved: Arc::clone(&desc),
            desc,
            history: History::default(),
            path: None,
            title,
            folder,
            memory: None,
            _temporary: None,
            opened: None,
            sources: Arc::default(),
            stamps: Arc::default(),
            revision: 0,
        }
    }

    /// The scene.
    pub fn desc(&self) -> &Arc<SceneDesc> {
        &self.desc
    }

    /// A number that changes with every change of the scene.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Its file.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The folder that relative files are read from.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The texts that it was read from.
    pub fn sources(&self) -> &Arc<Sources> {
        &self.sources
    }

    /// The name of its file, or its title.
    pub fn name(&self) -> String {
        let file = self.path.as_ref().and_then(|path| path.file_name());
        file.map_or_else(|| self.title.clone(), |name| name.to_string_lossy().into_owned())
    }

    /// Whether it differs from its file.
    pub fn is_changed(&self) -> bool {
        !Arc::ptr_eq(&self.desc, &self.saved)
    }

    /// What was ignored or is doubtful in its files.
    pub fn warnings(&self) -> &[Warning] {
        &self.desc.warnings
    }

    /// Changes the scene. `label` names the change in the history. Changes with the same `merge` that follow one another
    /// are one step of the history, such as the movements of one drag.
    ///
    /// Errors: those of `change`. The scene then stays the same.
    pub fn edit<T>(
        &mut self,
        label: &str,
        merge: Option<&str>,
        change: impl FnOnce(&mut SceneDesc) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        let mut next = SceneDesc::clone(&self.desc);
        let result = change(&mut next)?;
        if !is_same(&next, &self.desc) {
            let before = std::mem::replace(&mut self.desc, Arc::new(next));
            self.history.push(label, merge, before);
            self.revision += 1;
        }
        Ok(result)
    }

    /// Sets values by their key paths: see [`SceneDesc::edit`]. Files are those of the scene's folder, and others that the
    /// user names.
    ///
    /// Errors: those of reading the values. The scene then stays the same.
    pub fn set(
        &mut self,
        label: &str,
        merge: Option<&str>,
        edits: &[(String, Data)],
    ) -> Result<(), SceneError> {
        let edits: Vec<KeyEdit> = edits.iter().map(|(path, data)| KeyEdit::new(path, data.clone())).collect();
        self.apply(label, merge, &edits)
    }

    /// Makes edits: see [`Document::set`].
    ///
    /// Errors: those of reading the values. The scene then stays the same.
    pub fn apply(&mut self, label: &str, merge: Option<&str>, edits: &[KeyEdit]) -> Result<(), SceneError> {
        let assets = self.assets(true)?;
        self.edit(label, merge, |desc| {
            let sources = Sources::default();
            desc.edit(edits, &mut SceneFiles::new(&*assets, &sources))
        })
    }

    /// What its files are read from. The user may name files outside the scene's folder (`anywhere`), a text may not.
    fn assets(&self, anywhere: bool) -> Result<Box<dyn AssetSource>, SceneError> {
        if let Some(memory) = &self.memory {
            return Ok(Box::new(MemoryAssets::clone(memory)));
        }
        let folder = FolderAssets::new(&self.folder).map_err(|e| e.to_scene_error())?;
        Ok(Box::new(folder.allow_outside(anywhere)))
    }

    /// The text of parts, by their key paths, with what they refer to.
    ///
    /// Errors: a path that names no part.
    pub fn copy(&self, paths: &[String]) -> Result<String, SceneError> {
        turner_io::edit::copy(&self.desc, paths)
    }

    /// Adds the parts in a text and returns their key paths. Files that it names must lie in the scene's folder.
    ///
    /// Errors: those of reading a scene, with line and column of the text.
    pub fn paste(&mut self, text: &str) -> Result<Vec<String>, SceneError> {
        let assets = self.assets(false)?;
        self.edit("Paste", None, |desc| {
            let sources = Sources::default();
            turner_io::edit::paste(desc, text, &mut SceneFiles::new(&*assets, &sources))
        })
    }

    /// A path relative to the scene's folder, if it lies there.
    fn beside(&self, path: &Path) -> PathBuf {
        let folder = std::path::absolute(&self.folder).unwrap_or_else(|_| self.folder.clone());
        let file = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        file.strip_prefix(&folder).map(Path::to_owned).unwrap_or(file)
    }

    /// Adds a model file as an object and returns its key path.
    ///
    /// Errors: those of reading the model.
    pub fn add_model(&mut self, path: &Path) -> Result<String, SceneError> {
        let file = if self.memory.is_some() { path.to_owned() } else { self.beside(path) };
        let file = file.to_string_lossy().replace('\\', "/");
        let name =
            path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy().into_owned());
        let model = ModelDesc { file, ..ModelDesc::default() };
        let assets = self.assets(true)?;
        self.edit(&format!("Add {name}"), None, |desc| {
            let sources = Sources::default();
            desc.add_model(&name, &model, &mut SceneFiles::new(&*assets, &sources))
        })
    }

    /// Sets a key of a model that is placed in the scene, and reads its file again: see [`SceneDesc::set_model_key`].
    ///
    /// Errors: those of reading the model. The scene then stays the same.
    pub fn set_model_key(&mut self, object: usize, key: &str, value: Option<Data>) -> Result<(), SceneError> {
        let assets = self.assets(true)?;
        let label = format!("Model: {}", key.replace('_', " "));
        self.edit(&label, Some(&label), |desc| {
            let sources = Sources::default();
            desc.set_model_key(object, key, value, &mut SceneFiles::new(&*assets, &sources))
        })
    }

    /// Gives a part another name and returns its key path: see [`SceneDesc::rename`].
    ///
    /// Errors: a name that is taken, or that a scene file cannot have. The scene then stays the same.
    pub fn rename(&mut self, path: &str, name: &str) -> Result<String, SceneError> {
        self.edit(&format!("Rename to {name}"), None, |desc| desc.rename(path, name))
    }

    /// Ends a gesture: the next change with the same `merge` is a step of its own.
    pub fn end_gesture(&mut self) {
        self.history.end_gesture();
    }

    /// Takes the last step back. Returns its label.
    pub fn undo(&mut self) -> Option<String> {
        let (label, desc) = self.history.undo(&self.desc)?;
        self.desc = desc;
        self.revision += 1;
        Some(label)
    }

    /// Takes the last undo back. Returns the label of the step.
    pub fn redo(&mut self) -> Option<String> {
        let (label, desc) = self.history.redo(&self.desc)?;
        self.desc = desc;
        self.revision += 1;
        Some(label)
    }

    /// The labels of the steps that can be undone, the oldest first, and of those that can be redone, the next first.
    pub fn steps(&self) -> (Vec<&str>, Vec<&str>) {
        self.history.labels()
    }

    /// The scene's file was read again, without success: it is watched for the next change.
    pub fn not_reloaded(&mut self, error: &OpenError) {
        self.stamps = Arc::new(vec![(error.path.clone(), error.stamp.as_deref().copied())]);
    }

    /// Replaces the scene by that of the same file read again; the history continues, so that a reload can be undone.
    pub fn reloaded(&mut self, fresh: Document) {
        self.reloaded_as("Reload", None, fresh);
    }

    /// The same with another label in the history.
    fn reloaded_as(&mut self, label: &str, merge: Option<&str>, fresh: Document) {
        let before = std::mem::replace(&mut self.desc, Arc::clone(&fresh.desc));
        if !is_same(&before, &self.desc) {
            self.history.push(label, merge, before);
        }
        (self.saved, self.sources, self.opened) = (fresh.saved, fresh.sources, fresh.opened);
        self.stamps = fresh.stamps;
        self.revision += 1;
    }
}

/// Whether nothing was changed. Meshes and images are compared by identity: their contents may be large.
fn is_same(a: &SceneDesc, b: &SceneDesc) -> bool {
    fn shared<T>(a: &[Asset<T>], b: &[Asset<T>]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(&a.data, &b.data))
    }
    shared(&a.images, &b.images)
        && shared(&a.meshes, &b.meshes)
        && a.objects == b.objects
        && a.camera == b.camera
        && a.film == b.film
        && a.integrator == b.integrator
        && a.background == b.background
        && a.textures == b.textures
        && a.materials == b.materials
        && a.media == b.media
        && a.groups == b.groups
        && a.lights == b.lights
        && a.cameras == b.cameras
        && a.studio == b.studio
}

#[cfg(test)]
mod tests;
