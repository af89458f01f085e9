//! The words that fit at a place of a scene, from the schema.

use serde_json::{Value as Json, json};
use turner::SceneDesc;
use turner::animation::AnimationDesc;
use turner::camera::CameraDesc;
use turner::description::{ModelDesc, StudioDesc};
use turner::film::FilmDesc;
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::{EntryDoc, FamilyDoc, Field};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_live::node::{GROUP, MOTION, OBJECT_KEYS};

use super::context::Context;
use super::paragraph;

/// A word to choose.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub(super) label: String,
    pub(super) insert: String,
    pub(super) kind: &'static str,
    pub(super) detail: String,
    pub(super) doc: String,
}

impl Item {
    pub(super) fn json(self) -> Json {
        json!({ "label": self.label, "insert": self.insert, "kind": self.kind, "detail": self.detail, "doc": self.doc })
    }
}

/// The sections of a scene: header, whether it is a list, meaning.
const SECTIONS: &[(&str, bool, &str)] = &[
    ("camera", false, "The camera that renders."),
    ("film", false, "Size, samples and display of the picture."),
    ("integrator", false, "The algorithm that computes light."),
    ("background", false, "What rays meet that leave the scene."),
    ("studio", false, "Lights, floor and camera around models."),
    ("object", true, "An object: a shape, a model or an instance."),
    ("light", true, "A light."),
    ("view", true, "A camera bookmark."),
    ("animation", true, "Keyframes of a value."),
    ("material.NAME", false, "A material that objects refer to by its name."),
    ("texture.NAME", false, "A texture that materials refer to by its name."),
    ("medium.NAME", false, "A participating medium: fog, smoke, a tinted glass."),
    ("group.NAME", false, "Objects that instances place in the scene."),
];

/// The keys of the table at the cursor.
pub(super) struct Vocabulary<'a> {
    family: Option<&'static FamilyDoc>,
    fields: Vec<&'static Field>,
    /// Whether it is the top of the file, or an object.
    is_top: bool,
    is_object: bool,
    desc: &'a SceneDesc,
}

