//! Temporary.
use std::path::Path;
use turner::SceneDesc;
use turner::schema::SceneError;
use turner_io::scene::{LoadError, Sources};
use turner_io::{LoadOptions, Loaded};
#[derive(Clone, Debug)]
pub struct Opened(Loaded);
#[derive(Clone, Debug, Default)]
pub struct Saved { pub notes: Vec<String> }
impl Opened {
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Opened, LoadError> { turner_io::load_with(path, options).map(Opened) }
    pub fn desc(&self) -> &SceneDesc { &self.0.desc }
    pub fn sources(&self) -> &Sources { &self.0.sources }
}
pub fn save_scene(desc: &SceneDesc, _: Option<&Opened>, out: &Path) -> Result<Saved, SceneError> {
    let options = turner_io::convert::ConvertOptions { overwrite: true, ..Default::default() };
    turner_io::convert::to_toml(desc, out, &options).map(|_| Saved::default())
}
