//! From a description to a tree of values: what [`read_scene`](super::read_scene) reads back as the same description.
//!
//! Every `params!` struct and `family!` writes itself, keys with their default left out. Textures, materials, media and groups all get names, so that their
//! numbers stay what they are; meshes, pictures and other data go to files, which the caller writes ([`SceneAssetWriter`]).

use super::write_names::names;
use crate::color::named;
use crate::description::*;
use crate::image::Image;
use crate::schema::value::{Data, Table, Value};
use crate::schema::write::list;
use crate::schema::{
    Asset, ErrorCode, GridFile, GroupId, ImageId, MaterialId, MediumId, MeshData, MeshId, ParamType,
    ProfileFile, SceneError, TextureId, WriteContext,
};
use crate::shape::ShapeDesc;

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

/// The names of things, and where files go.
pub(super) struct Writer<'a> {
    pub(super) desc: &'a SceneDesc,
    assets: &'a mut dyn SceneAssetWriter,
    pub(super) textures: Vec<String>,
    pub(super) materials: Vec<String>,
    pub(super) media: Vec<String>,
    pub(super) groups: Vec<String>,
}

impl WriteContext for Writer<'_> {
    fn texture(&self, id: TextureId) -> Result<Data, SceneError> {
        name_of(&self.textures, id.index(), "texture")
    }

    fn material(&self, id: MaterialId) -> Result<Data, SceneError> {
        name_of(&self.materials, id.index(), "material")
    }

    fn medium(&self, id: MediumId) -> Result<Data, SceneError> {
        name_of(&self.media, id.index(), "medium")
    }

    fn image(&mut self, id: ImageId) -> Result<Data, SceneError> {
        let asset = self.desc.images.get(id.index()).ok_or_else(|| missing("picture", id.index()))?;
        self.assets.image(id, asset).map(Data::String)
    }

    fn mesh(&mut self, id: MeshId) -> Result<(&MeshData, Option<String>), SceneError> {
        let asset = self.desc.meshes.get(id.index()).ok_or_else(|| missing("mesh", id.index()))?;
        let file = self.assets.mesh(id, asset)?;
        Ok((&asset.data, file))
    }

    fn light_profile(&mut self, profile: &ProfileFile) -> Result<Data, SceneError> {
        self.assets.light_profile(profile).map(Data::String)
    }

    fn grid(&mut self, grid: &GridFile) -> Result<Data, SceneError> {
        self.assets.grid(grid).map(Data::String)
    }
}

impl<'a> Writer<'a> {
    /// Gives all things their names.
    pub(super) fn new(desc: &'a SceneDesc, assets: &'a mut dyn SceneAssetWriter) -> Writer<'a> {
        let all = |list: Vec<Option<&str>>, kind: &str| names(&list, kind, |_| true);
        Writer {
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
        }
    }

    fn group(&self, id: GroupId) -> Result<Data, SceneError> {
        name_of(&self.groups, id.index(), "group")
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
    let mut cx = Writer::new(desc, assets);
    let mut top = Table::default();
    if let Some(camera) = &desc.camera {
        let table = camera.value.write(&mut cx)?;
        top.push("camera", Data::Table(with_name(table, &camera.name)));
    }
    let views = desc.cameras.iter().map(|c| Ok(Data::Table(with_name(c.value.write(&mut cx)?, &c.name))));
    push_list(&mut top, "view", views.collect::<Result<_, SceneError>>()?);
    let film = desc.film.write_for(Some(desc.integrator.type_name()), &mut cx)?;
    push_table(&mut top, "film", film);
    top.push("integrator", Data::Table(desc.integrator.write(&mut cx)?));
    push_table(&mut top, "background", desc.background.write(&mut cx)?);
    if let Some(studio) = &desc.studio {
        top.push("studio", Data::Table(studio.write(&mut cx)?));
    }
    let mut lights = Vec::new();
    for light in &desc.lights {
        lights.push(Data::Table(write_light(light, &mut cx)?));
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

pub(super) fn write_light(light: &SceneLight, cx: &mut Writer<'_>) -> Result<Table, SceneError> {
    let mut table = with_name(light.value.write(cx)?, &light.name);
    table.push("light_group", string(&light.group));
    Ok(table)
}

/// With the key `name` first.
pub(super) fn with_name(table: Table, name: &Option<String>) -> Table {
    let mut named = Table::default();
    named.push("name", string(name));
    named.entries.extend(table.entries);
    named
}

fn objects(objects: &[ObjectDesc], cx: &mut Writer<'_>) -> Result<Vec<Data>, SceneError> {
    objects.iter().map(|object| write_object(object, cx).map(Data::Table)).collect()
}

pub(super) fn write_object(object: &ObjectDesc, cx: &mut Writer<'_>) -> Result<Table, SceneError> {
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
