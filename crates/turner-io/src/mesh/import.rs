//! Import of mesh files as complete scenes: one object with its materials and images.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use turner::color::{Spectrum, Transfer};
use turner::description::{ImportSummary, ObjectContent, ObjectDesc, SceneDesc};
use turner::material::{AlphaMode, MaterialDesc, PrincipledMaterial};
use turner::schema::{
    Asset, ColorSource, ErrorCode, MaterialId, MeshData, MeshId, Named, SceneError, Transform, Warning,
    WarningKind,
};
use turner::shape::mesh::MeshDesc;
use turner::shape::{PointsDesc, ShapeDesc};
use turner::texture::{Encoding, ImageDesc, TextureDesc, VertexColorDesc};

use super::error::shortened;
use super::mtl::{self, MtlMaterial, physical};
use super::pictures::Pictures;
use super::{MeshError, ReadMesh, drop_not_finite, need, obj, ply, stl, warning};
use crate::assets::{AssetSource, printable};
use crate::image::ColorOrData;
use crate::import::ImportOptions;
use crate::scene::two_lines;

/// Largest material library, in bytes: 256 MiB.
const MAX_LIBRARY: u64 = 1 << 28;

fn mesh_error(error: MeshError) -> SceneError {
    two_lines(ErrorCode::Mesh, &error.to_string())
}

/// Imports an OBJ file with its MTL libraries. `options.nodes` are names of objects and groups.
pub fn import_obj(
    bytes: Vec<u8>,
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    need::check(&bytes, uri, &options.limits)?;
    let file = obj::parse(&bytes, uri, &options.nodes, options.threads).map_err(mesh_error)?;
    // The mesh is parsed; free the text.
    drop(bytes);
    let counts = file.counts;
    let libraries = file.libraries.clone();
    let mut read = file.finish(uri).map_err(mesh_error)?;
    drop_not_finite(&mut read, uri);
    let mut scene = Import::new(uri, "Wavefront OBJ")?;
    scene.scene.warnings.append(&mut read.warnings);
    let found = scene.libraries(&libraries, assets);
    scene.mtl_materials(&read.mesh, found, assets, options);
    scene.count("objects", counts.objects);
    scene.count("groups", counts.groups);
    scene.count("polygons", counts.polygons);
    scene.finish(read, options)
}

/// Imports a PLY file: a mesh or a point cloud.
pub fn import_ply(
    bytes: Vec<u8>,
    uri: &str,
    assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    no_nodes(uri, &options.nodes)?;
    need::check(&bytes, uri, &options.limits)?;
    let mut read = ply::read(&bytes, uri).map_err(mesh_error)?;
    drop(bytes);
    drop_not_finite(&mut read, uri);
    let mut scene = Import::new(uri, "Stanford PLY")?;
    scene.scene.warnings.append(&mut read.warnings);
    let picture = read.texture.take().filter(|_| !read.mesh.uvs.is_empty());
    let mut material = plain();
    if let Some(file) = picture {
        let name = (uri.to_owned(), file);
        let wanted = BTreeMap::from([(name.clone(), ColorOrData::Color)]);
        scene.pictures = Pictures::load(wanted, assets, options, &mut scene.scene.warnings);
        if let Some((id, _)) = scene.pictures.image(&name) {
            material.base_color = scene.pictures.texture(TextureDesc::Image(color_picture(id)));
        }
    }
    scene.push_colored(None, material, &read.mesh);
    scene.finish(read, options)
}

/// Imports an STL file. `options.nodes` are names of solids.
pub fn import_stl(
    bytes: Vec<u8>,
    uri: &str,
    _assets: &dyn AssetSource,
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    need::check(&bytes, uri, &options.limits)?;
    let file = stl::parse(&bytes, uri, &options.nodes).map_err(mesh_error)?;
    drop(bytes);
    let mut read = ReadMesh { mesh: file.mesh, warnings: file.warnings, texture: None };
    drop_not_finite(&mut read, uri);
    let mut scene = Import::new(uri, "STL")?;
    scene.scene.warnings.append(&mut read.warnings);
    scene.count("solids", file.solids);
    for (i, name) in read.mesh.material_names.iter().enumerate() {
        let mut material = plain();
        if let Some(color) = file.colors.get(i) {
            material.base_color = display_color(*color);
        }
        scene.push(Some(name.clone()), material);
    }
    if read.mesh.material_names.is_empty() {
        let mut material = plain();
        if let Some(color) = file.colors.first() {
            material.base_color = display_color(*color);
        }
        scene.push(None, material);
    }
    scene.finish(read, options)
}

