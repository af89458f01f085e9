//! From a description to a tree of values: what [`read_scene`](super::read_scene) reads back as the same description.
//!
//! Every `params!` struct and `family!` writes itself, keys with their default left out. Textures, materials, media and groups all get names, so that their
//! numbers stay what they are; meshes, pictures and other data go to files, which the caller writes ([`SceneAssetWriter`]).

use super::desc::*;
use super::error::{ErrorCode, SceneError};
use super::schema::ParamType;
use super::value::{Data, Entry, FileId, Span, Table, Value};
use super::write_names::names;
use crate::color::named;
use crate::image::Image;
use crate::light::ProfileFile;
use crate::medium::GridFile;
use crate::shape::{ShapeDesc, mesh::MeshData};

/// Where the data goes that a scene file does not hold itself. Each gives the name to stand in the scene, relative to its file.
pub trait SceneAssetWriter {
    /// A picture.
    fn image(&mut self, id: ImageId, image: &Asset<Image>) -> Result<String, SceneError>;
    /// A mesh; `None` for one that shall stand in the scene itself.
    fn mesh(&mut self, id: MeshId, mesh: &Asset<MeshData>) -> Result<Option<String>, SceneError>;
    /// A light's measurements.
    fn light_profile(&mut self, profile: &ProfileFile) -> Result<String, SceneError>;
    /// A medium's grid.
    fn grid(&mut self, grid: &GridFile) -> Result<String, SceneError>;
}

/// What writing a value may need: the names of other things, places for files.
pub struct WriteContext<'a> {
    desc: &'a SceneDesc,
    assets: &'a mut dyn SceneAssetWriter,
    textures: Vec<String>,
    materials: Vec<String>,
    media: Vec<String>,
    groups: Vec<String>,
}

/// Where values stand that no file has.
pub(super) const NOWHERE: Span = Span { file: FileId(0), start: 0, end: 0 };

impl Value {
    /// A value without a place in a file.
    pub fn new(data: Data) -> Value {
        Value { data, span: NOWHERE }
    }
}

