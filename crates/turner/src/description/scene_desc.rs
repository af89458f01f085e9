//! The description of a scene: plain, editable data. [`SceneDesc::prepare`] prepares it for rendering.

use crate::animation::AnimationDesc;
use crate::camera::CameraDesc;
use crate::description::default_studio::StudioDesc;
use crate::description::model::ModelDesc;
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

/// A light, with its name and light group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneLight {
    /// The name, if it has one.
    pub name: Option<String>,
    /// Its light group, if any.
    pub group: Option<String>,
    /// The position in a file, if it has one.
    pub span: Option<Span>,
    /// Whether it does not shine.
    pub hidden: bool,
    /// Motion blur: what moves it, in the space of the scene, from where it is at time 0 of the shutter interval to where
    /// it is at time 1.
    pub motion: Option<Transform>,
    /// The light.
    pub value: LightDesc,
}

impl SceneLight {
    /// Whether it moves while the shutter is open.
    pub fn moves(&self) -> bool {
        !self.hidden && self.motion.is_some_and(|motion| !motion.is_identity())
    }
}

/// An object: a shape with a material, or an instance of a group. By default a unit sphere at the origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectDesc {
    /// The name, for messages and reports.
    pub name: Option<String>,
    /// The position in a file, if it has one.
    pub span: Option<Span>,
    /// A shape or an instance.
    pub content: ObjectContent,
    /// Its material. An object without one, in a group, takes the material of the instance; otherwise it has the
    /// default material.
    pub material: Option<MaterialId>,
    /// Its light group if it emits light. An object without one, in a group, takes the light group of the instance.
    pub light_group: Option<String>,
    /// Whether the camera sees nothing of it but the shadow on it.
    pub shadow_catcher: bool,
    /// Whether rays from the camera pass through it. All other rays meet it: it is visible in mirrors, casts shadows and
    /// emits light. An instance hides everything in its group.
    pub hidden_from_camera: bool,
    /// Whether it is left out of the picture: it is not seen, casts no shadow and emits no light. A hidden instance
    /// hides everything in its group.
    pub hidden: bool,
    /// From object space to the space of the scene or of the group that contains it.
    pub transform: Transform,
    /// Motion blur: the transform at time 1 of the shutter interval. `transform` is the one at time 0.
    pub motion: Option<Transform>,
}

/// The content of an object.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectContent {
    /// A shape.
    Shape(ShapeDesc),
    /// An instance of a group.
    Instance(GroupId),
}

impl Default for ObjectContent {
    /// The default shape.
    fn default() -> ObjectContent {
        ObjectContent::Shape(ShapeDesc::default())
    }
}

/// A named set of objects that instances place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupDesc {
    /// Its objects.
    pub objects: Vec<ObjectDesc>,
    /// The model file that it was made from, if any.
    pub model: Option<Box<ModelDesc>>,
}

/// A complete scene. The default is that of an empty scene file: no objects, 640x480 pixels, the integrator `classic`,
/// a black background.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDesc {
    /// The camera. Without one, Turner places a camera that shows the scene from the front.
    pub camera: Option<Named<CameraDesc>>,
    /// Size, sampling, transfer curve.
    pub film: FilmDesc,
    /// The integrator, which computes the radiance of camera rays.
    pub integrator: IntegratorDesc,
    /// The radiance of rays that hit nothing, and the medium that fills the scene.
    pub background: BackgroundDesc,
    /// Textures, named ones first.
    pub textures: Vec<Named<TextureDesc>>,
    /// Materials, named ones first.
    pub materials: Vec<Named<MaterialDesc>>,
    /// Participating media, named ones first.
    pub media: Vec<Named<MediumDesc>>,
    /// Groups.
    pub groups: Vec<Named<GroupDesc>>,
    /// Objects.
    pub objects: Vec<ObjectDesc>,
    /// Lights.
    pub lights: Vec<SceneLight>,
    /// Keyframes. The description has their values at one time, see [`SceneDesc::animate`].
    pub animations: Vec<Named<AnimationDesc>>,
    /// Images that textures and environment lights use.
    pub images: Vec<Asset<Image>>,
    /// Meshes that objects use.
    pub meshes: Vec<Asset<MeshData>>,
    /// Other cameras: `[[view]]` sections and the cameras of imported files. `camera` is the one that renders.
    pub cameras: Vec<Named<CameraDesc>>,
    /// The default studio: the camera, lights and floor that are added to a scene without them.
    pub studio: Option<StudioDesc>,
    /// Summaries of imported files.
    pub imports: Vec<ImportSummary>,
    /// Warnings from reading.
    pub warnings: Vec<Warning>,
}

impl SceneDesc {
    /// Whether any object or light moves while the shutter is open: an object has a `motion` that differs from its
    /// `transform`. A camera's own motion is a matter of the view.
    pub fn moves(&self) -> bool {
        let in_groups = self.groups.iter().flat_map(|group| &group.value.objects);
        let moves = |o: &ObjectDesc| o.motion.is_some_and(|motion| motion != o.transform);
        self.objects.iter().chain(in_groups).any(moves) || self.lights.iter().any(SceneLight::moves)
    }

    /// Whether the scene has keyframes or a model with an animation. Without one, all frames and times show the same.
    pub fn is_animated(&self) -> bool {
        if self.has_keyframes() {
            return true;
        }
        let animations = self.imports.iter().flat_map(|import| &import.counts);
        animations.into_iter().any(|(what, count)| *what == "animations" && *count > 0)
    }
}

/// The contents of an imported file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportSummary {
    /// The file.
    pub file: String,
    /// Its format, e.g. `glTF 2.0`.
    pub format: &'static str,
    /// What it contains, with counts, e.g. `("triangles", 12)`.
    pub counts: Vec<(&'static str, u64)>,
    /// Names in the file that a scene can select: of animations and of material variants.
    pub names: Vec<(&'static str, Vec<String>)>,
}
