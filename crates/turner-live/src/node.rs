//! Parts of a scene that can be selected, and their key paths.

use turner::camera::CameraDesc;
use turner::description::{ObjectContent, SceneDesc};
use turner::film::FilmDesc;
use turner::integrator::IntegratorDesc;
use turner::light::LightDesc;
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::{FamilyDoc, Field, path_part};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;

/// A part of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Node {
    /// An entry of the list of objects.
    Object(usize),
    /// A light.
    Light(usize),
    /// A material.
    Material(usize),
    /// A texture.
    Texture(usize),
    /// A participating medium.
    Medium(usize),
    /// The camera that renders.
    Camera,
    /// A camera bookmark: a `[[view]]`.
    View(usize),
    /// The film.
    Film,
    /// The integrator.
    Integrator,
    /// The background.
    Background,
    /// The default studio.
    Studio,
}

fn named(name: &Option<String>, kind: &str, index: usize) -> String {
    name.clone().unwrap_or_else(|| format!("{kind} {}", index + 1))
}

impl Node {
    /// Whether the scene has it.
    pub fn exists(self, desc: &SceneDesc) -> bool {
        match self {
            Node::Object(i) => i < desc.objects.len(),
            Node::Light(i) => i < desc.lights.len(),
            Node::Material(i) => i < desc.materials.len(),
            Node::Texture(i) => i < desc.textures.len(),
            Node::Medium(i) => i < desc.media.len(),
            Node::View(i) => i < desc.cameras.len(),
            Node::Studio => desc.studio.is_some(),
            Node::Camera | Node::Film | Node::Integrator | Node::Background => true,
        }
    }

    /// Its name for people.
    pub fn label(self, desc: &SceneDesc) -> String {
        match self {
            Node::Object(i) => desc.objects.get(i).map_or_else(String::new, |object| {
                let kind = match &object.content {
                    ObjectContent::Shape(shape) => shape.type_name(),
                    ObjectContent::Instance(_) => "instance",
                };
                named(&object.name, kind, i)
            }),
            Node::Light(i) => desc.lights.get(i).map_or_else(String::new, |light| {
                named(&light.name, &format!("{} light", light.value.type_name()), i)
            }),
            Node::Material(i) => {
                desc.materials.get(i).map_or_else(String::new, |m| named(&m.name, "material", i))
            }
            Node::Texture(i) => {
                desc.textures.get(i).map_or_else(String::new, |t| named(&t.name, "texture", i))
            }
            Node::Medium(i) => desc.media.get(i).map_or_else(String::new, |m| named(&m.name, "medium", i)),
            Node::View(i) => desc.cameras.get(i).map_or_else(String::new, |c| named(&c.name, "view", i)),
            Node::Camera => "Camera".into(),
            Node::Film => "Film".into(),
            Node::Integrator => "Integrator".into(),
            Node::Background => "Background".into(),
            Node::Studio => "Default studio".into(),
        }
    }

    /// The family of its types, if it has a key `type`.
    pub fn family(self) -> Option<&'static FamilyDoc> {
        match self {
            Node::Object(_) => Some(&ShapeDesc::DOC),
            Node::Light(_) => Some(&LightDesc::DOC),
            Node::Material(_) => Some(&MaterialDesc::DOC),
            Node::Texture(_) => Some(&TextureDesc::DOC),
            Node::Medium(_) => Some(&MediumDesc::DOC),
            Node::Camera | Node::View(_) => Some(&CameraDesc::DOC),
            Node::Integrator => Some(&IntegratorDesc::DOC),
            Node::Film | Node::Background | Node::Studio => None,
        }
    }

    /// The documentation of a node without types.
    pub fn entry(self) -> Option<&'static turner::schema::EntryDoc> {
        match self {
            Node::Film => Some(&FilmDesc::DOC),
            Node::Background => Some(&turner::light::BackgroundDesc::DOC),
            Node::Studio => Some(&turner::description::StudioDesc::DOC),
            _ => None,
        }
    }
}

impl Node {
    /// Its key path. `None` if the scene does not have it.
    pub fn path(self, names: &turner::description::PartNames) -> Option<String> {
        let of = |list: &[String], kind: &str, i: usize| {
            list.get(i).map(|name| format!("{kind}.{}", path_part(name)))
        };
        match self {
            Node::Object(i) => Some(format!("object.{i}")),
            Node::Light(i) => Some(format!("light.{i}")),
            Node::View(i) => Some(format!("view.{i}")),
            Node::Material(i) => of(&names.materials, "material", i),
            Node::Texture(i) => of(&names.textures, "texture", i),
            Node::Medium(i) => of(&names.media, "medium", i),
            Node::Camera => Some("camera".into()),
            Node::Film => Some("film".into()),
            Node::Integrator => Some("integrator".into()),
            Node::Background => Some("background".into()),
            Node::Studio => Some("studio".into()),
        }
    }
}

impl Node {
    /// The part that a key path names.
    pub fn of_path(path: &str, names: &turner::description::PartNames) -> Option<Node> {
        let (kind, name) = path.split_once('.').unwrap_or((path, ""));
        let index = || name.parse::<usize>().ok();
        let of = |list: &[String]| list.iter().position(|own| path_part(own) == name);
        match kind {
            "object" => index().map(Node::Object),
            "light" => index().map(Node::Light),
            "view" => index().map(Node::View),
            "material" => of(&names.materials).map(Node::Material),
            "texture" => of(&names.textures).map(Node::Texture),
            "medium" => of(&names.media).map(Node::Medium),
            "camera" => Some(Node::Camera),
            "film" => Some(Node::Film),
            "integrator" => Some(Node::Integrator),
            "background" => Some(Node::Background),
            "studio" => Some(Node::Studio),
            _ => None,
        }
    }
}

/// A key that all objects have.
const fn common(name: &'static str, kind: fn() -> String, doc: &'static [&'static str]) -> Field {
    Field { name, kind, words: || &[], default: Some(|| "none".into()), doc, range: None }
}

/// The keys of all objects, besides the transform and [`MOTION`].
pub const OBJECT_KEYS: &[Field] = &[
    common("name", || "\"text\"".into(), &["The name, for messages and reports."]),
    common("material", || "material".into(), &["Its material."]),
    common("light_group", || "\"text\"".into(), &["Its light group if it emits light."]),
    common(
        "shadow_catcher",
        || "true | false".into(),
        &["Whether the camera sees nothing of it but the shadow on it."],
    ),
    common(
        "hidden_from_camera",
        || "true | false".into(),
        &["Whether rays from the camera pass through it, and all others meet it."],
    ),
    common("hidden", || "true | false".into(), &["Whether it is left out of the picture."]),
];

/// The transform of an object that moves.
pub const MOTION: Field = common(
    "motion",
    || "transform".into(),
    &["Its transform at the end of the shutter interval: motion blur."],
);

/// The group of an instance.
pub const GROUP: Field = common("group", || "group".into(), &["The group that it places in the scene."]);
