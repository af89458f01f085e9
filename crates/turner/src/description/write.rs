//! Writes a description as a tree of values that [`read_scene`](super::read_scene) reads back as the same scene.
//!
//! Every `params!` struct and `family!` writes itself, without keys at their default. All textures, materials, media
//! and groups get names, so that their order stays the same. Meshes, images and other data go to files, which the
//! caller writes ([`SceneAssetWriter`]).

use super::write_names::PartNames;
use crate::description::*;
use crate::image::Image;
use crate::schema::value::{Data, Table, Value};
use crate::schema::write::list;
use crate::schema::{
    Asset, ErrorCode, FontFile, GridFile, GroupId, ImageId, MaterialId, MeasuredFile, MediumId, MeshData,
    MeshId, ParamType, ProfileFile, SceneError, TextureId, Transform, WriteContext,
};
use crate::shape::ShapeDesc;

/// Writes the data that a scene file does not contain. Each method returns the file name to write in the scene,
/// relative to the scene file.
pub trait SceneAssetWriter {
    /// An image.
    fn image(&mut self, id: ImageId, image: &Asset<Image>) -> Result<String, SceneError>;
    /// A mesh; `None` to write it into the scene itself.
    fn mesh(&mut self, id: MeshId, mesh: &Asset<MeshData>) -> Result<Option<String>, SceneError>;
    /// An IES profile.
    fn light_profile(&mut self, profile: &ProfileFile) -> Result<String, SceneError>;
    /// A measured BRDF.
    fn measured_brdf(&mut self, measured: &MeasuredFile) -> Result<String, SceneError>;
    /// A density grid.
    fn grid(&mut self, grid: &GridFile) -> Result<String, SceneError>;
    /// A font.
    fn font(&mut self, font: &FontFile) -> Result<String, SceneError>;
}

/// The context of writing: the names that IDs are written as, and the writer of files.
pub(super) struct Writer<'a> {
    pub(super) desc: &'a SceneDesc,
    assets: &'a mut dyn SceneAssetWriter,
    pub(super) names: PartNames,
}

impl WriteContext for Writer<'_> {
    fn texture(&self, id: TextureId) -> Result<Data, SceneError> {
        name_of(&self.names.textures, id.index(), "texture")
    }

    fn material(&self, id: MaterialId) -> Result<Data, SceneError> {
        name_of(&self.names.materials, id.index(), "material")
    }

    fn medium(&self, id: MediumId) -> Result<Data, SceneError> {
        name_of(&self.names.media, id.index(), "medium")
    }

    fn image(&mut self, id: ImageId) -> Result<Data, SceneError> {
        let asset = self.desc.images.get(id.index()).ok_or_else(|| missing("image", id.index()))?;
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

    fn measured_brdf(&mut self, measured: &MeasuredFile) -> Result<Data, SceneError> {
        self.assets.measured_brdf(measured).map(Data::String)
    }

    fn grid(&mut self, grid: &GridFile) -> Result<Data, SceneError> {
        self.assets.grid(grid).map(Data::String)
    }

    fn font(&mut self, font: &FontFile) -> Result<Data, SceneError> {
        self.assets.font(font).map(Data::String)
    }
}

impl<'a> Writer<'a> {
    /// Assigns all names.
    pub(super) fn new(desc: &'a SceneDesc, assets: &'a mut dyn SceneAssetWriter) -> Writer<'a> {
        Writer { desc, assets, names: desc.names() }
    }

    fn group(&self, id: GroupId) -> Result<Data, SceneError> {
        name_of(&self.names.groups, id.index(), "group")
    }
}

fn missing(what: &str, index: usize) -> SceneError {
    let message = format!("the description refers to {what} {index}, which it does not have");
    SceneError::new(ErrorCode::Internal, message)
}

fn name_of(names: &[String], index: usize, what: &str) -> Result<Data, SceneError> {
    names.get(index).map(|name| Data::String(name.clone())).ok_or_else(|| missing(what, index))
}

fn string(text: &Option<String>) -> Option<Data> {
    text.clone().map(Data::String)
}

/// Writes a complete scene as the table of a file. [`SceneDesc::same_scene`] holds for what
/// [`read_scene`](super::read_scene) reads from it.
///
/// Errors: those of `assets`; an ID that the description does not have.
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
    let mut animations = Vec::new();
    for animation in &desc.animations {
        animations.push(Data::Table(with_name(animation.value.write(&mut cx)?, &animation.name)));
    }
    push_list(&mut top, "animation", animations);
    // Tables by name, in the order of their IDs.
    macro_rules! section {
        ($key:literal, $list:ident, $names:ident) => {
            let mut section = Table::default();
            for (i, item) in desc.$list.iter().enumerate() {
                let table = item.value.write(&mut cx)?;
                section.push(&cx.names.$names[i].clone(), Data::Table(table));
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
        groups.push(&cx.names.groups[i].clone(), Data::Table(table));
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
    table.push("hidden", light.hidden.then_some(Data::Bool(true)));
    table.push("motion", light.motion.map(Transform::to_data));
    Ok(table)
}

/// The table with the key `name` in front, if there is a name.
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
    table.push("shadow_catcher", object.shadow_catcher.then_some(Data::Bool(true)));
    table.push("hidden_from_camera", object.hidden_from_camera.then_some(Data::Bool(true)));
    table.push("hidden", object.hidden.then_some(Data::Bool(true)));
    table.push("transform", object.transform.write(cx)?);
    // A motion to the identity is written as an empty table: without the key, the object does not move.
    let motion = object.motion.map(|m| m.write(cx)).transpose()?;
    table.push("motion", motion.map(|m| m.unwrap_or_else(|| Data::Table(Table::default()))));
    Ok(table)
}
