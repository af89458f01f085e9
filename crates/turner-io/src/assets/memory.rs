//! Assets in memory.

use std::collections::BTreeMap;

use super::{AssetError, AssetSource, nearest, normalise, percent_decode, printable, relative};

/// Assets in memory, for tests and for callers that already have the bytes.
#[derive(Clone, Debug, Default)]
pub struct MemoryAssets {
    /// Bytes by name; `/` separates the parts of a name.
    pub files: BTreeMap<String, Vec<u8>>,
}

impl AssetSource for MemoryAssets {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        let decoded = percent_decode(uri)?;
        for spelling in [uri, &decoded] {
            let name = normalise(relative(spelling)?, uri)?;
            let Some(bytes) = self.files.get(&name) else { continue };
            let size = bytes.len() as u64;
            if size > limit {
                return Err(AssetError::TooLarge { uri: printable(uri), size, limit });
            }
            return Ok(bytes.clone());
        }
        let nearest = nearest(uri, self.files.keys().map(String::as_str))
            .map_or_else(String::new, |n| format!("; the nearest is \"{}\"", printable(n)));
        Err(AssetError::Missing { uri: printable(uri), folder: "memory".to_owned(), nearest })
    }

    fn describe(&self, uri: &str) -> String {
        printable(uri)
    }
}
