//! Where the library is looked for.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::{Oidn, OidnError};

/// The environment variable that names the library or its folder.
pub const VARIABLE: &str = "TURNER_OIDN";

/// The file name of the library.
pub const LIBRARY: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

pub(crate) fn find() -> Result<Oidn, OidnError> {
    if let Some(named) = std::env::var_os(VARIABLE).filter(|named| !named.is_empty()) {
        return named_by_user(named);
    }
    let mut places = beside_program();
    if let Some(found) = places.iter().find(|place| place.is_file()) {
        return Oidn::load(found);
    }
    Oidn::load(Path::new(LIBRARY)).map_err(|error| {
        places.push(PathBuf::from(LIBRARY));
        match error {
            OidnError::Load(_) => {
                OidnError::Missing(places.iter().map(|p| p.display().to_string()).collect())
            }
            other => other,
        }
    })
}

/// The file, or the library in the folder or in its `lib`.
fn named_by_user(named: OsString) -> Result<Oidn, OidnError> {
    let named = PathBuf::from(named);
    if !named.is_dir() {
        return Oidn::load(&named);
    }
    let places = [named.join(LIBRARY), named.join("lib").join(LIBRARY)];
    match places.iter().find(|place| place.is_file()) {
        Some(place) => Oidn::load(place),
        None => Err(OidnError::Missing(places.iter().map(|p| p.display().to_string()).collect())),
    }
}

/// In `lib` beside the folder of the program, and in that folder.
fn beside_program() -> Vec<PathBuf> {
    let program = std::env::current_exe().unwrap_or_default();
    let Some(folder) = program.parent() else { return Vec::new() };
    [folder.parent().map(|above| above.join("lib").join(LIBRARY)), Some(folder.join(LIBRARY))]
        .into_iter()
        .flatten()
        .collect()
}