impl Table {
    /// Adds `key = data`, if there is any data.
    pub fn push(&mut self, key: &str, data: impl Into<Option<Data>>) {
        if let Some(data) = data.into() {
            self.entries.push(Entry { key: key.to_owned(), key_span: NOWHERE, value: Value::new(data) });
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

impl WriteContext<'_> {
    /// Adds a key, unless it has its default.
    pub fn entry<T: ParamType>(
        &mut self,
        table: &mut Table,
        key: &'static str,
        value: &T,
        default: Option<&T>,
    ) -> Result<(), SceneError> {
        let written = value.write(self)?;
        // What says nothing needs no words; a default is written by the same rules, so that −0 is not taken for 0.
        let default = default.map(|d| d.write(self)).transpose()?.flatten();
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

    /// The name of a texture.
    pub(crate) fn texture(&self, id: TextureId) -> Result<Data, SceneError> {
        name_of(&self.textures, id.index(), "texture")
    }

    /// The name of a material.
    pub(crate) fn material(&self, id: MaterialId) -> Result<Data, SceneError> {
        name_of(&self.materials, id.index(), "material")
    }

    /// The name of a medium.
    pub(crate) fn medium(&self, id: MediumId) -> Result<Data, SceneError> {
        name_of(&self.media, id.index(), "medium")
    }

    fn group(&self, id: GroupId) -> Result<Data, SceneError> {
        name_of(&self.groups, id.index(), "group")
    }

    /// The file of a picture.
    pub(crate) fn image(&mut self, id: ImageId) -> Result<Data, SceneError> {
        let asset = self.desc.images.get(id.index()).ok_or_else(|| missing("picture", id.index()))?;
        self.assets.image(id, asset).map(Data::String)
    }

    /// A mesh of the scene, and its file, unless it shall stand in the scene itself.
    pub(crate) fn mesh(&mut self, id: MeshId) -> Result<(&MeshData, Option<String>), SceneError> {
        let asset = self.desc.meshes.get(id.index()).ok_or_else(|| missing("mesh", id.index()))?;
        let file = self.assets.mesh(id, asset)?;
        Ok((&asset.data, file))
    }

    /// The file of a light's measurements.
    pub(crate) fn light_profile(&mut self, profile: &ProfileFile) -> Result<Data, SceneError> {
        self.assets.light_profile(profile).map(Data::String)
    }

    /// The file of a medium's grid.
    pub(crate) fn grid(&mut self, grid: &GridFile) -> Result<Data, SceneError> {
        self.assets.grid(grid).map(Data::String)
    }
}

fn missing(what: &str, index: usize) -> SceneError {
    let message = format!("the description names {what} {index}, which it does not have");
    SceneError::new(ErrorCode::Internal, message)
}

fn name_of(names: &[String], index: usize, what: &str) -> Result<Data, SceneError> {
    names.get(index).map(|name| Data::String(name.clone())).ok_or_else(|| missing(what, index))
}

fn string(text: &Option<String>) -> Option<Data> {
    text.clone().map(Data::String)
}

/// Writes a whole scene as the table of a file: what [`read_scene`](super::read_scene) reads as a description that [`SceneDesc::same_scene`] calls the same.
///
/// Errors: those of `assets`; a description that names what it does not have.
pub fn write_scene(desc: &SceneDesc, assets: &mut dyn SceneAssetWriter) -> Result<Value, SceneError> {
    let all = |list: Vec<Option<&str>>, kind: &str| names(&list, kind, |_| true);
    let mut cx = WriteContext {
        desc,
        assets,
        // A colour's name means the colour.
        textures: names(
            &desc.textures.iter().map(|t| t.name.as_deref()).collect::<Vec<_>>(),
            "texture",
            |n| named(n).is_none(),
        ),
        materials: all(desc.materials.iter().map(|m| m.name.as_deref()).collect(), "material"),
        media: all(desc.media.iter().map(|m| m.name.as_deref()).collect(), "medium"),
        groups: all(desc.groups.iter().map(|g| g.name.as_deref()).collect(), "group"),
    };
    let mut top = Table::default();
    if let Some(camera) = &desc.camera {
        let table = camera.value.write(&mut cx)?;
        top.push("camera", Data::Table(with_name(table, &camera.name)));
    }
    let views = desc.cameras.iter().map(|c| Ok(Data::Table(with_name(c.value.write(&mut cx)?, &c.name))));
    push_list(&mut top, "view", views.collect::<Result<_, SceneError>>()?);
    push_table(&mut top, "film", desc.film.write(&mut cx)?);
    top.push("integrator", Data::Table(desc.integrator.write(&mut cx)?));
    push_table(&mut top, "background", desc.background.write(&mut cx)?);
    if let Some(stage) = &desc.stage {
        top.push("stage", Data::Table(stage.write(&mut cx)?));
    }
    let mut lights = Vec::new();
    for light in &desc.lights {
        let mut table = with_name(light.value.write(&mut cx)?, &light.name);
        table.push("group", string(&light.group));
        lights.push(Data::Table(table));
    }
    push_list(&mut top, "light", lights);
    // Tables by name, in the order of their numbers.
    macro_rules! section {
        ($key:literal, $list:ident, $names:ident) => {
            let mut section = Table::default();
            for (i, thing) in desc.$list.iter().enumerate() {
                let table = thing.value.write(&mut cx)?;
                section.push(&cx.$names[i].clone(), Data::Table(table));
            }
            push_table(&mut top, $key, section);
        };
    }
    section!("medium", media, media);
    section!("texture", textures, textures);
    section!("material", materials, materials);
    let mut groups = Table::default();
    for (i, group) in desc.groups.iter().enumerate() {
        let mut table = Table::default();
        push_list(&mut table, "object", objects(&group.value.objects, &mut cx)?);
        groups.push(&cx.groups[i].clone(), Data::Table(table));
    }
    push_table(&mut top, "group", groups);
    let objects = objects(&desc.objects, &mut cx)?;
    push_list(&mut top, "object", objects);
    Ok(Value::new(Data::Table(top)))
}

fn push_table(top: &mut Table, key: &str, table: Table) {
    if !table.entries.is_empty() {
        top.push(key, Data::Table(table));
    }
}

fn push_list(top: &mut Table, key: &str, items: Vec<Data>) {
    if !items.is_empty() {
        top.push(key, list(items));
    }
}

/// With the key `name` first.
fn with_name(table: Table, name: &Option<String>) -> Table {
    let mut named = Table::default();
    named.push("name", string(name));
    named.entries.extend(table.entries);
    named
}

fn objects(objects: &[ObjectDesc], cx: &mut WriteContext<'_>) -> Result<Vec<Data>, SceneError> {
    objects.iter().map(|object| write_object(object, cx).map(Data::Table)).collect()
}

fn write_object(object: &ObjectDesc, cx: &mut WriteContext<'_>) -> Result<Table, SceneError> {
    let content = match &object.content {
        ObjectContent::Shape(shape) => ShapeDesc::write(shape, cx)?,
        ObjectContent::Instance(group) => {
            let mut table = Table::default();
            table.push("type", Data::String("instance".into()));
            table.push("group", cx.group(*group)?);
            table
        }
    };
    let mut table = with_name(content, &object.name);
    table.push("material", object.material.map(|m| cx.material(m)).transpose()?);
    table.push("light_group", string(&object.light_group));
    table.push("transform", object.transform.write(cx)?);
    // An object may well move back to where things are that have no transform.
    let motion = object.motion.map(|m| m.write(cx)).transpose()?;
    table.push("motion", motion.map(|m| m.unwrap_or_else(|| Data::Table(Table::default()))));
    Ok(table)
}
