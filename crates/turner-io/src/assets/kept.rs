//! A scene's folder whose files are kept in memory when they are read.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::{AssetError, AssetSource, FolderAssets, MemoryAssets, normalise, relative};

/// See the module. A file is read from disk once.
#[derive(Debug)]
pub struct KeptAssets {
    folder: FolderAssets,
    /// The file that the user named: a link may lead anywhere.
    named: String,
    files: Mutex<BTreeMap<String, Vec<u8>>>,
}

impl KeptAssets {
    /// The folder of the scene file `named` in it.
    pub fn new(folder: FolderAssets, named: &str) -> KeptAssets {
        KeptAssets { folder, named: named.to_owned(), files: Mutex::default() }
    }

    /// The files that were read, by the names that they were asked for.
    pub fn into_memory(self) -> MemoryAssets {
        MemoryAssets { files: self.files.into_inner().unwrap_or_else(PoisonError::into_inner) }
    }

    /// The file's name in memory. Files outside the folder have none.
    fn name(&self, uri: &str) -> Option<String> {
        normalise(relative(uri).ok()?, uri).ok()
    }
}

impl AssetSource for KeptAssets {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        let name = self.name(uri);
        let files = || self.files.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = name.as_ref().and_then(|name| files().get(name).cloned());
        if let Some(bytes) = kept.filter(|bytes| bytes.len() as u64 <= limit) {
            return Ok(bytes);
        }
        let bytes = match uri == self.named {
            true => self.folder.clone().allow_outside(true).read(uri, limit)?,
            false => self.folder.read(uri, limit)?,
        };
        if let Some(name) = name {
            files().insert(name, bytes.clone());
        }
        Ok(bytes)
    }

    fn describe(&self, uri: &str) -> String {
        self.folder.describe(uri)
    }

    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        self.folder.resolve(from, uri)
    }
}
