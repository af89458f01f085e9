//! The context that reads a tree of values into a description: names, assets, recorded errors.

use std::collections::HashMap;
use std::sync::Arc;

use super::read_parts::*;
use crate::camera::CameraDesc;
use crate::color::Transfer;
use crate::description::model::PlacedModel;
use crate::description::{ModelDesc, *};
use crate::image::Image;
use crate::material::MaterialDesc;
use crate::medium::MediumDesc;
use crate::schema::error::{escape, unknown_name};
use crate::schema::value::{Data, FileId, Span, Value};
use crate::schema::{
    Asset, ErrorCode, Font, GridData, GroupId, ImageId, LightProfile, MaterialId, MeasuredBrdf, MediumId,
    MeshData, MeshId, Named, ReadContext, SceneError, TextureId, Warning, wrong_type,
};
use crate::texture::TextureDesc;

/// Reads the files that a scene refers to. Paths are relative to the file `from` that contains them. Each file is read
/// once; later calls return the same `Arc`.
pub trait SceneAssets {
    /// Reads and decodes an image.
    fn image(&mut self, uri: &str, from: FileId) -> Result<Arc<Image>, SceneError>;
    /// Reads a mesh.
    fn mesh(&mut self, uri: &str, from: FileId) -> Result<Arc<MeshData>, SceneError>;
    /// Reads an IES profile.
    fn light_profile(&mut self, uri: &str, _from: FileId) -> Result<Arc<LightProfile>, SceneError> {
        Err(SceneError::new(ErrorCode::File, format!("{}: IES files cannot be read here", escape(uri))))
    }
    /// Reads a file of a measured BRDF.
    fn measured_brdf(&mut self, uri: &str, _from: FileId) -> Result<Arc<MeasuredBrdf>, SceneError> {
        Err(SceneError::new(ErrorCode::File, format!("{}: BSDF files cannot be read here", escape(uri))))
    }
    /// Reads a density grid.
    fn grid(&mut self, uri: &str, _from: FileId) -> Result<Arc<GridData>, SceneError> {
        Err(SceneError::new(ErrorCode::File, format!("{}: grids cannot be read here", escape(uri))))
    }
    /// Reads a font.
    fn font(&mut self, uri: &str, _from: FileId) -> Result<Arc<dyn Font>, SceneError> {
        Err(SceneError::new(ErrorCode::File, format!("{}: fonts cannot be read here", escape(uri))))
    }
    /// Imports a model.
    fn model(&mut self, model: &ModelDesc, from: FileId) -> Result<Arc<SceneDesc>, SceneError>;
}

/// Maximum nesting depth of textures and materials written in place.
const MAX_NESTING: u32 = 64;

/// Maximum number of collected errors. Each may cost a search through all names of the scene for the nearest one.
const MAX_FAULTS: usize = 100;

/// The state of reading a scene.
pub(crate) struct Reader<'a> {
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
    /// Groups made from models, numbered after the scene's own groups.
    pub(super) more_groups: Vec<Named<GroupDesc>>,
    /// The number of all groups.
    pub(super) group_count: u32,
    pub(super) models: Vec<PlacedModel>,
    pub(super) model_lights: Vec<SceneLight>,
    pub(super) cameras: Vec<Named<CameraDesc>>,
    pub(super) imports: Vec<ImportSummary>,
    /// Whether objects of a group are being read.
    pub(super) in_group: bool,
    nesting: u32,
    /// Files that could not be read, with their errors. No file is tried twice.
    failed: HashMap<(FileId, String), SceneError>,
    /// The errors recorded so far. `None` if reading stops at the first error.
    pub(super) faults: Option<Vec<SceneError>>,
}

impl<'a> Reader<'a> {
    /// The state for an empty scene.
    pub(crate) fn new(assets: &'a mut dyn SceneAssets) -> Reader<'a> {
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
            failed: HashMap::new(),
            faults: None,
        }
    }
}

/// The value that was read; `None` if reading it failed and the error was recorded.
pub(super) fn noted<T>(cx: &mut Reader<'_>, read: Result<T, SceneError>) -> Result<Option<T>, SceneError> {
    (cx as &mut dyn ReadContext).noted(read)
}

