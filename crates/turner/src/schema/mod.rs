//! The schema of the scene format: the single source of the scene reader, the scene writer, `turner help scene` and
//! docs/reference/scene-format.md.
//!
//! Three macros declare the format. `params!` declares one type of object (a sphere, a spot light) with its keys,
//! `family!` the closed set of types of one family (all shapes, all lights), and `choice!` an enumeration of words.
//! Each generates a plain data type, its `Default`, its reader and writer, and its documentation. All families build
//! on this module; it knows none of them.

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
mod read_kind;
mod remedy;
mod renumber;
mod table_reader;
pub mod transform;
pub mod value;
mod warning;
pub mod write;

pub(crate) use crate::choice::choice;
use crate::schema::value::Data;
pub use data::{
    Contour, Font, FontFile, Glyph, GridData, GridFile, GridScattering, LightProfile, MAX_MEASURED_VALUES,
    MeasuredBrdf, MeasuredFields, MeasuredFile, MeasuredTable, MeasuredView, MeshData, OutlinePiece,
    ProfileFile, boundary, fan,
};
pub use error::{ErrorCode, SceneError};
pub use ids::{Asset, GroupId, ImageId, MaterialId, MediumId, MeshId, Named, TextureId};
pub use key_path::{KeyEdit, KeyPart, path_part};
pub use limits::{Limits, Memory};
pub(crate) use macros::{family, params};
pub use materials_by_name::MaterialsByName;
pub use options::PrepareOptions;
pub use param::ColorSource;
pub use range::Range;
pub use read::ReadContext;
pub use read_kind::read_kind;
pub use remedy::Remedy;
pub use renumber::Renumber;
pub(crate) use renumber::{IdMaps, PartId};
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
    /// The type of its value, as text for users.
    pub kind: fn() -> String,
    /// The valid words of a choice with their meanings; empty for other types.
    pub words: fn() -> &'static [(&'static str, &'static str)],
    /// Its default as written in a scene; `None` for a required key.
    pub default: Option<fn() -> String>,
    /// Its documentation, line by line.
    pub doc: &'static [&'static str],
    /// Its range.
    pub range: Option<Range>,
}

/// The documentation of one type, e.g. of the shape `sphere`.
#[derive(Clone, Copy, Debug)]
pub struct EntryDoc {
    /// The value of `type` that selects it.
    pub name: &'static str,
    /// Its documentation, line by line.
    pub doc: &'static [&'static str],
    /// Its keys.
    pub fields: &'static [Field],
    /// A scene snippet that loads and renders.
    pub example: &'static str,
}

/// The documentation of a family: all shapes, all lights, …
#[derive(Clone, Copy, Debug)]
pub struct FamilyDoc {
    /// The singular of its name, e.g. `shape`.
    pub one: &'static str,
    /// The plural, e.g. `shapes`.
    pub many: &'static str,
    /// What its members have in common, line by line.
    pub doc: &'static [&'static str],
    /// Its members.
    pub entries: &'static [&'static EntryDoc],
}

/// The type of a value in a scene file.
pub trait ParamType: Sized {
    /// The type as text for users, e.g. `number` or `[x, y, z]`.
    fn kind() -> String;
    /// The valid words of a choice with their meanings; empty for other types.
    fn words() -> &'static [(&'static str, &'static str)] {
        &[]
    }
    /// Reads a value.
    ///
    /// Errors: a value of another type; a name or file that does not exist.
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Self, SceneError>;
    /// The value as written in a scene; documentation shows defaults with it.
    fn show(&self) -> String;
    /// The value to write, which reads back as the same value; `None` to omit the key.
    ///
    /// Errors: those of writing the files that hold its data.
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError>;
    /// Updates the IDs that it refers to.
    fn renumber(&mut self, _by: &Renumber) {}
    /// The first number of this value outside the range. `None` if all lie inside, or if the type is not numeric.
    fn outside(&self, _range: &Range) -> Option<f64> {
        None
    }
}

/// The error for a value of another type than expected.
pub fn wrong_type(value: &Value, expected: &str) -> SceneError {
    let message = format!("expected {expected}, found {}", value.data.kind());
    let error = SceneError::at(ErrorCode::WrongType, value.span, message);
    match &value.data {
        Data::String(text) if expected.contains("number") && text.trim().parse::<f64>().is_ok() => {
            error.help("write it without quotes")
        }
        _ => error,
    }
}

/// The error for an unknown word where one of a few is expected.
pub fn unknown_choice(value: &Value, what: &str, found: &str, valid: &[&str]) -> SceneError {
    unknown_name(ErrorCode::UnknownName, value.span, what, found, valid)
}
