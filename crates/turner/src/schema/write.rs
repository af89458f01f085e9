//! What writing a value needs from the rest of the scene.

use super::data::{FontFile, GridFile, MeasuredFile, MeshData, ProfileFile};
use super::value::{Data, Entry, Span, Table, Value};
use super::{ErrorCode, ImageId, MaterialId, MediumId, MeshId, ParamType, SceneError, TextureId};

/// The names that IDs are written as, and the files that data goes to. The writer of complete scenes implements it.
pub trait WriteContext {
    /// The name of a texture.
    ///
    /// Errors, as for all names: an ID that the scene does not have.
    fn texture(&self, id: TextureId) -> Result<Data, SceneError>;
    /// The name of a material.
    fn material(&self, id: MaterialId) -> Result<Data, SceneError>;
    /// The name of a medium.
    fn medium(&self, id: MediumId) -> Result<Data, SceneError>;
    /// The file of an image.
    ///
    /// Errors, as for all files: a file that cannot be written.
    fn image(&mut self, id: ImageId) -> Result<Data, SceneError>;
    /// A mesh and its file; without a file, the mesh is written into the scene itself.
    fn mesh(&mut self, id: MeshId) -> Result<(&MeshData, Option<String>), SceneError>;
    /// The IES file of a light.
    fn light_profile(&mut self, profile: &ProfileFile) -> Result<Data, SceneError>;
    /// The file of a measured BRDF.
    fn measured_brdf(&mut self, measured: &MeasuredFile) -> Result<Data, SceneError>;
    /// The file of a density grid.
    fn grid(&mut self, grid: &GridFile) -> Result<Data, SceneError>;
    /// The font file of a text.
    fn font(&mut self, font: &FontFile) -> Result<Data, SceneError>;
}

impl Value {
    /// A value without a position in a file.
    pub fn new(data: Data) -> Value {
        Value { data, span: Span::NONE }
    }
}

impl Table {
    /// Adds `key = data`, unless `data` is `None`.
    pub fn push(&mut self, key: &str, data: impl Into<Option<Data>>) {
        if let Some(data) = data.into() {
            self.entries.push(Entry { key: key.to_owned(), key_span: Span::NONE, value: Value::new(data) });
        }
    }
}

/// The shortest decimal number that reads back as `v` in single precision.
pub(crate) fn single(v: f32) -> Data {
    // The reader rounds to double and then to single precision, which could yield the neighbour of `v`.
    let short = v.to_string().parse::<f64>().ok().filter(|short| (*short as f32).to_bits() == v.to_bits());
    Data::Number(short.unwrap_or_else(|| f64::from(v)))
}

/// A list of values.
pub(crate) fn list(items: impl IntoIterator<Item = Data>) -> Data {
    Data::Array(items.into_iter().map(Value::new).collect())
}

/// Whether two values are equal bit by bit.
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

/// Writes a key, unless its value is the default.
pub fn entry<T: ParamType>(
    cx: &mut dyn WriteContext,
    table: &mut Table,
    key: &'static str,
    value: &T,
    default: Option<&T>,
) -> Result<(), SceneError> {
    let written = value.write(cx)?;
    // Compare with the default as it would be written, so that −0 is not taken for 0.
    let default = default.map(|d| d.write(cx)).transpose()?.flatten();
    match (&written, &default) {
        (Some(a), Some(b)) if same(a, b) => {}
        (None, Some(_)) => {
            let message = format!("`{key}` has a default, so the file cannot express that it is absent");
            return Err(SceneError::new(ErrorCode::Internal, message));
        }
        _ => table.push(key, written),
    }
    Ok(())
}
