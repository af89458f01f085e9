//! Embree 4, loaded at run time: a measure for Turner's own trees, and not needed for anything else.
//!
//! Nothing is linked. [`Embree::load`] opens a shared library that the user names (`libembree4.so.4`, `embree4.dll`),
//! a [`Device`] builds [`Scene`]s with a number of threads, and these answer the rays of `turner_bvh`, one at a time or
//! in [packets](Packets) of 16.
//!
//! Loading a library runs its code, as running a program does: whoever names the file vouches for it. That it is
//! Embree 4 is checked as far as its symbols and its version tell.

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
        // SAFETY: as above; names beginning with `rtc` are Embree's, and the version is checked by every device.
        let functions = unsafe { Functions::find(library) }.map_err(failed)?;
        Ok(Embree { functions: Arc::new(functions) })
    }
}

/// What the system says about a library, with the cause that `Display` of the error leaves out.
fn reason(error: &libloading::Error) -> String {
    let mut text = error.to_string();
    if let Some(cause) = std::error::Error::source(error) {
        text += &format!(": {cause}");
    }
    text
}

/// Why Embree does not answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EmbreeError {
    /// The library or one of its functions cannot be loaded; the system's words.
    Load(String),
    /// Not version 4: 10000 times the major version plus 100 times the minor one plus the patch level.
    Version(i64),
    /// A triangle names a vertex that its mesh does not have, or an instance such a mesh.
    Index {
        /// The index.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// Embree's own error, by the name in its documentation.
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
            EmbreeError::Index { index, count } => write!(f, "index {index} of only {count}"),
            EmbreeError::Device(name) => write!(f, "Embree answers {name}"),
        }
    }
}

impl std::error::Error for EmbreeError {}
