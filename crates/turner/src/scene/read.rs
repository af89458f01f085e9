//! From a tree of values to a description.

use std::collections::HashMap;
use std::sync::Arc;

use super::background::BackgroundDesc;
use super::desc::*;
use super::error::{ErrorCode, SceneError, escape, unknown_name};
use super::model::{ModelDesc, PlacedModel};
use super::read_object::read_object;
use super::schema::{TableReader, wrong_type};
use super::stage::StageDesc;
use super::value::{Data, FileId, Span, Table, Value};
use crate::camera::CameraDesc;
use crate::color::{Transfer, named};
use crate::film::FilmDesc;
use crate::image::Image;
use crate::integrator::IntegratorDesc;
use crate::light::{LightDesc, LightProfile};
use crate::material::MaterialDesc;
use crate::medium::{GridData, MediumDesc};
use crate::shape::mesh::MeshData;
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

/// What reading a value may need: names defined elsewhere in the scene, files, the meaning of hex colours.
pub struct ReadContext<'a> {
    /// The film's transfer curve, which `#rrggbb` and colour names follow.
    pub transfer: Transfer,
    pub(super) assets: &'a mut dyn SceneAssets,
    texture_ids: HashMap<String, TextureId>,
    material_ids: HashMap<String, MaterialId>,
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

