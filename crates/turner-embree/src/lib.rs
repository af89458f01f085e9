//! Embree 4, loaded at run time: a reference to compare Turner's BVHs with. Nothing else needs it.
//!
//! Nothing is linked. [`Embree::load`] opens a shared library that the user names (`libembree4.so.4`, `embree4.dll`).
//! A [`Device`] builds [`Scene`]s with a number of threads, and scenes trace the rays of `turner_bvh`, singly or in
//! [packets](Packets) of 16.
//!
//! Loading a library runs its code, so only load a file that you trust. The crate checks that it is Embree 4 by its
//! symbols and its version.

mod device;
mod ffi;
mod packets;
mod scene;

use std::fmt;
use std::path::Path;
use std::sync::Arc;

pub use device::Device;
pub use packets::Packets;
pub use scene::{Geometry, Hit, Instance, Mesh, Quality, Scene, SceneOptions};

use ffi::Functions;

/// The loaded library.
#[derive(Clone, Debug)]
pub struct Embree {
    functions: Arc<Functions>,
}

impl Embree {
    /// Loads the shared library: a path, or a name for the system to search for.
    pub fn load(path: &Path) -> Result<Embree, EmbreeError> {
        let failed = |e: libloading::Error| EmbreeError::Load(reason(&e));
        // SAFETY: the user vouches for the library they name; its initialisers run as a program's would.
        let library = unsafe { libloading::Library::new(path) }.map_err(failed)?;
        // SAFETY: as above; names that begin with `rtc` are Embree's, and every device checks the version.
        let functions = unsafe { Functions::find(library) }.map_err(failed)?;
        Ok(Embree { functions: Arc::new(functions) })
    }
}

/// The error with its cause, which its `Display` omits.
fn reason(error: &libloading::Error) -> String {
    let mut text = error.to_string();
    if let Some(cause) = std::error::Error::source(error) {
        text += &format!(": {cause}");
    }
    text
}

/// Why Embree cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EmbreeError {
    /// The library or one of its functions cannot be loaded: the system's message.
    Load(String),
    /// The library is not version 4: 10000 * major + 100 * minor + patch.
    Version(i64),
    /// A triangle refers to a vertex, or an instance to a mesh, that does not exist.
    Index {
        /// The index.
        index: u32,
        /// Number of vertices or meshes.
        count: usize,
    },
    /// An error of Embree, by its documented name.
    Device(&'static str),
}

impl fmt::Display for EmbreeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EmbreeError::Load(reason) => write!(f, "Embree cannot be loaded: {reason}"),
            EmbreeError::Version(version) => {
                let (major, minor, patch) = (version / 10_000, version / 100 % 100, version % 100);
                write!(f, "this is Embree {major}.{minor}.{patch}; version 4 is needed")
            }
            EmbreeError::Index { index, count } => {
                write!(f, "index {index} is out of range: there are {count}")
            }
            EmbreeError::Device(name) => write!(f, "Embree failed: {name}"),
        }
    }
}

impl std::error::Error for EmbreeError {}
