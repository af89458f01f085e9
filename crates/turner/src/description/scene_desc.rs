//! What was asked for: plain, editable data. [`SceneDesc::prepare`] makes it renderable.

use crate::camera::CameraDesc;
use crate::description::default_studio::StudioDesc;
use crate::film::FilmDesc;
use crate::image::Image;
use crate::integrator::IntegratorDesc;
use crate::light::{BackgroundDesc, LightDesc};
use crate::material::MaterialDesc;
use crate::medium::MediumDesc;
use crate::schema::value::Span;
use crate::schema::{Asset, GroupId, MaterialId, MeshData, Named, Transform, Warning};
use crate::shape::ShapeDesc;
use crate::texture::TextureDesc;

/// A light, in the group it belongs to.
#[derive(Clone, Debug, Default, PartialEq)]
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

/// A shape with a material, or a group, placed in the scene; by default a unit sphere at the origin.
#[derive(Clone, Debug, Default, PartialEq)]
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

impl Default for ObjectContent {
    /// The default shape.
    fn default() -> ObjectContent {
        ObjectContent::Shape(ShapeDesc::default())
    }
}

/// Objects to be placed together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupDesc {
    /// Its objects.
    pub objects: Vec<ObjectDesc>,
}

/// A whole scene. By default nothing, with everything as a scene file has it that says nothing: 640x480 pixels, the classic integrator, a black
/// background, framed from the front.
#[derive(Clone, Debug, Default, PartialEq)]
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
    pub studio: Option<StudioDesc>,
    /// What was imported.
    pub imports: Vec<ImportSummary>,
    /// What was ignored or doubtful while reading.
    pub warnings: Vec<Warning>,
}

impl SceneDesc {
    /// Whether any object moves while the shutter is open: it has a `motion` that differs from its `transform`.
    pub fn moves(&self) -> bool {
        let in_groups = self.groups.iter().flat_map(|group| &group.value.objects);
        let moves = |o: &ObjectDesc| o.motion.is_some_and(|motion| motion != o.transform);
        self.objects.iter().chain(in_groups).any(moves)
    }

    /// Whether any imported model has an animation. Only then do other frames or another time of the model show anything else.
    pub fn is_animated(&self) -> bool {
        let animations = self.imports.iter().flat_map(|import| &import.counts);
        animations.into_iter().any(|(what, count)| *what == "animations" && *count > 0)
    }
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
    /// Names in the file that a scene can select: of animations and of material variants.
    pub names: Vec<(&'static str, Vec<String>)>,
}
