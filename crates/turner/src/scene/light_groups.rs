//! Groups of lights: what shines together, by name.

use crate::scene::Scene;

/// Which light and which object belongs to which group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightGroups {
    names: Vec<String>,
    /// For each light of the prepared scene.
    of_light: Vec<Option<u32>>,
    /// Primitives from this number in the description on, up to the next entry.
    runs: Vec<(u32, Option<u32>)>,
}

impl LightGroups {
    /// Their names in the order in which the description has them: lights first.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The group of a light, by its number among the prepared scene's.
    pub fn of_light(&self, light: u32) -> Option<u32> {
        self.of_light.get(light as usize).copied().flatten()
    }

    /// The group of a primitive, by its number in the description.
    pub fn of_primitive(&self, primitive: u32) -> Option<u32> {
        let behind = self.runs.partition_point(|(first, _)| *first <= primitive);
        self.runs.get(behind.checked_sub(1)?)?.1
    }

    /// Of the prepared scene's lights, by the name of their group.
    pub(crate) fn of_lights<'a>(groups_of_lights: impl Iterator<Item = Option<&'a str>>) -> LightGroups {
        let mut groups = LightGroups::default();
        for name in groups_of_lights {
            let group = name.map(|name| groups.number(name));
            groups.of_light.push(group);
        }
        groups
    }

    /// Whether lights that are named so give the same numbers to the groups of objects.
    pub(crate) fn begins_with(&self, lights: &LightGroups) -> bool {
        self.names.starts_with(&lights.names)
    }

    /// The same objects beside other lights, whose groups [begin](Self::begins_with) like the old ones.
    pub(crate) fn with_lights(&self, lights: LightGroups) -> LightGroups {
        LightGroups { of_light: lights.of_light, ..self.clone() }
    }

    /// The number of a name.
    pub(crate) fn number(&mut self, name: &str) -> u32 {
        if let Some(i) = self.names.iter().position(|n| n == name) {
            return i as u32;
        }
        self.names.push(name.to_owned());
        self.names.len() as u32 - 1
    }

    /// The primitive `first` and those after it belong to a group, or to none.
    pub(crate) fn add(&mut self, first: u32, group: Option<u32>) {
        if self.runs.last().and_then(|(_, last)| *last) != group {
            self.runs.push((first, group));
        }
    }
}

impl Scene {
    /// For each group of lights its name, how many lights it has, and how many primitives.
    pub fn light_group_counts(&self) -> Vec<(&str, u64, u64)> {
        let groups = &self.light_groups;
        let mut out: Vec<(&str, u64, u64)> = groups.names.iter().map(|n| (n.as_str(), 0, 0)).collect();
        for group in groups.of_light.iter().flatten() {
            if let Some(entry) = out.get_mut(*group as usize) {
                entry.1 += 1;
            }
        }
        for (id, _) in self.primitive_materials() {
            if let Some(entry) = groups.of_primitive(id).and_then(|g| out.get_mut(g as usize)) {
                entry.2 += 1;
            }
        }
        out
    }
}