fn no_nodes(uri: &str, nodes: &[String]) -> Result<(), SceneError> {
    match nodes.first() {
        Some(node) => Err(mesh_error(MeshError::node(uri, node, &[]))),
        None => Ok(()),
    }
}

/// The default material: grey, roughness 0.5.
fn plain() -> PrincipledMaterial {
    PrincipledMaterial {
        specular_roughness: ColorSource::Constant(Spectrum::grey(0.5)),
        alpha_mode: AlphaMode::Opaque,
        ..PrincipledMaterial::default()
    }
}

fn display_color(rgb: [u8; 3]) -> ColorSource {
    let [r, g, b] = rgb.map(|v| Transfer::Srgb.decode(f32::from(v) / 255.0));
    ColorSource::Constant(Spectrum::new(r, g, b))
}

fn color_picture(file: turner::schema::ImageId) -> ImageDesc {
    ImageDesc { file, encoding: Encoding::Srgb, ..ImageDesc::default() }
}

/// A scene under construction.
struct Import {
    scene: SceneDesc,
    pictures: Pictures,
    summary: ImportSummary,
    uri: String,
}

impl Import {
    fn new(uri: &str, format: &'static str) -> Result<Import, SceneError> {
        let summary = ImportSummary { file: printable(uri), format, counts: Vec::new(), names: Vec::new() };
        Ok(Import {
            scene: SceneDesc::default(),
            pictures: Pictures::default(),
            summary,
            uri: uri.to_owned(),
        })
    }

    fn count(&mut self, what: &'static str, count: u64) {
        if count > 0 {
            self.summary.counts.push((what, count));
        }
    }

    fn push(&mut self, name: Option<String>, material: PrincipledMaterial) {
        let value = MaterialDesc::Principled(material);
        self.scene.materials.push(Named { name, span: None, value });
    }

    /// Adds a material. Vertex colours, if any, replace a constant base colour and give the opacity.
    fn push_colored(&mut self, name: Option<String>, mut material: PrincipledMaterial, mesh: &MeshData) {
        if !mesh.colors.is_empty() {
            let colors = TextureDesc::VertexColor(VertexColorDesc { fallback: Spectrum::WHITE });
            let colors = self.pictures.texture(colors);
            if matches!(material.base_color, ColorSource::Constant(_)) {
                material.base_color = colors;
            }
            if mesh.colors.iter().any(|c| c[3] < 1.0) {
                (material.opacity, material.alpha_mode) = (colors, AlphaMode::Blend);
            }
        }
        self.push(name, material);
    }

    /// The libraries that an OBJ file refers to, each with its path.
    fn libraries(&mut self, lines: &[Vec<u8>], assets: &dyn AssetSource) -> Vec<(String, mtl::MtlFile)> {
        /// Most libraries per file.
        const MOST: usize = 4096;
        let uri = self.uri.clone();
        let mut found: Vec<(String, mtl::MtlFile)> = Vec::new();
        let mut tried: BTreeSet<String> = BTreeSet::new();
        // `None` for a library that was already tried.
        let mut read = |name: String| -> Option<Result<(), String>> {
            if tried.len() >= MOST || !tried.insert(name.clone()) {
                return None;
            }
            let read = assets.resolve(&uri, &name).and_then(|path| {
                let bytes = assets.read(&path, MAX_LIBRARY)?;
                Ok((path, bytes))
            });
            Some(read.map(|(path, bytes)| found.push((path, mtl::parse(&bytes)))).map_err(|e| e.to_string()))
        };
        let mut missing = Vec::new();
        for words in lines.iter().flat_map(|line| library_names(line)) {
            match read(words.join(" ")) {
                Some(Err(_)) if words.len() > 1 => {
                    missing.extend(words.into_iter().filter_map(|w| read(w)?.err()));
                }
                Some(Err(error)) => missing.push(error),
                _ => {}
            }
        }
        for error in missing {
            let line = error.lines().next().unwrap_or_default();
            let message = format!("the material library {}; omitted", shortened(line));
            self.scene.warnings.push(Warning::new(WarningKind::Ignored, message));
        }
        for (path, file) in &found {
            for (keyword, count) in &file.ignored {
                let message = format!("`{keyword}` in materials is ignored");
                self.scene.warnings.push(warning(WarningKind::Ignored, path, *count, &message));
            }
        }
        found
    }

