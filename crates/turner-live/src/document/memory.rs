//! Documents whose files are in memory: those of a web page.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use turner::schema::{ErrorCode, SceneError};
use turner_io::LoadOptions;
use turner_io::assets::{FolderAssets, KeptAssets, MemoryAssets};
use turner_io::edit::{Opened, scene_text};
use turner_io::scene::{LoadError, Loaded, Sources, load_from, load_text};

use super::{Document, Start};

impl Document {
    /// Reads the scene or model `name` among files in memory.
    ///
    /// Errors: those of [`turner_io::scene::load_from`], with the texts that were read.
    pub fn in_memory(
        name: &str,
        files: Arc<MemoryAssets>,
        options: &LoadOptions,
    ) -> Result<Document, LoadError> {
        let loaded = load_from(name, &*files, options)?;
        Ok(Document::loaded(name, files, options, loaded))
    }

    /// Reads a scene or a model on disk, and keeps the files that it reads in memory.
    ///
    /// Errors: those of [`turner_io::scene::load_from`], with the texts that were read.
    pub fn read_into_memory(path: &Path, options: &LoadOptions) -> Result<Document, LoadError> {
        let bare = |error| LoadError { error, sources: Sources::default() };
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            let message = format!("{}: expected the name of a file in UTF-8", path.display());
            return Err(bare(SceneError::new(ErrorCode::File, message)));
        };
        let folder = FolderAssets::new(path.parent().unwrap_or(Path::new("")));
        let folder = folder.map_err(|e| bare(e.to_scene_error()))?.with_limits(options.limits.clone());
        let kept = KeptAssets::new(folder, name);
        let loaded = load_from(name, &kept, options)?;
        Ok(Document::loaded(name, Arc::new(kept.into_memory()), options, loaded))
    }

    /// A scene of the gallery, with its files in memory; `files` replace its own.
    ///
    /// Errors: those of reading it.
    pub fn start_in_memory(
        start: &Start,
        files: Vec<(String, Vec<u8>)>,
        options: &LoadOptions,
    ) -> Result<Document, LoadError> {
        let name = format!("{}.toml", start.file);
        let own = start.files.iter().map(|&(file, bytes)| (file.to_owned(), bytes.to_vec()));
        let own = own.chain([(name.clone(), start.text.as_bytes().to_vec())]);
        let files = own.chain(files).collect();
        let mut document = Document::in_memory(&name, Arc::new(MemoryAssets { files }), options)?;
        document.title = start.name.to_owned();
        Ok(document)
    }

    fn loaded(name: &str, files: Arc<MemoryAssets>, options: &LoadOptions, loaded: Loaded) -> Document {
        let opened = Opened::of(Path::new(name), options, loaded);
        let mut document = Document::of(opened.desc.clone(), name.to_owned(), PathBuf::new());
        document.sources = Arc::new(opened.sources.clone());
        document.opened = Some(Arc::new(opened));
        document.memory = Some(files);
        document
    }

    /// Replaces the scene by that of a text; its files and its history stay.
    ///
    /// Errors: those of reading the text. The scene then stays the same.
    pub fn set_text(&mut self, text: &str, options: &LoadOptions) -> Result<(), LoadError> {
        let files = self.memory.clone().unwrap_or_default();
        let name = self.text_name();
        let loaded = load_text(text.to_owned(), &name, &*files, options)?;
        let mut fresh = Document::loaded(&name, files, options, loaded);
        fresh.title = self.title.clone();
        self.memory = fresh.memory.clone();
        self.reloaded_as("Edit the text", Some("text"), fresh);
        Ok(())
    }

    /// Its files, if they are in memory.
    pub fn memory(&self) -> Option<&Arc<MemoryAssets>> {
        self.memory.as_ref()
    }

    /// The bytes of its files, if they are in memory.
    pub fn bytes_in_memory(&self) -> Option<usize> {
        self.memory.as_ref().map(|memory| memory.files.values().map(Vec::len).sum())
    }

    /// The name that its text has in messages.
    pub fn text_name(&self) -> String {
        let own = self.opened.as_ref().map(|opened| opened.path.to_string_lossy().into_owned());
        own.filter(|name| name.ends_with(".toml")).unwrap_or_else(|| "scene.toml".to_owned())
    }

    /// The scene as a text: see [`scene_text`].
    ///
    /// Errors: a scene that has no text, and why.
    pub fn text(&self) -> Result<String, SceneError> {
        let assets = self.assets(false)?;
        scene_text(&self.desc, self.opened.as_deref(), &*assets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::STARTS;
    use turner::schema::value::Data;

    fn start(name: &str) -> Document {
        let start = STARTS.iter().find(|start| start.name == name).unwrap();
        Document::start_in_memory(start, Vec::new(), &LoadOptions::default()).unwrap()
    }

    #[test]
    fn every_start_is_read_from_memory_and_has_its_own_text() {
        for start in STARTS {
            let document = Document::start_in_memory(start, Vec::new(), &LoadOptions::default())
                .unwrap_or_else(|e| panic!("{}: {}", start.name, e.error));
            assert_eq!(document.name(), start.name);
            assert_eq!(document.text().unwrap(), start.text, "{}", start.name);
        }
    }

    #[test]
    fn an_edit_changes_the_text_and_a_text_changes_the_scene() {
        let mut document = start("9. Reflection and texture");
        document.set("Move", None, &[("object.0.radius".into(), Data::Number(1.25))]).unwrap();
        let text = document.text().unwrap();
        assert!(text.contains("radius = 1.25"), "{text}");
        assert_ne!(text, document.opened.as_ref().unwrap().sources.files()[0].text);
        let changed = text.replace("radius = 1.25", "radius = 1.5");
        document.set_text(&changed, &LoadOptions::default()).unwrap();
        assert_eq!(document.text().unwrap(), changed);
        document.undo().unwrap();
        document.undo().unwrap();
        assert!(!document.text().unwrap().contains("1.25"));
        let error = document.set_text("[[object]]\ntype = \"spher\"", &LoadOptions::default()).unwrap_err();
        assert_eq!(error.location().map(|at| at.line), Some(2));
    }

    #[test]
    fn a_scene_on_disk_keeps_the_files_that_it_reads() {
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/classic/002-box-sphere-plane.toml");
        let options = LoadOptions::default();
        let mut document = Document::read_into_memory(Path::new(scenes), &options).unwrap();
        let names: Vec<&String> = document.memory().unwrap().files.keys().collect();
        assert_eq!(names, ["002-box-sphere-plane.toml", "textures/marble.png", "textures/wood.png"]);
        let text = document.text().unwrap();
        assert_eq!(text, std::fs::read_to_string(scenes).unwrap());
        document.set_text(&text.replace("marble.png", "wood.png"), &options).unwrap();
        let error = document.set_text(&text.replace("marble.png", "../../../README.md"), &options);
        assert!(error.is_err());
        let missing = Path::new(scenes).with_file_name("missing.toml");
        assert!(Document::read_into_memory(&missing, &options).is_err());
    }

    #[test]
    fn a_model_in_memory_becomes_a_short_text() {
        let obj = b"v -1 0 -1\nv 1 0 -1\nv 1 0 1\nf 1 2 3\n".to_vec();
        let files = MemoryAssets { files: [("models/roof.obj".to_owned(), obj)].into() };
        let mut document =
            Document::in_memory("models/roof.obj", Arc::new(files), &LoadOptions::default()).unwrap();
        let text = document.text().unwrap();
        assert!(text.contains("roof.obj") && text.contains("[studio]"), "{text}");
        document.set_text(&text, &LoadOptions::default()).unwrap();
        assert_eq!(document.desc().objects.len(), 1);
    }
}
