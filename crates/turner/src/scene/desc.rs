//! What was asked for: plain, editable data. [`SceneDesc::prepare`] makes it renderable.

use std::sync::Arc;

use super::transform::Transform;
use super::value::Span;
use crate::camera::CameraDesc;
use crate::film::FilmDesc;
use crate::image::Image;
use crate::integrator::IntegratorDesc;
use crate::light::LightDesc;
use crate::material::MaterialDesc;
use crate::medium::MediumDesc;
use crate::scene::background::BackgroundDesc;
use crate::scene::stage::StageDesc;
use crate::shape::{ShapeDesc, mesh::MeshData};
use crate::texture::TextureDesc;

macro_rules! ids {
    ($($(#[doc = $doc:literal])+ $name:ident,)*) => {
        $($(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);
        impl $name {
            /// As an index into its list.
            pub fn index(self) -> usize { self.0 as usize }
        })*
    };
}

ids! {
    /// A material of the scene.
    MaterialId,
    /// A texture of the scene.
    TextureId,
    /// A decoded picture of the scene.
    ImageId,
    /// A mesh of the scene.
    MeshId,
    /// A group of objects that can be placed many times.
    GroupId,
    /// A participating medium of the scene.
    MediumId,
}

/// Something with a name (unless written in place) and a place in a file (unless made by a program).
#[derive(Clone, Debug, PartialEq)]
pub struct Named<T> {
    /// The name, if it has one.
    pub name: Option<String>,
    /// Where it stands.
    pub span: Option<Span>,
    /// The thing.
    pub value: T,
}

/// A light, in the group it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The group of lights it belongs to, if any.
    pub group: Option<String>,
    /// Where it stands.
    pub span: Option<Span>,
    /// The light.
    pub value: LightDesc,
}

/// A file the scene names, read once.
#[derive(Clone, Debug, PartialEq)]
pub struct Asset<T> {
    /// Its name as written.
    pub uri: String,
    /// What it holds.
    pub data: Arc<T>,
}

/// A shape with a material, or a group, placed in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDesc {
    /// The name, for reports.
    pub name: Option<String>,
    /// Where it stands.
    pub span: Option<Span>,
    /// What is placed.
    pub content: ObjectContent,
    /// Its material; an object in a group without one takes the instance's, and at last the default material.
    pub material: Option<MaterialId>,
    /// The group of lights it belongs to where it shines; an object in a group without one takes the instance's.
    pub light_group: Option<String>,
    /// From its own space to that of the scene or group around it.
    pub transform: Transform,
    /// Where it goes while the shutter is open: its transform at the moment 1, where `transform` is that at 0.
    pub motion: Option<Transform>,
}

/// What an object is.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectContent {
    /// A shape of its own.
    Shape(ShapeDesc),
    /// A group, placed.
    Instance(GroupId),
}

/// Objects to be placed together.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupDesc {
    /// Its objects.
    pub objects: Vec<ObjectDesc>,
}

/// A whole scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDesc {
    /// The camera; without one the scene is framed from the front.
    pub camera: Option<Named<CameraDesc>>,
    /// Size, sampling, transfer curve.
    pub film: FilmDesc,
    /// How light is computed.
    pub integrator: IntegratorDesc,
    /// What a ray sees that hits nothing.
    pub background: BackgroundDesc,
    /// Textures, named ones first.
    pub textures: Vec<Named<TextureDesc>>,
    /// Materials, named ones first.
    pub materials: Vec<Named<MaterialDesc>>,
    /// Participating media, named ones first.
    pub media: Vec<Named<MediumDesc>>,
    /// Groups.
    pub groups: Vec<Named<GroupDesc>>,
    /// What is in the scene.
    pub objects: Vec<ObjectDesc>,
    /// Lights.
    pub lights: Vec<SceneLight>,
    /// Pictures that textures use.
    pub images: Vec<Asset<Image>>,
    /// Meshes that objects use.
    pub meshes: Vec<Asset<MeshData>>,
    /// Every camera that an imported file names; `camera` is the one the picture is taken with.
    pub cameras: Vec<Named<CameraDesc>>,
    /// What is added to a scene that has no camera, light or floor.
    pub stage: Option<StageDesc>,
    /// What was imported.
    pub imports: Vec<ImportSummary>,
    /// What was ignored or doubtful while reading.
    pub warnings: Vec<Warning>,
}

/// What a file of another program held.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportSummary {
    /// The file.
    pub file: String,
    /// Its format, e.g. `glTF 2.0`.
    pub format: &'static str,
    /// How many of what.
    pub counts: Vec<(&'static str, u64)>,
}

/// What sort of remark a warning is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum WarningKind {
    /// Something that was asked for has no effect on the picture; an error under `--strict`.
    #[default]
    Ignored,
    /// Something is shown, but not exactly as asked for.
    Approximated,
    /// Something is unlikely to be meant.
    Doubtful,
    /// Something that was not said was chosen.
    Note,
}

impl WarningKind {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            WarningKind::Ignored => "ignored",
            WarningKind::Approximated => "approximated",
            WarningKind::Doubtful => "doubtful",
            WarningKind::Note => "note",
        }
    }
}

/// Something ignored, approximated or doubtful.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// What sort of remark.
    pub kind: WarningKind,
    /// What.
    pub message: String,
    /// Where.
    pub span: Option<Span>,
    /// How often.
    pub count: u64,
}

impl Warning {
    /// A remark without a place in a file.
    pub fn new(kind: WarningKind, message: impl Into<String>) -> Warning {
        Warning { kind, message: message.into(), span: None, count: 1 }
    }
}
