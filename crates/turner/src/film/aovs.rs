//! The key `aovs` of a film: a list of AOVs.

use super::Aov;
use crate::schema::error::{escape, unknown_name};
use crate::schema::value::{Data, Value};
use crate::schema::write::list;
use crate::schema::{ErrorCode, ParamType, ReadContext, SceneError, WriteContext, foreign, wrong_type};

/// The AOVs of a film, each once, in the order of [`Aov::all`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Aovs {
    asked: Vec<Aov>,
    /// The layers of [`Aov::LightGroups`] but the last, known once a scene is prepared.
    light_groups: Vec<String>,
    /// Whether the prepared scene has shadow catchers.
    catches_shadows: bool,
    /// Whether the film holds what the denoiser needs.
    denoises: bool,
}

/// The layer of light that comes from no light group.
const NO_GROUP: &str = "default";

/// The light groups of a scene that have layers of their own, with their indices.
pub(crate) fn layers(names: &[String]) -> impl Iterator<Item = (usize, &str)> {
    names.iter().map(String::as_str).enumerate().filter(|(_, name)| *name != NO_GROUP)
}

impl Aovs {
    /// From AOVs in any order; each may be there several times.
    pub fn new(asked: &[Aov]) -> Aovs {
        Aovs { asked: Aov::all().filter(|aov| asked.contains(aov)).collect(), ..Aovs::default() }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.asked.is_empty()
    }

    /// Whether an AOV is among them.
    pub fn contains(&self, aov: Aov) -> bool {
        self.asked.contains(&aov)
    }

    /// The AOVs, in the order of [`Aov::all`].
    pub fn iter(&self) -> impl Iterator<Item = Aov> + '_ {
        self.asked.iter().copied()
    }

    /// Sets what the film has to know of the scene: its light groups, and whether it has shadow catchers. A light group
    /// with the name "default" is that of all light without a group.
    pub fn know_scene(&mut self, light_groups: &[String], catches_shadows: bool) {
        self.light_groups.clear();
        if self.contains(Aov::LightGroups) {
            for (_, name) in layers(light_groups) {
                let layer = layer_name(name);
                let is_taken = |layer: &String| self.light_groups.contains(layer) || layer == NO_GROUP;
                let numbered =
                    std::iter::successors(Some(2u32), |n| Some(n + 1)).map(|n| format!("{layer}_{n}"));
                let free = std::iter::once(layer.clone()).chain(numbered).find(|layer| !is_taken(layer));
                self.light_groups.extend(free);
            }
        }
        self.catches_shadows = catches_shadows;
    }

    /// Makes the film hold what the denoiser needs.
    pub(crate) fn hold_guides(&mut self) {
        self.denoises = true;
    }

    /// The AOVs for which the film holds sums of values, in the order of their channels.
    pub(crate) fn summed(&self) -> impl Iterator<Item = Aov> + '_ {
        let guides = self.denoises && !self.contains(Aov::Denoising);
        self.iter().filter(|aov| aov.has_sums()).chain(guides.then_some(Aov::Denoising))
    }

    /// Whether the scene has shadow catchers, so that the film holds what they receive.
    pub fn catches_shadows(&self) -> bool {
        self.catches_shadows
    }

    /// Whether samples have values besides their colour.
    pub fn has_channels(&self) -> bool {
        self.catches_shadows || self.denoises || !self.is_empty()
    }

    /// The names of an AOV's channels in an EXR file; for Cryptomatte that of the layers.
    pub fn channels_of(&self, aov: Aov) -> Vec<String> {
        let channels = aov.layout().channels;
        if aov != Aov::LightGroups {
            return channels.iter().map(|name| (*name).to_owned()).collect();
        }
        let layers = self.light_groups.iter().map(String::as_str).chain([NO_GROUP]);
        layers.flat_map(|layer| channels.iter().map(move |name| name.replace("NAME", layer))).collect()
    }
}

/// The name of a light group in an EXR file, whose names are printable ASCII.
fn layer_name(group: &str) -> String {
    const LONGEST: usize = 200;
    let printable = |c: char| if c.is_ascii_graphic() || c == ' ' { c } else { '_' };
    group.chars().take(LONGEST).map(printable).collect()
}

fn read_one(value: &Value) -> Result<Aov, SceneError> {
    let Data::String(word) = &value.data else {
        return Err(wrong_type(value, "the name of an AOV"));
    };
    if let Some(aov) = Aov::from_word(word) {
        return Ok(aov);
    }
    if let Some(remedy) = foreign::kind("aov", word) {
        let message = format!("there is no AOV \"{}\"", escape(word));
        return Err(SceneError::at(ErrorCode::UnknownName, value.span, message).help(remedy));
    }
    Err(unknown_name(ErrorCode::UnknownName, value.span, "AOV", word, Aov::WORDS))
}

impl ParamType for Aovs {
    fn kind() -> String {
        "[\"aov\", …]".into()
    }
    fn words() -> &'static [(&'static str, &'static str)] {
        Aov::DOCS
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Aovs, SceneError> {
        match &value.data {
            Data::Array(items) => {
                let mut asked = Vec::new();
                for item in items {
                    let read = read_one(item);
                    asked.extend(cx.noted(read)?);
                }
                Ok(Aovs::new(&asked))
            }
            Data::String(_) => read_one(value).map(|aov| Aovs::new(&[aov])),
            _ => Err(wrong_type(value, "an array of names, such as [\"albedo\", \"normal\"]")),
        }
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(|aov| aov.show()).collect::<Vec<_>>().join(", "))
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(list(self.iter().map(|aov| Data::String(aov.word().to_owned())))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_of_light_groups_have_different_printable_names() {
        let mut aovs = Aovs::new(&[Aov::LightGroups]);
        let groups = ["key light", "default", "Küche", "Köche", "a.b", &"x".repeat(300)].map(str::to_owned);
        aovs.know_scene(&groups, false);
        let names = aovs.channels_of(Aov::LightGroups);
        let red: Vec<&str> = names.iter().step_by(3).map(String::as_str).collect();
        let long = format!("light.{}.R", "x".repeat(200));
        let expected = [
            "light.key light.R",
            "light.K_che.R",
            "light.K_che_2.R",
            "light.a.b.R",
            &long,
            "light.default.R",
        ];
        assert_eq!(red, expected);
        assert_eq!(layers(&groups).map(|(i, _)| i).collect::<Vec<_>>(), [0, 2, 3, 4, 5]);
        // Without the AOV there are no layers.
        let mut none = Aovs::new(&[Aov::Depth]);
        none.know_scene(&groups, true);
        assert!(none.has_channels() && none.light_groups.is_empty());
    }
}
