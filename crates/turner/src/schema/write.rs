//! What writing a value may need of the scene around it.

use super::data::{GridFile, MeshData, ProfileFile};
use super::value::{Data, Entry, Span, Table, Value};
use super::{ErrorCode, ImageId, MaterialId, MediumId, MeshId, ParamType, SceneError, TextureId};

/// The names of other things, places for files. Who writes a whole scene implements it.
pub trait WriteContext {
    /// The name of a texture.
    ///
    /// Errors: a number that the scene does not have; so for all names.
    fn texture(&self, id: TextureId) -> Result<Data, SceneError>;
    /// The name of a material.
    fn material(&self, id: MaterialId) -> Result<Data, SceneError>;
    /// The name of a medium.
    fn medium(&self, id: MediumId) -> Result<Data, SceneError>;
    /// The file of a picture.
    ///
    /// Errors: a file that cannot be written; so for all files.
    fn image(&mut self, id: ImageId) -> Result<Data, SceneError>;
    /// A mesh of the scene, and its file, unless it shall stand in the scene itself.
    fn mesh(&mut self, id: MeshId) -> Result<(&MeshData, Option<String>), SceneError>;
    /// The file of a light's measurements.
    fn light_profile(&mut self, profile: &ProfileFile) -> Result<Data, SceneError>;
    /// The file of a medium's grid.
    fn grid(&mut self, grid: &GridFile) -> Result<Data, SceneError>;
}

impl Value {
    /// A value without a place in a file.
    pub fn new(data: Data) -> Value {
        Value { data, span: Span::NONE }
    }
}

impl Table {
    /// Adds `key = data`, if there is any data.
    pub fn push(&mut self, key: &str, data: impl Into<Option<Data>>) {
        if let Some(data) = data.into() {
            self.entries.push(Entry { key: key.to_owned(), key_span: Span::NONE, value: Value::new(data) });
        }
    }
}

/// The shortest number that reads back as this one in single precision.
pub(crate) fn single(v: f32) -> Data {
    // Rounded twice, what is shortest in single precision might become its neighbour.
    let short = v.to_string().parse::<f64>().ok().filter(|short| (*short as f32).to_bits() == v.to_bits());
    Data::Number(short.unwrap_or_else(|| f64::from(v)))
}

/// A list of values.
pub(crate) fn list(items: impl IntoIterator<Item = Data>) -> Data {
    Data::Array(items.into_iter().map(Value::new).collect())
}

/// Whether two values are the same to the last bit.
fn same(a: &Data, b: &Data) -> bool {
    match (a, b) {
        (Data::Number(a), Data::Number(b)) => a.to_bits() == b.to_bits(),
        (Data::Array(a), Data::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(&a.data, &b.data))
        }
        (Data::Table(a), Data::Table(b)) => {
            let mut pairs = a.entries.iter().zip(&b.entries);
            a.entries.len() == b.entries.len()
                && pairs.all(|(a, b)| a.key == b.key && same(&a.value.data, &b.value.data))
        }
        _ => a == b,
    }
}

/// Adds a key, unless it has its default.
pub fn entry<T: ParamType>(
    cx: &mut dyn WriteContext,
    table: &mut Table,
    key: &'static str,
    value: &T,
    default: Option<&T>,
) -> Result<(), SceneError> {
    let written = value.write(cx)?;
    // What says nothing needs no words; a default is written by the same rules, so that −0 is not taken for 0.
    let default = default.map(|d| d.write(cx)).transpose()?.flatten();
    match (&written, &default) {
        (Some(a), Some(b)) if same(a, b) => {}
        (None, Some(_)) => {
            let message = format!("`{key}` has a default and cannot be written as not given");
            return Err(SceneError::new(ErrorCode::Internal, message));
        }
        _ => table.push(key, written),
    }
    Ok(())
}
