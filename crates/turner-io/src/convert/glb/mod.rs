//! Writes a scene as one glTF 2.0 file in binary form (GLB).
//!
//! Objects become nodes, and keyframes an animation of them ([`animations`]). Groups, which glTF lacks, become copies of nodes wherever they are placed; the copies share
//! their meshes. Analytic shapes become triangles ([`tessellate`]). What glTF cannot represent is counted and
//! reported. The file is planned first and written in one pass; no mesh is copied.

mod animations;
mod buffer;
mod cameras;
mod json;
mod materials;
mod meshes;
mod nodes;
mod remarks;
mod tessellate;
mod textures;

use std::path::Path;

use buffer::Buffer;
use materials::MaterialWriter;
use meshes::MeshWriter;
use nodes::Nodes;
use remarks::Remarks;
use serde_json::{Map, Value, json};
use tessellate::Tessellated;
use textures::TextureWriter;
use turner::color::Transfer;
use turner::description::{ObjectContent, ObjectDesc, SceneDesc};
use turner::schema::{ErrorCode, SceneError, WarningKind};
use turner::shape::ShapeDesc;

use super::{ConvertOptions, Converted, WrittenFile, create, output_error};

/// Writes what glTF 2.0 can represent of a scene as a GLB file.
///
/// Errors: an existing file, unless it may be replaced; with `strict`, anything that would be omitted; more than 4
/// GiB; invalid references in the description.
pub fn to_glb(desc: &SceneDesc, out: &Path, options: &ConvertOptions) -> Result<Converted, SceneError> {
    let file = create(out, options.overwrite)?;
    let mut remarks = Remarks::default();
    let full = desc;
    let (shown, hidden) = desc.without_hidden();
    let desc = shown.as_ref();
    (0..hidden).for_each(|_| remarks.ignored("hidden objects and lights"));
    let shapes = shapes(desc)?;
    let mut meshes =
        MeshWriter::new(desc, &shapes, MaterialWriter::new(desc, TextureWriter::new(desc, options)));
    let mut nodes = Nodes::default();
    nodes.objects(desc, &mut meshes, &mut remarks)?;
    let (cameras, lights) = cameras::add(desc, &mut nodes, &mut remarks);
    if desc.film.transfer == Transfer::None {
        remarks.approximated("film.transfer = \"none\": colours are written as linear values");
    }
    let MeshWriter { mut buffer, list: mesh_list, materials, .. } = meshes;
    let animations = animations::add(full, &nodes, &mut buffer, &mut remarks)?;
    let mut root = document(desc, (nodes, mesh_list, cameras, lights), materials, &mut buffer);
    if !animations.is_empty() {
        root["animations"] = Value::Array(animations);
    }
    let text = serde_json::to_vec(&root).map_err(|e| SceneError::new(ErrorCode::Internal, e.to_string()))?;
    let warnings = remarks.warnings();
    if options.strict
        && let Some(first) = warnings.iter().find(|w| w.kind == WarningKind::Ignored)
    {
        return Err(SceneError::new(ErrorCode::Strict, first.message.clone())
            .help("convert to a .toml file, which stores everything"));
    }
    let mut bytes = 0;
    file.commit_with(|out| {
        let mut counted = Counted { out, bytes: &mut bytes };
        buffer.write(&text, &mut counted)
    })
    .map_err(output_error)?;
    Ok(Converted { files: vec![WrittenFile { path: out.to_owned(), bytes }], warnings })
}

/// Counts the bytes written.
struct Counted<'a> {
    out: &'a mut dyn std::io::Write,
    bytes: &'a mut u64,
}

impl std::io::Write for Counted<'_> {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        let count = self.out.write(data)?;
        *self.bytes += count as u64;
        Ok(count)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// Tessellated shapes by object, objects of groups first. Built before everything else, because the buffer borrows
/// them.
type Shapes = Vec<Option<Tessellated>>;

fn shapes(desc: &SceneDesc) -> Result<Shapes, SceneError> {
    let in_groups = desc.groups.iter().flat_map(|g| &g.value.objects);
    let all = || in_groups.clone().chain(&desc.objects);
    let made = |object: &ObjectDesc, planes: Option<f64>| match (&object.content, planes) {
        (ObjectContent::Shape(ShapeDesc::Plane(_)), None) | (ObjectContent::Instance(_), _) => Ok(None),
        (ObjectContent::Shape(shape), reach) => tessellate::triangles(shape, desc, reach.unwrap_or(1.0)),
    };
    let mut shapes: Shapes = all().map(|object| made(object, None)).collect::<Result<_, _>>()?;
    // The size of infinite planes depends on everything else.
    let is_plane = |o: &ObjectDesc| matches!(o.content, ObjectContent::Shape(ShapeDesc::Plane(_)));
    if all().any(is_plane) {
        let reach = nodes::reach(desc, &shapes);
        for (shape, object) in shapes.iter_mut().zip(all()).filter(|(_, object)| is_plane(object)) {
            *shape = made(object, Some(reach))?;
        }
    }
    Ok(shapes)
}

/// The JSON of the document.
fn document(
    desc: &SceneDesc,
    (nodes, meshes, cameras, lights): (Nodes, Vec<Value>, Vec<Value>, Vec<Value>),
    materials: MaterialWriter<'_>,
    buffer: &mut Buffer<'_>,
) -> Value {
    let MaterialWriter { textures, list: material_list, extensions, .. } = materials;
    let mut images = Vec::new();
    for (bytes, kind, name) in textures.images {
        let length = bytes.len() as u64;
        let view = buffer.view(length, None, move |out| out.write_all(&bytes));
        let mut image = json!({ "bufferView": view, "mimeType": kind });
        if !name.is_empty() {
            image["name"] = json!(name);
        }
        images.push(image);
    }
    let mut root = Map::new();
    let generator = concat!("Turner ", env!("CARGO_PKG_VERSION"));
    root.insert("asset".into(), json!({ "version": "2.0", "generator": generator }));
    let mut used: Vec<&str> = extensions.into_iter().collect();
    if textures.uses_transform {
        used.push("KHR_texture_transform");
    }
    if !lights.is_empty() {
        used.push("KHR_lights_punctual");
        root.insert("extensions".into(), json!({ "KHR_lights_punctual": { "lights": lights } }));
    }
    used.sort_unstable();
    let mut lists = vec![
        ("nodes", nodes.list),
        ("meshes", meshes),
        ("materials", material_list),
        ("textures", textures.textures),
        ("samplers", textures.samplers),
        ("images", images),
        ("cameras", cameras),
        ("accessors", std::mem::take(&mut buffer.accessors)),
        ("bufferViews", std::mem::take(&mut buffer.views)),
        ("extensionsUsed", used.into_iter().map(Value::from).collect()),
    ];
    if buffer.length() > 0 {
        lists.push(("buffers", vec![json!({ "byteLength": buffer.length() })]));
    }
    // glTF forbids empty lists.
    for (key, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
        root.insert(key.into(), Value::Array(list));
    }
    let mut scene = Map::new();
    if !nodes.roots.is_empty() {
        scene.insert("nodes".into(), json!(nodes.roots));
    }
    if let Some(name) = desc.imports.first().map(|i| &i.file) {
        scene.insert("name".into(), json!(name));
    }
    root.insert("scenes".into(), json!([scene]));
    root.insert("scene".into(), json!(0));
    Value::Object(root)
}
