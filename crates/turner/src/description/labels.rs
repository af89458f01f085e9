//! Names of objects, materials and lights for messages.

use std::fmt;

use crate::description::SceneDesc;
use crate::light::{Light, LightDesc};
use crate::scene::{ListedEmitter, Scene};
use crate::schema::MaterialId;

/// The name of an object, a material or a light for messages. `Display` puts names from the scene in quotes: `"bulb"`,
/// but `the point light`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The name or, without one, a description: `bulb`, `point light`, `sphere #4`. Not escaped for a terminal or HTML.
    pub text: String,
    /// Whether `text` is a name from the scene.
    pub is_name: bool,
}

impl Label {
    fn new(name: Option<String>, fallback: impl FnOnce() -> String) -> Label {
        let is_name = name.is_some();
        Label { text: name.unwrap_or_else(fallback), is_name }
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.is_name {
            true => write!(f, "\"{}\"", self.text),
            false => write!(f, "the {}", self.text),
        }
    }
}

/// Names the objects, materials and lights of a scene by its description. Names are not escaped for a terminal or HTML.
#[derive(Clone, Copy)]
pub struct Labels<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The description that the scene was prepared from.
    pub desc: &'a SceneDesc,
}

impl Labels<'_> {
    /// The name of a primitive: `ball`, `tree / leaf` in an instance, or `sphere #4` without a name. The number is the
    /// ID that the integrator `ids` shows.
    pub fn object(&self, primitive: u32, shape: &str) -> String {
        let name = self.scene.object_name(primitive);
        let own = name.own.map_or_else(|| format!("{shape} #{primitive}"), str::to_owned);
        match name.instance {
            Some(instance) => format!("{instance} / {own}"),
            None => own,
        }
    }

    /// The same as a [`Label`].
    pub fn object_label(&self, primitive: u32, shape: &str) -> Label {
        Label { text: self.object(primitive, shape), is_name: true }
    }

    /// The name of a material or, without one, its type: `matte material`.
    pub fn material(&self, id: MaterialId) -> String {
        self.material_label(id).text
    }

    /// The same as a [`Label`].
    pub fn material_label(&self, id: MaterialId) -> Label {
        let desc = self.desc.materials.get(id.index());
        let kind = || {
            desc.map_or_else(|| "default material".into(), |m| format!("{} material", m.value.type_name()))
        };
        Label::new(desc.and_then(|m| m.name.clone()), kind)
    }

    /// A light by its index in the prepared scene: its name or, without one, its type, with its position if several
    /// lights have that type.
    pub fn light(&self, light: u32) -> String {
        self.light_label(light).text
    }

    /// The same as a [`Label`].
    pub fn light_label(&self, light: u32) -> Label {
        let prepared = self.scene.lights.get(light as usize);
        let own = self.scene.light_sources.get(light as usize).copied().flatten();
        let Some(own) = own.filter(|i| (*i as usize) < self.desc.lights.len()) else {
            let kind = match prepared {
                Some(Light::Environment(_)) if self.desc.studio.is_some() => "built-in studio light",
                Some(Light::Environment(_)) => "environment light",
                Some(Light::Directional(_)) => "directional light",
                Some(Light::Point(_)) => "point light",
                Some(Light::Spot(_)) => "spot light",
                Some(Light::Area(_)) => "area light",
                None => "light",
            };
            return Label::new(None, || kind.to_owned());
        };
        let mut label = self.light_of_description(own);
        // A sky is prepared as two lights: the sky and the sun.
        let is_sky = matches!(self.desc.lights.get(own as usize).map(|l| &l.value), Some(LightDesc::Sky(_)));
        if is_sky && matches!(prepared, Some(Light::Directional(_))) {
            label = Label::new(None, || match label.is_name {
                true => format!("sun of \"{}\"", label.text),
                false => format!("sun of the {}", label.text),
            });
        }
        label
    }

    /// The same for a light given by its index in the description.
    pub fn light_of_description(&self, light: u32) -> Label {
        let Some(own) = self.desc.lights.get(light as usize) else {
            return Label::new(None, || "light".into());
        };
        Label::new(own.name.clone(), || {
            let kind = own.value.type_name();
            let alike =
                || self.desc.lights.iter().filter(|l| l.value.type_name() == kind && l.name.is_none());
            if alike().count() < 2 {
                return format!("{kind} light");
            }
            let index = self.scene.light_sources.iter().position(|source| *source == Some(light));
            let bounds = index.and_then(|i| self.scene.emitter_bounds(ListedEmitter::Light(i as u32)));
            match bounds.map(|b| b.center()).filter(|p| p.is_finite()) {
                Some(p) => format!("{kind} light at ({}, {}, {})", short(p.x), short(p.y), short(p.z)),
                None => {
                    let before = self.desc.lights.iter().take(light as usize + 1);
                    let nth = before.filter(|l| l.value.type_name() == kind && l.name.is_none()).count();
                    format!("{} {kind} light", ordinal(nth))
                }
            }
        })
    }
}

/// A coordinate with at most three decimals.
fn short(v: f64) -> f64 {
    let rounded = (v * 1e3).round() * 1e-3;
    // Adding 0 turns −0 into 0; dividing by 1e3 removes the digits that the product leaves.
    (rounded * 1e3).round() / 1e3 + 0.0
}

/// `1st`, `2nd`, `11th`.
fn ordinal(n: usize) -> String {
    let ending = match (n % 10, n % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{n}{ending}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordinals_end_as_they_are_spoken() {
        let all: Vec<String> = [1, 2, 3, 4, 11, 12, 13, 21, 112].into_iter().map(ordinal).collect();
        assert_eq!(all, ["1st", "2nd", "3rd", "4th", "11th", "12th", "13th", "21st", "112th"]);
    }

    #[test]
    fn names_are_quoted_and_types_have_an_article() {
        let name = Label { text: "bulb".into(), is_name: true };
        let kind = Label { text: "point light".into(), is_name: false };
        assert_eq!([name.to_string(), kind.to_string()], ["\"bulb\"", "the point light"]);
    }

    #[test]
    fn coordinates_are_short() {
        assert_eq!([short(0.1 + 0.2), short(-1e-9), short(12.3456)], [0.3, 0.0, 12.346]);
    }
}
