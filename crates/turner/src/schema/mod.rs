//! The schema of the scene format: one source for reading it, for writing it, for `turner help scene` and for docs/reference/scene-format.md.
//!
//! Three small macros: `params!` declares what one kind of thing (a sphere, a spot light) is made of,
//! `family!` the closed set of its kinds, `choice!` a set of words. Each gives the plain data type, its `Default`, how it
//! is read from a table of a scene file, and its documentation. All families of nouns stand on this room; it knows none of them.

pub mod data;
pub mod error;
pub mod foreign;
mod foreign_words;
mod ids;
mod key_path;
pub mod limits;
mod macros;
mod materials_by_name;
pub mod old_names;
mod options;
mod param;
mod range;
mod read;
mod remedy;
mod renumber;
mod table_reader;
pub mod transform;
pub mod value;
mod warning;
pub mod write;

pub(crate) use crate::choice::choice;
use crate::schema::value::Data;
pub use data::{GridData, GridFile, LightProfile, MeshData, ProfileFile};
pub use error::{ErrorCode, SceneError};
pub use ids::{Asset, GroupId, ImageId, MaterialId, MediumId, MeshId, Named, TextureId};
pub use key_path::{KeyEdit, KeyPart};
pub use limits::{Limits, Memory};
pub(crate) use macros::{family, params};
pub use materials_by_name::MaterialsByName;
pub use options::PrepareOptions;
pub use param::ColorSource;
pub use range::Range;
pub use read::ReadContext;
pub use remedy::Remedy;
pub use renumber::Renumber;
pub use table_reader::TableReader;
pub use transform::Transform;
pub use turner_bvh::Quality;
pub use warning::{Warning, WarningKind};
pub use write::WriteContext;

use error::unknown_name;
use value::Value;

/// One key of a table in a scene file.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// The key.
    pub name: &'static str,
    /// The type of its value, in words.
    pub kind: fn() -> String,
    /// For a choice, its valid words with their meanings; otherwise empty.
    pub words: fn() -> &'static [(&'static str, &'static str)],
    /// Its default as written in a scene; `None` if it must be given.
    pub default: Option<fn() -> String>,
    /// What it means, a line each.
    pub doc: &'static [&'static str],
    /// Its range.
    pub range: Option<Range>,
}

/// The documentation of one kind of thing.
#[derive(Clone, Copy, Debug)]
pub struct EntryDoc {
    /// Its name in a scene.
    pub name: &'static str,
    /// What it is, a line each.
    pub doc: &'static [&'static str],
    /// Its keys.
    pub fields: &'static [Field],
    /// A scene snippet; it loads and renders.
    pub example: &'static str,
}

/// The documentation of a closed set of kinds: shapes, lights, …
#[derive(Clone, Copy, Debug)]
pub struct FamilyDoc {
    /// One of them, e.g. `shape`.
    pub one: &'static str,
    /// Several, e.g. `shapes`.
    pub many: &'static str,
    /// What they have in common, a line each.
    pub doc: &'static [&'static str],
    /// Its members.
    pub entries: &'static [&'static EntryDoc],
}

/// A type that can stand after a key in a scene file.
pub trait ParamType: Sized {
    /// The type in words, e.g. `number` or `[x, y, z]`.
    fn kind() -> String;
    /// For a choice, its valid words with their meanings; otherwise empty.
    fn words() -> &'static [(&'static str, &'static str)] {
        &[]
    }
    /// From a value.
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Self, SceneError>;
    /// As it would be written in a scene; used to show defaults.
    fn show(&self) -> String;
    /// As a value that reads back as the same; `None` for what is said by leaving the key out.
    ///
    /// Errors: those of the files that its data goes to.
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError>;
    /// Moves the numbers of things it refers to.
    fn renumber(&mut self, _by: &Renumber) {}
    /// The first number of this value that lies outside the range, if any. A type without numbers returns `None`.
    fn outside(&self, _range: &Range) -> Option<f64> {
        None
    }
}

/// The error for a value of another type than expected.
pub fn wrong_type(value: &Value, expected: &str) -> SceneError {
    SceneError::at(
        ErrorCode::WrongType,
        value.span,
        format!("expected {expected}, found {}", value.data.kind()),
    )
}

/// The error for an unknown word where one of a few is expected.
pub fn unknown_choice(value: &Value, what: &str, found: &str, valid: &[&str]) -> SceneError {
    unknown_name(ErrorCode::UnknownName, value.span, what, found, valid)
}
