//! From a tree of values to a description.

use std::collections::HashMap;
use std::sync::Arc;

use super::read_object::read_object;
use super::read_parts::*;
use crate::camera::CameraDesc;
use crate::color::Transfer;
use crate::description::model::PlacedModel;
use crate::description::{ModelDesc, *};
use crate::image::Image;
use crate::material::MaterialDesc;
use crate::medium::MediumDesc;
use crate::schema::error::{escape, unknown_name};
use crate::schema::value::{Data, FileId, Span, Table, Value};
use crate::schema::{
    Asset, ErrorCode, GridData, GroupId, ImageId, LightProfile, MaterialId, MediumId, MeshData, MeshId,
    Named, ReadContext, SceneError, TableReader, TextureId, Warning, wrong_type,
};
use crate::texture::TextureDesc;

/// Where the files come from that a scene names. Paths are relative to the file `from` that names them.
/// Each file is read once; asking again gives the same `Arc`.
pub trait SceneAssets {
    /// A decoded picture.
    fn image(&mut self, uri: &str, from: FileId) -> Result<Arc<Image>, SceneError>;
    /// A mesh.
    fn mesh(&mut self, uri: &str, from: FileId) -> Result<Arc<MeshData>, SceneError>;
    /// A light's measurements.
    fn light_profile(&mut self, uri: &str, _from: FileId) -> Result<Arc<LightProfile>, SceneError> {
        Err(SceneError::new(ErrorCode::File, format!("{}: measured lights cannot be read here", escape(uri))))
    }
    /// A medium's grid.
    fn grid(&mut self, uri: &str, _from: FileId) -> Result<Arc<GridData>, SceneError> {
        Err(SceneError::new(ErrorCode::File, format!("{}: grids cannot be read here", escape(uri))))
    }
    /// A file of another program, as a scene.
    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError>;
}

/// How deep textures and materials written in place may nest.
const MAX_NESTING: u32 = 64;

/// What is known of a scene while it is read.
pub(super) struct Reader<'a> {
    /// The film's transfer curve, which `#rrggbb` and colour names follow.
    pub(super) transfer: Transfer,
    pub(super) assets: &'a mut dyn SceneAssets,
    pub(super) texture_ids: HashMap<String, TextureId>,
    pub(super) material_ids: HashMap<String, MaterialId>,
    pub(super) group_ids: HashMap<String, GroupId>,
    pub(super) medium_ids: HashMap<String, MediumId>,
    pub(super) textures: Vec<Option<Named<TextureDesc>>>,
    pub(super) materials: Vec<Option<Named<MaterialDesc>>>,
    pub(super) media: Vec<Option<Named<MediumDesc>>>,
    pub(super) images: Vec<Asset<Image>>,
    pub(super) meshes: Vec<Asset<MeshData>>,
    pub(super) warnings: Vec<Warning>,
    /// Groups that models became, numbered behind the scene's own; and how many groups there are in all.
    pub(super) more_groups: Vec<Named<GroupDesc>>,
    pub(super) group_count: u32,
    pub(super) models: Vec<PlacedModel>,
    pub(super) model_lights: Vec<SceneLight>,
    pub(super) cameras: Vec<Named<CameraDesc>>,
    pub(super) imports: Vec<ImportSummary>,
    /// Whether objects of a group are being read.
    pub(super) in_group: bool,
    nesting: u32,
}

impl<'a> Reader<'a> {
    /// Of a scene of nothing.
    pub(super) fn new(assets: &'a mut dyn SceneAssets) -> Reader<'a> {
        Reader {
            transfer: Transfer::default(),
            assets,
            texture_ids: HashMap::new(),
            material_ids: HashMap::new(),
            group_ids: HashMap::new(),
            medium_ids: HashMap::new(),
            textures: Vec::new(),
            materials: Vec::new(),
            media: Vec::new(),
            images: Vec::new(),
            meshes: Vec::new(),
            warnings: Vec::new(),
            more_groups: Vec::new(),
            group_count: 0,
            models: Vec::new(),
            model_lights: Vec::new(),
            cameras: Vec::new(),
            imports: Vec::new(),
            in_group: false,
            nesting: 0,
        }
    }
}

impl ReadContext for Reader<'_> {
    fn transfer(&self) -> Transfer {
        self.transfer
    }

    fn texture_named(&self, name: &str) -> Option<TextureId> {
        self.texture_ids.get(name).copied()
    }

    fn texture_names(&self) -> Vec<&str> {
        sorted_names(&self.texture_ids)
    }

