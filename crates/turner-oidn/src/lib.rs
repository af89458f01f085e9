//! Intel Open Image Denoise (OIDN) 2, loaded at run time, as a [`Denoiser`]. Nothing is linked.
//!
//! [`Oidn::find`] looks where the user says, beside the program and where the system keeps libraries. The result depends
//! on the version of the library and on the processor; that of Turner's own denoiser does not.
//!
//! Loading a library runs its code, so only name a file that you trust. The crate checks that it is OIDN 2 by its symbols
//! and its version.

mod device;
mod ffi;
mod search;

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use turner::denoise::{Buffers, Denoiser, Rgb};

use device::{Device, Filter};
use ffi::Functions;
pub use search::{LIBRARY, VARIABLE};

/// How much time OIDN takes for how clean a picture, as it names it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// For pictures in motion.
    Fast,
    /// The default.
    #[default]
    Balanced,
    /// Slowest.
    High,
}

/// The loaded library.
#[derive(Clone, Debug)]
pub struct Oidn {
    functions: Arc<Functions>,
    quality: Quality,
    version: i32,
}

impl Oidn {
    /// Loads the first library that is found: the file or folder that the environment variable [`VARIABLE`] names, or
    /// without it `lib` beside the folder of the program, the program's own folder, and where the system looks for
    /// [`LIBRARY`].
    pub fn find() -> Result<Oidn, OidnError> {
        search::find()
    }

    /// Loads the shared library: a path, or a name for the system to search for.
    pub fn load(path: &Path) -> Result<Oidn, OidnError> {
        let failed = |e: libloading::Error| OidnError::Load(reason(&e));
        // SAFETY: the user vouches for the library they name; its initialisers run as a program's would.
        let library = unsafe { libloading::Library::new(path) }.map_err(failed)?;
        // SAFETY: as above; names that begin with `oidn` are OIDN's, and the version is checked.
        let functions = Arc::new(unsafe { Functions::find(library) }.map_err(failed)?);
        let version = Device::new(&functions, 1)?.version();
        match version / 10_000 {
            2 => Ok(Oidn { functions, quality: Quality::default(), version }),
            _ => Err(OidnError::Version(version)),
        }
    }

    /// The same library with another quality.
    pub fn with_quality(self, quality: Quality) -> Oidn {
        Oidn { quality, ..self }
    }
}

impl Denoiser for Oidn {
    fn name(&self) -> String {
        format!("OIDN {}", Version(self.version))
    }

    fn denoise(&self, buffers: &Buffers, threads: usize) -> Result<Vec<Rgb>, String> {
        let color = buffers.colors(threads);
        let plane =
            |of: fn(&[f32]) -> Rgb| buffers.guides.iter().map(|guides| of(guides)).collect::<Vec<Rgb>>();
        let mut albedo = plane(|guides| [guides[0], guides[1], guides[2]].map(|v| v.clamp(0.0, 1.0)));
        let mut normal = plane(|guides| [guides[3], guides[4], guides[5]].map(|v| v.clamp(-1.0, 1.0)));
        let mut color = color;
        let mut out = vec![[0.0; 3]; color.len()];
        let device = Device::new(&self.functions, threads).map_err(|e| e.to_string())?;
        let mut filter = Filter::new(&device, [buffers.width, buffers.height]).map_err(|e| e.to_string())?;
        filter.image(c"color", &mut color);
        filter.image(c"albedo", &mut albedo);
        filter.image(c"normal", &mut normal);
        filter.image(c"output", &mut out);
        filter.run(self.quality).map_err(|e| e.to_string())?;
        drop(filter);
        match out.iter().flatten().all(|v| v.is_finite()) {
            true => Ok(out),
            false => Err("its picture has values that are not numbers".to_owned()),
        }
    }
}

/// A version: 10000 * major + 100 * minor + patch.
struct Version(i32);

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.0 / 10_000, self.0 / 100 % 100, self.0 % 100)
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

/// Why OIDN cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OidnError {
    /// No library was found; the places where it was looked for.
    Missing(Vec<String>),
    /// The library or one of its functions cannot be loaded: the system's message.
    Load(String),
    /// The library is not OIDN 2. The version found, as 10000 * major + 100 * minor + patch.
    Version(i32),
    /// An error of OIDN: its message.
    Device(String),
}

impl fmt::Display for OidnError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            OidnError::Missing(places) => write!(f, "OIDN was not found: looked for {}", places.join(", ")),
            OidnError::Load(reason) => write!(f, "OIDN cannot be loaded: {reason}"),
            OidnError::Version(version) => {
                write!(f, "this is OIDN {}; version 2 is needed", Version(*version))
            }
            OidnError::Device(message) => write!(f, "OIDN failed: {message}"),
        }
    }
}

impl std::error::Error for OidnError {}
