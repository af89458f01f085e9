//! The comments in a converted scene: one for each section, and one for each key at its first occurrence, taken from
//! the documentation of the scene format.

use std::collections::BTreeSet;

use turner::animation::AnimationDesc;
use turner::camera::CameraDesc;
use turner::description::{SECTIONS, StudioDesc};
use turner::film::FilmDesc;
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::{EntryDoc, FamilyDoc};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;

/// Most characters of a comment.
const LONGEST: usize = 90;

/// Keys shared by all types of a section: section, key, comment.
const COMMON: &[(&str, &str, &str)] = &[
    ("camera", "type", "Camera type: turner list cameras"),
    ("integrator", "type", "Integrator: turner list integrators"),
    ("light", "type", "Light type: turner list lights"),
    ("light", "name", "Name in reports"),
    ("light", "light_group", "Light group of the light"),
    ("light", "hidden", "It does not shine"),
    ("light", "motion", "Motion blur: what moves it in a frame"),
    ("animation", "name", "Name"),
    ("view", "name", "Name for `camera` in [studio]"),
    ("texture", "type", "Texture type: turner list textures"),
    ("material", "type", "Material type: turner list materials"),
    ("medium", "type", "Medium type: turner list media"),
    ("object", "type", "Shape: turner list shapes"),
    ("object", "name", "Name in reports"),
    ("object", "material", "Name of a [material.NAME]"),
    ("object", "light_group", "Light group of its emission"),
    ("object", "shadow_catcher", "The camera sees only the shadow on it"),
    ("object", "hidden_from_camera", "Visible to all rays but those of the camera"),
    ("object", "hidden", "Left out of the picture"),
    ("object", "transform", "Scale first, then rotate, then translate; or the rows of a matrix"),
    ("object", "motion", "The transform at the end of the motion, for motion blur"),
    ("object", "group", "Name of a [group.NAME], which this object places"),
];

/// Keys that already have a comment.
#[derive(Debug, Default)]
pub(super) struct Comments {
    said: BTreeSet<(String, String, String)>,
}

impl Comments {
    /// The comment of a key of a type; `None` if it was already returned.
    pub(super) fn first(&mut self, section: &str, kind: &str, key: &str) -> Option<String> {
        let common = COMMON.iter().find(|(s, k, _)| (*s, *k) == (section, key));
        // Shared keys are explained once for all types.
        let place = (section.to_owned(), if common.is_some() { "" } else { kind }.to_owned(), key.to_owned());
        if !self.said.insert(place) {
            return None;
        }
        if let Some((.., words)) = common {
            return Some((*words).to_owned());
        }
        let entry = entry(section, kind)?;
        let field = entry.fields.iter().find(|f| f.name == key)?;
        Some(short(&field.doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")))
    }
}

fn entry(section: &str, kind: &str) -> Option<&'static EntryDoc> {
    let of = |family: &FamilyDoc| family.entries.iter().copied().find(|e| e.name == kind);
    match section {
        "camera" | "view" => of(&CameraDesc::DOC),
        "film" => Some(&FilmDesc::DOC),
        "integrator" => of(&IntegratorDesc::DOC),
        "background" => Some(&BackgroundDesc::DOC),
        "studio" => Some(&StudioDesc::DOC),
        "animation" => Some(&AnimationDesc::DOC),
        "light" => of(&LightDesc::DOC),
        "medium" => of(&MediumDesc::DOC),
        "texture" => of(&TextureDesc::DOC),
        "material" => of(&MaterialDesc::DOC),
        "object" => of(&ShapeDesc::DOC),
        _ => None,
    }
}

/// The comment above a section.
pub(super) fn heading(section: &str) -> String {
    let what = SECTIONS.iter().find(|(name, _)| *name == section).map_or(section, |(_, what)| what);
    let mut letters = what.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The first sentence, shortened at punctuation if too long.
fn short(text: &str) -> String {
    let sentence = text.split_once(". ").map_or(text, |(first, _)| first).trim_end_matches('.');
    if sentence.chars().count() <= LONGEST {
        return sentence.to_owned();
    }
    let cut: String = sentence.chars().take(LONGEST).collect();
    let end = cut.rfind([';', ':', ',']).or_else(|| cut.rfind(' ')).unwrap_or(cut.len());
    let cut = cut.get(..end).unwrap_or_default();
    // Do not cut inside parentheses.
    let open = cut.rfind(" (").filter(|at| !cut[*at..].contains(')'));
    cut.get(..open.unwrap_or(cut.len())).unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_is_explained_once() {
        let mut comments = Comments::default();
        assert!(comments.first("camera", "pinhole", "position").is_some());
        assert_eq!(comments.first("camera", "pinhole", "position"), None);
        assert!(comments.first("object", "sphere", "material").is_some());
        assert_eq!(comments.first("object", "box", "material"), None);
        assert_eq!(comments.first("object", "box", "no such key"), None);
        assert!(heading("camera").starts_with(char::is_uppercase));
    }

    #[test]
    fn every_section_and_kind_is_known() {
        let sections = SECTIONS.iter().filter(|(name, _)| !matches!(*name, "include" | "group"));
        for (section, _) in sections {
            let kind = match *section {
                "camera" | "view" => "pinhole",
                "integrator" => "path",
                "light" => "point",
                "medium" => "homogeneous",
                "texture" => "image",
                "material" => "principled",
                "object" => "mesh",
                _ => "",
            };
            let entry = entry(section, kind).unwrap_or_else(|| panic!("{section}"));
            for field in entry.fields {
                let words = short(&field.doc.join(" "));
                assert!(!words.is_empty() && words.chars().count() <= LONGEST, "{section} {}", field.name);
            }
        }
    }
}