    fn inline_texture(&mut self, value: &Value) -> Result<TextureId, SceneError> {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            let message = format!("textures nest deeper than {MAX_NESTING}");
            return Err(SceneError::at(ErrorCode::Cycle, value.span, message));
        }
        let id = TextureId(self.textures.len() as u32);
        self.textures.push(None);
        let texture = read_texture(value, self)?;
        self.textures[id.index()] = Some(Named { name: None, span: Some(value.span), value: texture });
        self.nesting -= 1;
        Ok(id)
    }

    fn image(&mut self, uri: &str, span: Span) -> Result<ImageId, SceneError> {
        let image = self.assets.image(uri, span.file).map_err(|e| e.or_at(Some(span)))?;
        Ok(ImageId(intern(&mut self.images, uri, image)))
    }

    fn light_profile(&mut self, uri: &str, span: Span) -> Result<Arc<LightProfile>, SceneError> {
        self.assets.light_profile(uri, span.file).map_err(|e| e.or_at(Some(span)))
    }

    fn grid(&mut self, uri: &str, span: Span) -> Result<Arc<GridData>, SceneError> {
        self.assets.grid(uri, span.file).map_err(|e| e.or_at(Some(span)))
    }

    fn mesh_file(&mut self, uri: &str, span: Span) -> Result<MeshId, SceneError> {
        let mesh = self.assets.mesh(uri, span.file).map_err(|e| e.or_at(Some(span)))?;
        Ok(MeshId(intern(&mut self.meshes, uri, mesh)))
    }

    fn inline_mesh(&mut self, mesh: MeshData) -> MeshId {
        self.meshes.push(Asset { uri: String::new(), data: Arc::new(mesh) });
        MeshId(self.meshes.len() as u32 - 1)
    }

    fn mesh_data(&self, mesh: MeshId) -> Arc<MeshData> {
        self.meshes.get(mesh.index()).map_or_else(Arc::default, |asset| Arc::clone(&asset.data))
    }

    fn remark(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    fn material(&mut self, value: &Value) -> Result<MaterialId, SceneError> {
        match &value.data {
            Data::String(name) => self.material_ids.get(name).copied().ok_or_else(|| {
                let names = sorted_names(&self.material_ids);
                let error = unknown_name(ErrorCode::UnknownName, value.span, "material", name, &names);
                if names.is_empty() {
                    error.help(
                        "define it as [material.NAME], or write it in place: material = { color = \"red\" }",
                    )
                } else {
                    error
                }
            }),
            Data::Table(_) => {
                self.nesting += 1;
                if self.nesting > MAX_NESTING {
                    let message = format!("materials nest deeper than {MAX_NESTING}");
                    return Err(SceneError::at(ErrorCode::Cycle, value.span, message));
                }
                let material = read_material(value, self)?;
                self.nesting -= 1;
                self.materials.push(Some(Named { name: None, span: Some(value.span), value: material }));
                Ok(MaterialId(self.materials.len() as u32 - 1))
            }
            _ => Err(wrong_type(value, "the name of a material or a table { color = …, … }")),
        }
    }

    fn medium(&mut self, value: &Value) -> Result<MediumId, SceneError> {
        match &value.data {
            Data::String(name) => self.medium_ids.get(name).copied().ok_or_else(|| {
                let names = sorted_names(&self.medium_ids);
                let error = unknown_name(ErrorCode::UnknownName, value.span, "medium", name, &names);
                if names.is_empty() {
                    error.help(
                        "define it as [medium.NAME], or write it in place: medium = { extinction = 0.2 }",
                    )
                } else {
                    error
                }
            }),
            Data::Table(_) => {
                let medium = read_medium(value, self)?;
                self.media.push(Some(Named { name: None, span: Some(value.span), value: medium }));
                Ok(MediumId(self.media.len() as u32 - 1))
            }
            _ => Err(wrong_type(value, "the name of a medium or a table { extinction = …, … }")),
        }
    }
}

fn intern<T>(list: &mut Vec<Asset<T>>, uri: &str, data: Arc<T>) -> u32 {
    match list.iter().position(|a| Arc::ptr_eq(&a.data, &data)) {
        Some(i) => i as u32,
        None => {
            list.push(Asset { uri: uri.to_owned(), data });
            list.len() as u32 - 1
        }
    }
}

pub(super) fn sorted_names<T>(ids: &HashMap<String, T>) -> Vec<&str> {
    let mut names: Vec<&str> = ids.keys().map(String::as_str).collect();
    names.sort_unstable();
    names
}

/// The sections of a scene and what they hold; for messages and the documentation.
pub const SECTIONS: &[(&str, &str)] = &[
    ("include", "names of scene files whose sections are read first"),
    ("camera", "where the picture is taken from"),
    ("view", "other cameras, for `camera` in [studio]: [[view]]"),
    ("film", "size, sampling and transfer curve of the picture"),
    ("integrator", "how light is computed"),
    ("background", "what a ray sees that hits nothing"),
    ("studio", "what is added to a scene without camera, light or floor"),
    ("texture", "named textures: [texture.NAME]"),
    ("material", "named materials: [material.NAME]"),
    ("medium", "named participating media, as fog and smoke: [medium.NAME]"),
    ("group", "named groups of objects: [[group.NAME.object]]"),
    ("object", "what is in the scene: [[object]]"),
    ("light", "lights: [[light]]"),
];

