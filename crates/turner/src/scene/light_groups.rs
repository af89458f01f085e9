//! Light groups: lights and emissive objects that share a name, rendered to a channel of their own.

use crate::scene::Scene;

/// The light group of each light and each object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightGroups {
    names: Vec<String>,
    /// For each light of the prepared scene.
    of_light: Vec<Option<u32>>,
    /// Group of the primitives from this ID up to the next entry.
    runs: Vec<(u32, Option<u32>)>,
}

impl LightGroups {
    /// Group names in the order of the description, lights first.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The group of a light, by its index in the prepared scene.
    pub fn of_light(&self, light: u32) -> Option<u32> {
        self.of_light.get(light as usize).copied().flatten()
    }

    /// The group of a primitive, by its ID.
    pub fn of_primitive(&self, primitive: u32) -> Option<u32> {
        let behind = self.runs.partition_point(|(first, _)| *first <= primitive);
        self.runs.get(behind.checked_sub(1)?)?.1
    }

    /// From the group names of the prepared scene's lights.
    pub(crate) fn of_lights<'a>(groups_of_lights: impl Iterator<Item = Option<&'a str>>) -> LightGroups {
        let mut groups = LightGroups::default();
        for name in groups_of_lights {
            let group = name.map(|name| groups.number(name));
            groups.of_light.push(group);
        }
        groups
    }

    /// Whether the groups of these lights keep the indices that objects already use.
    pub(crate) fn begins_with(&self, lights: &LightGroups) -> bool {
        self.names.starts_with(&lights.names)
    }

    /// The same objects with other lights, whose groups [begin](Self::begins_with) like the old ones.
    pub(crate) fn with_lights(&self, lights: LightGroups) -> LightGroups {
        LightGroups { of_light: lights.of_light, ..self.clone() }
    }

    /// The index of a name; adds it if it is new.
    pub(crate) fn number(&mut self, name: &str) -> u32 {
        if let Some(i) = self.names.iter().position(|n| n == name) {
            return i as u32;
        }
        self.names.push(name.to_owned());
        self.names.len() as u32 - 1
    }

    /// Assigns primitive `first` and the following ones to a group, or to none.
    pub(crate) fn add(&mut self, first: u32, group: Option<u32>) {
        if self.runs.last().and_then(|(_, last)| *last) != group {
            self.runs.push((first, group));
        }
    }
}

impl Scene {
    /// The group of a primitive, by its index in the prepared scene.
    #[inline]
    pub(crate) fn light_group_of(&self, primitive: u32) -> Option<u32> {
        self.light_groups.of_primitive(self.primitives.get(primitive as usize)?.id)
    }

    /// For each group its name, its number of lights, and its number of primitives.
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