    /// Adds a material for each name that faces use, from the libraries; the default material if there is none.
    fn mtl_materials(
        &mut self,
        mesh: &MeshData,
        libraries: Vec<(String, mtl::MtlFile)>,
        assets: &dyn AssetSource,
        options: &ImportOptions,
    ) {
        // The last definition of a name wins.
        let mut by_name: HashMap<&str, (&str, &MtlMaterial)> = HashMap::new();
        for (path, file) in &libraries {
            by_name.extend(file.materials.iter().map(|m| (m.name.as_str(), (path.as_str(), m))));
        }
        let names = &mesh.material_names;
        let mut wanted = BTreeMap::new();
        for (from, material) in names.iter().filter_map(|n| by_name.get(n.as_str())) {
            physical::wanted(material, from, &mut wanted);
        }
        self.pictures = Pictures::load(wanted, assets, options, &mut self.scene.warnings);
        let (mut remarks, mut unknown) = (physical::Remarks::new(), 0);
        for name in names {
            let Some((from, material)) = by_name.get(name.as_str()) else {
                unknown += u64::from(!name.is_empty());
                self.push_colored(Some(name.clone()).filter(|n| !n.is_empty()), plain(), mesh);
                continue;
            };
            let made = physical::physical(material, from, &mut self.pictures, &mut remarks);
            // Vertex colours apply only if the material has no colour of its own.
            if material.diffuse.is_none() && !material.maps.contains_key("map_kd") {
                self.push_colored(Some(name.clone()), made, mesh);
            } else {
                self.push(Some(name.clone()), made);
            }
        }
        let file = self.uri.clone();
        if unknown > 0 {
            let message = "materials without a definition: their faces get the default material";
            self.scene.warnings.push(warning(WarningKind::Ignored, &file, unknown, message));
        }
        for ((kind, message), count) in remarks {
            self.scene.warnings.push(warning(kind, &file, count, &message));
        }
    }

    /// Adds the mesh or point cloud to the scene.
    fn finish(mut self, read: ReadMesh, options: &ImportOptions) -> Result<SceneDesc, SceneError> {
        // Models are not subdivided.
        let mesh = MeshData { polygons: Vec::new(), ..read.mesh };
        need::check_triangles(mesh.triangles.len(), &self.uri, &options.limits)?;
        if mesh.positions.is_empty() || mesh.triangles.is_empty() && self.summary.format != "Stanford PLY" {
            let vertices = mesh.positions.len();
            return Err(mesh_error(MeshError::empty(&self.uri, vertices, &self.scene.warnings)));
        }
        let is_cloud = mesh.triangles.is_empty();
        self.count(if is_cloud { "points" } else { "vertices" }, mesh.positions.len() as u64);
        self.count("triangles", mesh.triangles.len() as u64);
        self.count("materials", self.scene.materials.len() as u64);
        self.count("textures", self.pictures.images.len() as u64);
        let materials: Vec<Option<MaterialId>> = if mesh.face_materials.is_empty() {
            Vec::new()
        } else {
            (0..self.scene.materials.len() as u32).map(|i| Some(MaterialId(i))).collect()
        };
        let shape = if is_cloud {
            let message =
                "points without a radius: three quarters of the distance between neighbours is used";
            self.scene.warnings.push(Warning::new(WarningKind::Note, message));
            ShapeDesc::Points(PointsDesc { points: MeshId(0), radius: None, radii: Vec::new() })
        } else {
            ShapeDesc::Mesh(MeshDesc { materials, ..MeshDesc::default() })
        };
        let Import { mut scene, pictures, summary, uri } = self;
        let name = uri.rsplit('/').next().unwrap_or(&uri).to_owned();
        scene.textures = pictures.textures;
        scene.images = pictures.images;
        scene.meshes = vec![Asset { uri: summary.file.clone(), data: Arc::new(mesh) }];
        scene.imports = vec![summary];
        scene.objects = vec![ObjectDesc {
            name: Some(name),
            span: None,
            content: ObjectContent::Shape(shape),
            material: (!scene.materials.is_empty()).then_some(MaterialId(0)),
            light_group: None,
            shadow_catcher: false,
            hidden_from_camera: false,
            hidden: false,
            transform: Transform::IDENTITY,
            motion: None,
        }];
        Ok(scene)
    }
}

/// Splits the rest of an `mtllib` line at words that end in `.mtl`. Each group of words is one name with spaces, or
/// several names.
fn library_names(line: &[u8]) -> Vec<Vec<String>> {
    let mut names = vec![Vec::new()];
    for word in obj::words(line) {
        let word = String::from_utf8_lossy(word).into_owned();
        let ends = word.to_lowercase().ends_with(".mtl");
        if let Some(last) = names.last_mut() {
            last.push(word);
        }
        if ends {
            names.push(Vec::new());
        }
    }
    names.retain(|n| !n.is_empty());
    names
}