/// Reads a whole scene. `root` is the table of the file, includes already merged.
pub fn read_scene(root: &Value, assets: &mut dyn SceneAssets) -> Result<SceneDesc, SceneError> {
    let mut top = TableReader::of(root, "the scene")?;
    for section in SECTIONS.iter().map(|(section, _)| *section).chain(["stage"]) {
        top.take(section);
    }
    top.finish()?;
    let mut cx = Reader::new(assets);
    // The film first: its transfer curve defines the hex colours. Some of its defaults depend on the integrator.
    let empty = Value { data: Data::Table(Table::default()), span: root.span };
    let integrator = top.take("integrator").unwrap_or(&empty);
    let film = read_film(top.take("film").unwrap_or(&empty), integrator_type(integrator), &mut cx)?;
    cx.transfer = film.transfer;

    let textures = named_tables(top.take("texture"), "texture")?;
    let materials = named_tables(top.take("material"), "material")?;
    let media = named_tables(top.take("medium"), "medium")?;
    let groups = named_tables(top.take("group"), "group")?;
    for (i, (name, key_span, _)) in textures.iter().enumerate() {
        check_texture_name(name, *key_span)?;
        cx.texture_ids.insert((*name).to_owned(), TextureId(i as u32));
        cx.textures.push(None);
    }
    for (i, (name, ..)) in materials.iter().enumerate() {
        cx.material_ids.insert((*name).to_owned(), MaterialId(i as u32));
        cx.materials.push(None);
    }
    for (i, (name, ..)) in media.iter().enumerate() {
        cx.medium_ids.insert((*name).to_owned(), MediumId(i as u32));
        cx.media.push(None);
    }
    for (i, (name, ..)) in groups.iter().enumerate() {
        cx.group_ids.insert((*name).to_owned(), GroupId(i as u32));
    }
    cx.group_count = groups.len() as u32;
    for (i, (name, _, value)) in textures.iter().enumerate() {
        let texture = read_texture(value, &mut cx)?;
        cx.textures[i] =
            Some(Named { name: Some((*name).to_owned()), span: Some(value.span), value: texture });
    }
    for (i, (name, _, value)) in media.iter().enumerate() {
        let medium = read_medium(value, &mut cx)?;
        cx.media[i] = Some(Named { name: Some((*name).to_owned()), span: Some(value.span), value: medium });
    }
    for (i, (name, _, value)) in materials.iter().enumerate() {
        let material = read_material(value, &mut cx)?;
        cx.materials[i] =
            Some(Named { name: Some((*name).to_owned()), span: Some(value.span), value: material });
    }
    let mut group_descs = Vec::with_capacity(groups.len());
    cx.in_group = true;
    for (name, _, value) in &groups {
        let objects = read_group(name, value, &mut cx)?;
        group_descs.push(Named {
            name: Some((*name).to_owned()),
            span: Some(value.span),
            value: GroupDesc { objects },
        });
    }
    cx.in_group = false;
    let objects = read_objects(top.take("object"), &mut cx)?;
    group_descs.append(&mut cx.more_groups);
    let mut lights = Vec::new();
    for value in array_of_tables(top.take("light"), "light")? {
        lights.push(read_light(value, &mut cx)?);
    }
    lights.append(&mut cx.model_lights);
    let camera = match top.take("camera") {
        None => None,
        Some(value) => Some(read_camera(value, "[camera]", &mut cx)?),
    };
    let mut cameras = Vec::new();
    for value in array_of_tables(top.take("view"), "view")? {
        cameras.push(read_camera(value, "a view", &mut cx)?);
    }
    cameras.append(&mut cx.cameras);
    let integrator = read_integrator(integrator, &mut cx)?;
    let background = read_background(top.take("background").unwrap_or(&empty), &mut cx)?;
    let studio = match top.take_renamed("studio", &mut cx) {
        None => None,
        Some(value) => Some(read_studio(value, &mut cx)?),
    };
    if objects.is_empty() {
        (&mut cx as &mut dyn ReadContext)
            .warn(None, "the scene has no [[object]]: the picture shows only the background. Add an object");
    }
    Ok(SceneDesc {
        camera,
        film,
        integrator,
        background,
        textures: cx.textures.into_iter().flatten().collect(),
        materials: cx.materials.into_iter().flatten().collect(),
        media: cx.media.into_iter().flatten().collect(),
        groups: group_descs,
        objects,
        lights,
        images: cx.images,
        meshes: cx.meshes,
        cameras,
        studio,
        imports: cx.imports,
        warnings: cx.warnings,
    })
}

/// Reads the objects of a group.
fn read_group(name: &str, value: &Value, cx: &mut Reader<'_>) -> Result<Vec<ObjectDesc>, SceneError> {
    let mut table = TableReader::of(value, format!("the group \"{}\"", escape(name)))?;
    let objects = read_objects(table.take("object"), cx)?;
    table.finish()?;
    Ok(objects)
}

pub(super) fn read_objects(
    section: Option<&Value>,
    cx: &mut Reader<'_>,
) -> Result<Vec<ObjectDesc>, SceneError> {
    array_of_tables(section, "object")?.iter().map(|value| read_object(value, cx)).collect()
}