impl ReadContext<'_> {
    /// The texture of that name.
    pub fn texture_named(&self, name: &str) -> Option<TextureId> {
        self.texture_ids.get(name).copied()
    }

    /// The names of all textures.
    pub fn texture_names(&self) -> Vec<&str> {
        sorted_names(&self.texture_ids)
    }

    /// A texture written in place.
    pub fn inline_texture(&mut self, value: &Value) -> Result<TextureId, SceneError> {
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

    /// A picture file.
    pub fn image(&mut self, uri: &str, span: Span) -> Result<ImageId, SceneError> {
        let image = self.assets.image(uri, span.file).map_err(|e| e.or_at(Some(span)))?;
        Ok(ImageId(intern(&mut self.images, uri, image)))
    }

    /// A file of a light's measurements.
    pub fn light_profile(&mut self, uri: &str, span: Span) -> Result<Arc<LightProfile>, SceneError> {
        self.assets.light_profile(uri, span.file).map_err(|e| e.or_at(Some(span)))
    }

    /// A file of a medium's grid.
    pub fn grid(&mut self, uri: &str, span: Span) -> Result<Arc<GridData>, SceneError> {
        self.assets.grid(uri, span.file).map_err(|e| e.or_at(Some(span)))
    }

    /// A mesh file.
    pub fn mesh_file(&mut self, uri: &str, span: Span) -> Result<MeshId, SceneError> {
        let mesh = self.assets.mesh(uri, span.file).map_err(|e| e.or_at(Some(span)))?;
        Ok(MeshId(intern(&mut self.meshes, uri, mesh)))
    }

    /// A mesh written in place.
    pub fn inline_mesh(&mut self, mesh: MeshData) -> MeshId {
        self.meshes.push(Asset { uri: String::new(), data: Arc::new(mesh) });
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// What a mesh of this scene holds.
    pub fn mesh_data(&self, mesh: MeshId) -> Arc<MeshData> {
        self.meshes.get(mesh.index()).map_or_else(Arc::default, |asset| Arc::clone(&asset.data))
    }

    /// Notes something ignored or doubtful.
    pub fn warn(&mut self, span: Option<Span>, message: impl Into<String>) {
        self.warnings.push(Warning { span, ..Warning::new(WarningKind::Ignored, message) });
    }

    /// A material by its name or written in place.
    pub fn material(&mut self, value: &Value) -> Result<MaterialId, SceneError> {
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
    ("view", "other cameras, for `camera` in [stage] and --camera: [[view]]"),
    ("film", "size, sampling and transfer curve of the picture"),
    ("integrator", "how light is computed"),
    ("background", "what a ray sees that hits nothing"),
    ("stage", "what is added to a scene without camera, light or floor"),
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
    for (section, _) in SECTIONS {
        top.take(section);
    }
    top.finish()?;
    let mut cx = ReadContext {
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
    };
    // The film first: it says what hex colours mean.
    let empty = Value { data: Data::Table(Table::default()), span: root.span };
    let film = whole_table(top.take("film").unwrap_or(&empty), "[film]", &mut cx, FilmDesc::read)?;
    cx.transfer = film.transfer;

    let textures = named_tables(top.take("texture"), "texture")?;
    let materials = named_tables(top.take("material"), "material")?;
    let media = named_tables(top.take("medium"), "medium")?;
    let groups = named_tables(top.take("group"), "group")?;
    for (i, (name, key_span, _)) in textures.iter().enumerate() {
        if named(name).is_some() {
            let message = format!("\"{name}\" is the name of a colour and cannot name a texture");
            return Err(SceneError::at(ErrorCode::Conflict, *key_span, message).help("choose another name"));
        }
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
        let mut table = TableReader::of(value, format!("the group \"{}\"", escape(name)))?;
        let objects = read_objects(table.take("object"), &mut cx)?;
        table.finish()?;
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
        let mut table = TableReader::of(value, "a light")?;
        let name = table.optional::<String>("name", None, &mut cx)?;
        let group = light_group(&mut table, "group", &mut cx)?;
        let light =
            read_kind(&mut table, LightDesc::DOC.one, None, &mut cx, &LightDesc::DOC, LightDesc::read)?;
        table.finish()?;
        lights.push(SceneLight { name, group, span: Some(value.span), value: light });
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
    let integrator = {
        let value = top.take("integrator").unwrap_or(&empty);
        let mut table = TableReader::of(value, "[integrator]")?;
        let doc = &IntegratorDesc::DOC;
        let integrator =
            read_kind(&mut table, "integrator", Some("classic"), &mut cx, doc, IntegratorDesc::read)?;
        table.finish()?;
        integrator
    };
    let background =
        whole_table(top.take("background").unwrap_or(&empty), "[background]", &mut cx, BackgroundDesc::read)?;
    let stage = match top.take("stage") {
        None => None,
        Some(value) => Some(whole_table(value, "[stage]", &mut cx, StageDesc::read)?),
    };
    if objects.is_empty() {
        cx.warn(None, "the scene has no [[object]]: the picture shows the background alone");
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
        stage,
        imports: cx.imports,
        warnings: cx.warnings,
    })
}

/// Reads a camera and its name.
fn read_camera(value: &Value, what: &str, cx: &mut ReadContext<'_>) -> Result<Named<CameraDesc>, SceneError> {
    let mut table = TableReader::of(value, what)?;
    let name = table.optional::<String>("name", None, cx)?;
    let camera = read_kind(&mut table, "camera", Some("pinhole"), cx, &CameraDesc::DOC, CameraDesc::read)?;
    table.finish()?;
    Ok(Named { name, span: Some(value.span), value: camera })
}

/// Reads a table that has no `type` and refuses unknown keys.
fn whole_table<T>(
    value: &Value,
    what: &str,
    cx: &mut ReadContext<'_>,
    read: impl Fn(&mut TableReader<'_>, &mut ReadContext<'_>) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let mut table = TableReader::of(value, what)?;
    let read = read(&mut table, cx)?;
    table.finish()?;
    Ok(read)
}

/// Reads the `type` of a table and then what that type is made of.
pub(super) fn read_kind<T>(
    table: &mut TableReader<'_>,
    kind: &str,
    default: Option<&str>,
    cx: &mut ReadContext<'_>,
    doc: &super::schema::FamilyDoc,
    read: impl Fn(&str, &mut TableReader<'_>, &mut ReadContext<'_>) -> Result<Option<T>, SceneError>,
) -> Result<T, SceneError> {
    let valid: Vec<&str> = doc.entries.iter().map(|e| e.name).collect();
    let name = match (table.take("type"), default) {
        (Some(value), _) => match &value.data {
            Data::String(name) => name.as_str(),
            _ => return Err(wrong_type(value, &format!("the name of a {kind}"))),
        },
        (None, Some(default)) => default,
        (None, None) => {
            let message = format!("this {kind} needs the key `type`");
            return Err(SceneError::at(ErrorCode::MissingKey, table.span(), message)
                .help(format!("add `type = \"…\"`, one of: {}", valid.join(", "))));
        }
    };
    let span = table.span_of("type");
    read(name, table, cx)?.ok_or_else(|| unknown_name(ErrorCode::UnknownName, span, kind, name, &valid))
}

fn read_texture(value: &Value, cx: &mut ReadContext<'_>) -> Result<TextureDesc, SceneError> {
    let mut table = TableReader::of(value, "a texture")?;
    let texture = read_kind(&mut table, "texture", None, cx, &TextureDesc::DOC, TextureDesc::read)?;
    table.finish()?;
    Ok(texture)
}

fn read_material(value: &Value, cx: &mut ReadContext<'_>) -> Result<MaterialDesc, SceneError> {
    let mut table = TableReader::of(value, "a material")?;
    let doc = &MaterialDesc::DOC;
    let material = read_kind(&mut table, "material", Some("classic"), cx, doc, MaterialDesc::read)?;
    table.finish()?;
    Ok(material)
}

pub(super) fn read_medium(value: &Value, cx: &mut ReadContext<'_>) -> Result<MediumDesc, SceneError> {
    let mut table = TableReader::of(value, "a medium")?;
    let medium =
        read_kind(&mut table, "medium", Some("homogeneous"), cx, &MediumDesc::DOC, MediumDesc::read)?;
    table.finish()?;
    Ok(medium)
}

/// `[kind.NAME]` tables as (name, place of the name, value).
fn named_tables<'a>(
    section: Option<&'a Value>,
    kind: &str,
) -> Result<Vec<(&'a str, Span, &'a Value)>, SceneError> {
    let Some(section) = section else { return Ok(Vec::new()) };
    let Data::Table(table) = &section.data else {
        return Err(wrong_type(section, &format!("named tables [{kind}.NAME]")));
    };
    Ok(table.entries.iter().map(|e| (e.key.as_str(), e.key_span, &e.value)).collect())
}

fn array_of_tables<'a>(section: Option<&'a Value>, kind: &str) -> Result<&'a [Value], SceneError> {
    match section.map(|v| &v.data) {
        None => Ok(&[]),
        Some(Data::Array(items)) => Ok(items),
        Some(_) => Err(wrong_type(section.expect("checked above"), &format!("tables headed [[{kind}]]"))
            .help(format!("write [[{kind}]] with two brackets: there may be several"))),
    }
}

fn read_objects(section: Option<&Value>, cx: &mut ReadContext<'_>) -> Result<Vec<ObjectDesc>, SceneError> {
    array_of_tables(section, "object")?.iter().map(|value| read_object(value, cx)).collect()
}

/// The name of a group of lights, which must not be empty.
pub(super) fn light_group(
    table: &mut TableReader<'_>,
    key: &'static str,
    cx: &mut ReadContext<'_>,
) -> Result<Option<String>, SceneError> {
    let group = table.optional::<String>(key, None, cx)?;
    if group.as_ref().is_some_and(|g| g.trim().is_empty()) {
        let message = format!("`{key}` must be the name of a group of lights, found \"\"");
        return Err(SceneError::at(ErrorCode::OutOfRange, table.span_of(key), message)
            .help("name it, e.g. \"lamps\", or leave it out"));
    }
    Ok(group)
}
