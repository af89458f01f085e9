//! Metadata of image files: the scene's hash, seed, sample count and so on, by name.

use super::{ImageError, ImageFormat};
use std::collections::BTreeMap;

/// Metadata by name. It is written in the order of the names, so that files are reproducible.
pub type Metadata = BTreeMap<String, MetaValue>;

/// A metadata value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MetaValue {
    /// Text without NUL.
    Text(String),
    /// An integer: an `int` attribute in EXR, decimal text in PNG. Larger integers must be text.
    Integer(i32),
}

impl std::fmt::Display for MetaValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text(t) => f.write_str(t),
            Self::Integer(i) => write!(f, "{i}"),
        }
    }
}

impl From<&str> for MetaValue {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<i32> for MetaValue {
    fn from(value: i32) -> Self {
        Self::Integer(value)
    }
}

/// Checks the requirements of both formats with metadata: names of 1 to 79 printable ASCII characters (PNG's limit)
/// without leading or trailing space; values without NUL.
pub(super) fn check(metadata: &Metadata, format: ImageFormat) -> Result<(), ImageError> {
    for (name, value) in metadata {
        let printable = name.bytes().all(|b| (0x20..0x7f).contains(&b)) && name.trim() == name;
        if name.is_empty() || name.len() > 79 || !printable {
            let problem = format!("metadata name \"{name}\"; expected 1 to 79 printable ASCII characters");
            return Err(ImageError::encode(format, problem));
        }
        if let MetaValue::Text(text) = value
            && text.contains('\0')
        {
            let problem = format!("the text of metadata \"{name}\" contains a NUL; remove it");
            return Err(ImageError::encode(format, problem));
        }
    }
    Ok(())
}