/// What a table can be.
#[derive(Clone, Copy)]
enum Place {
    Top,
    Family(&'static FamilyDoc),
    Section(&'static EntryDoc),
    Unknown,
}

/// The table at a path from the top of the file.
fn place(path: &[&str]) -> Place {
    let (first, rest) = match path {
        [] => return Place::Top,
        ["material" | "texture" | "medium"] => return Place::Unknown,
        ["group", _, "object", rest @ ..] => ("object", rest),
        ["group", ..] => return Place::Unknown,
        [kind @ ("material" | "texture" | "medium"), _, rest @ ..] => (*kind, rest),
        [first, rest @ ..] => (*first, rest),
    };
    let own = match first {
        "object" => Place::Family(&ShapeDesc::DOC),
        "light" => Place::Family(&LightDesc::DOC),
        "material" => Place::Family(&MaterialDesc::DOC),
        "texture" => Place::Family(&TextureDesc::DOC),
        "medium" => Place::Family(&MediumDesc::DOC),
        "camera" | "view" => Place::Family(&CameraDesc::DOC),
        "integrator" => Place::Family(&IntegratorDesc::DOC),
        "film" => Place::Section(&FilmDesc::DOC),
        "background" => Place::Section(&BackgroundDesc::DOC),
        "studio" => Place::Section(&StudioDesc::DOC),
        "animation" => Place::Section(&AnimationDesc::DOC),
        _ => Place::Unknown,
    };
    rest.iter().fold(own, |own, key| nested(own, key))
}

/// The table that is the value of a key.
fn nested(place: Place, key: &str) -> Place {
    let fields: Vec<&Field> = match place {
        Place::Family(family) => {
            let own = family.entries.iter().flat_map(|entry| entry.fields);
            own.chain(OBJECT_KEYS).filter(|field| field.name == key).collect()
        }
        Place::Section(entry) => entry.fields.iter().filter(|field| field.name == key).collect(),
        Place::Top | Place::Unknown => Vec::new(),
    };
    let takes = |word: &str| {
        fields.iter().any(|field| {
            (field.kind)().split(" | ").any(|kind| kind.trim_matches(['[', ']', '…', ',', ' ']) == word)
        })
    };
    match () {
        () if takes("material") => Place::Family(&MaterialDesc::DOC),
        () if takes("texture") => Place::Family(&TextureDesc::DOC),
        () if takes("medium") => Place::Family(&MediumDesc::DOC),
        () => Place::Unknown,
    }
}

impl<'a> Vocabulary<'a> {
    pub(super) fn of(context: &Context, desc: &'a SceneDesc) -> Vocabulary<'a> {
        let path: Vec<&str> = context.path.iter().map(String::as_str).collect();
        let place = place(&path);
        let is_object = matches!(path.as_slice(), ["object"] | ["group", _, "object"]);
        let mut fields: Vec<&'static Field> = Vec::new();
        let family = match place {
            Place::Family(family) => {
                let kind = context.kind.as_deref();
                let is_model = is_object && kind == Some(ModelDesc::DOC.name);
                let model = is_model.then_some(&ModelDesc::DOC);
                let own = kind
                    .map_or(family.entries.first(), |kind| family.entries.iter().find(|e| e.name == kind));
                fields.extend(model.or(own.copied()).into_iter().flat_map(|entry| entry.fields));
                Some(family)
            }
            Place::Section(entry) => {
                fields.extend(entry.fields);
                None
            }
            Place::Top | Place::Unknown => None,
        };
        if is_object {
            fields.extend(OBJECT_KEYS.iter().chain([&MOTION, &GROUP]));
        }
        Vocabulary { family, fields, is_top: matches!(place, Place::Top), is_object, desc }
    }

    pub(super) fn field(&self, key: &str) -> Option<&'static Field> {
        self.fields.iter().find(|field| field.name == key).copied()
    }

    pub(super) fn sections(&self) -> Vec<Item> {
        let each = SECTIONS.iter().map(|&(name, is_list, doc)| Item {
            label: name.to_owned(),
            insert: name.to_owned(),
            kind: "section",
            detail: if is_list { format!("[[{name}]]") } else { format!("[{name}]") },
            doc: doc.to_owned(),
        });
        each.collect()
    }

    /// The keys that the table does not have yet.
    pub(super) fn keys(&self, context: &Context) -> Vec<Item> {
        if self.is_top {
            let header =
                |item: Item| Item { insert: item.detail.clone(), label: item.detail.clone(), ..item };
            return self.sections().into_iter().map(header).collect();
        }
        let kind = self.family.map(|family| Item {
            label: "type".into(),
            insert: "type = ".into(),
            kind: "key",
            detail: family.one.to_owned(),
            doc: paragraph(family.doc),
        });
        let own = self.fields.iter().map(|field| Item {
            label: field.name.to_owned(),
            insert: format!("{} = ", field.name),
            kind: "key",
            detail: (field.kind)(),
            doc: described(field),
        });
        let typed = |label: &str| !context.written.iter().any(|own| own == label);
        kind.into_iter().chain(own).filter(|item| typed(&item.label)).collect()
    }

    pub(super) fn values(&self, key: &str) -> Vec<Item> {
        let item = |label: &str, insert: String, kind, doc: String| Item {
            label: label.to_owned(),
            insert,
            kind,
            detail: String::new(),
            doc,
        };
        let quoted = |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
        if key == "type" {
            let own = self.family.into_iter().flat_map(|family| family.entries.iter().copied());
            let all = own.chain(self.is_object.then_some(&ModelDesc::DOC));
            return all.map(|e| item(e.name, quoted(e.name), "type", paragraph(e.doc))).collect();
        }
        let Some(field) = self.field(key) else { return Vec::new() };
        let words = (field.words)();
        if !words.is_empty() {
            return words
                .iter()
                .map(|(word, doc)| item(word, quoted(word), "value", (*doc).to_owned()))
                .collect();
        }
        let kind = (field.kind)();
        let takes = |word: &str| kind.split(" | ").any(|own| own == word);
        let names = self.desc.names();
        let mut out = Vec::new();
        if takes("true") {
            out.extend(
                ["true", "false"].map(|word| item(word, word.to_owned(), "value", paragraph(field.doc))),
            );
        }
        for (word, list) in [
            ("material", &names.materials),
            ("texture", &names.textures),
            ("medium", &names.media),
            ("group", &names.groups),
        ] {
            if takes(word) {
                out.extend(list.iter().map(|name| item(name, quoted(name), "value", word.to_owned())));
            }
        }
        if let Some(default) = field.default {
            let text = default();
            if text.starts_with(|c: char| c.is_ascii_digit() || "-[\"".contains(c)) {
                out.push(Item {
                    detail: "default".into(),
                    ..item(&text, text.clone(), "value", described(field))
                });
            }
        }
        out
    }
}

/// What a key means, with its range and its default.
fn described(field: &Field) -> String {
    let range = field.range.map_or(String::new(), |range| format!(" Range: {range}."));
    let default = field.default.map_or(" Required.".to_owned(), |show| format!(" Default: {}.", show()));
    format!("{}{range}{default}", paragraph(field.doc))
}