impl Reader<'_> {
    /// The valid names that an error about an unknown name lists. Sorting and comparing a million names takes about a
    /// second, so in scenes with very many names only the first error gets them.
    pub(super) fn names<'n, T>(&self, ids: &'n HashMap<String, T>) -> Vec<&'n str> {
        const MANY: usize = 10_000;
        if ids.len() > MANY && self.faults() > 0 { Vec::new() } else { sorted_names(ids) }
    }

    /// Reads a file. If reading it failed before, returns the same error again.
    pub(super) fn once<T>(
        &mut self,
        key: &str,
        span: Span,
        read: impl FnOnce(&mut dyn SceneAssets) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        let key = (span.file, key.to_owned());
        if let Some(error) = self.failed.get(&key) {
            return Err(error.clone());
        }
        read(self.assets).map_err(|error| {
            let error = error.or_at(Some(span));
            self.failed.insert(key, error.clone());
            error
        })
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
        self.names(&self.texture_ids)
    }

    fn inline_texture(&mut self, value: &Value) -> Result<TextureId, SceneError> {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            self.nesting -= 1;
            let message = format!("textures nest deeper than {MAX_NESTING}");
            return Err(SceneError::at(ErrorCode::Cycle, value.span, message));
        }
        let id = TextureId(self.textures.len() as u32);
        self.textures.push(None);
        let texture = read_texture(value, self);
        self.nesting -= 1;
        self.textures[id.index()] = Some(Named { name: None, span: Some(value.span), value: texture? });
        Ok(id)
    }

    fn image(&mut self, uri: &str, span: Span) -> Result<ImageId, SceneError> {
        let image = self.once(&format!("image {uri}"), span, |assets| assets.image(uri, span.file))?;
        Ok(ImageId(intern(&mut self.images, uri, image)))
    }

    fn light_profile(&mut self, uri: &str, span: Span) -> Result<Arc<LightProfile>, SceneError> {
        self.once(&format!("light_profile {uri}"), span, |assets| assets.light_profile(uri, span.file))
    }

    fn measured_brdf(&mut self, uri: &str, span: Span) -> Result<Arc<MeasuredBrdf>, SceneError> {
        self.once(&format!("measured_brdf {uri}"), span, |assets| assets.measured_brdf(uri, span.file))
    }

    fn grid(&mut self, uri: &str, span: Span) -> Result<Arc<GridData>, SceneError> {
        self.once(&format!("grid {uri}"), span, |assets| assets.grid(uri, span.file))
    }

    fn font(&mut self, uri: &str, span: Span) -> Result<Arc<dyn Font>, SceneError> {
        self.once(&format!("font {uri}"), span, |assets| assets.font(uri, span.file))
    }

    fn mesh_file(&mut self, uri: &str, span: Span) -> Result<MeshId, SceneError> {
        let mesh = self.once(&format!("mesh {uri}"), span, |assets| assets.mesh(uri, span.file))?;
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

    fn fault(&mut self, error: SceneError) -> Result<(), SceneError> {
        let Some(faults) = &mut self.faults else { return Err(error) };
        // Exhausted memory and nesting that is too deep would cause the same error again and again.
        if faults.len() >= MAX_FAULTS || matches!(error.code, ErrorCode::TooLarge | ErrorCode::Cycle) {
            return Err(error);
        }
        // Several objects may refer to the same file. Report its error once.
        let is_file = matches!(
            error.code,
            ErrorCode::File
                | ErrorCode::Image
                | ErrorCode::Mesh
                | ErrorCode::Model
                | ErrorCode::Profile
                | ErrorCode::Volume
                | ErrorCode::Measured
        );
        let is_same = |f: &SceneError| f.message == error.message && (is_file || f.span == error.span);
        if !faults.iter().any(is_same) {
            faults.push(error);
        }
        Ok(())
    }

    fn faults(&self) -> usize {
        self.faults.as_ref().map_or(0, Vec::len)
    }

    fn material(&mut self, value: &Value) -> Result<MaterialId, SceneError> {
        match &value.data {
            Data::String(name) => self.material_ids.get(name).copied().ok_or_else(|| {
                let names = self.names(&self.material_ids);
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
                    self.nesting -= 1;
                    let message = format!("materials nest deeper than {MAX_NESTING}");
                    return Err(SceneError::at(ErrorCode::Cycle, value.span, message));
                }
                let material = read_material(value, self);
                self.nesting -= 1;
                self.materials.push(Some(Named { name: None, span: Some(value.span), value: material? }));
                Ok(MaterialId(self.materials.len() as u32 - 1))
            }
            _ => Err(wrong_type(value, "the name of a material or a table { color = …, … }")),
        }
    }

    fn medium(&mut self, value: &Value) -> Result<MediumId, SceneError> {
        match &value.data {
            Data::String(name) => self.medium_ids.get(name).copied().ok_or_else(|| {
                let names = self.names(&self.medium_ids);
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

fn sorted_names<T>(ids: &HashMap<String, T>) -> Vec<&str> {
    let mut names: Vec<&str> = ids.keys().map(String::as_str).collect();
    names.sort_unstable();
    names
}

/// The sections of a scene and their contents, for messages and the documentation.
pub const SECTIONS: &[(&str, &str)] = &[
    ("include", "names of scene files whose sections are read first"),
    ("camera", "the camera of the picture"),
    ("view", "other cameras, for `camera` in [studio]: [[view]]"),
    ("film", "size, sampling and transfer curve of the picture"),
    ("integrator", "how light is computed"),
    ("background", "the radiance of rays that hit nothing"),
    ("studio", "default camera, lights and floor for a scene without them"),
    ("texture", "named textures: [texture.NAME]"),
    ("material", "named materials: [material.NAME]"),
    ("medium", "named participating media, such as fog and smoke: [medium.NAME]"),
    ("group", "named groups of objects: [[group.NAME.object]]"),
    ("object", "the objects of the scene: [[object]]"),
    ("light", "lights: [[light]]"),
    ("animation", "keyframes of any key: [[animation]]"),
];
