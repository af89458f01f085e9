//! Removing parts of a description.

use std::collections::BTreeSet;

use super::parts::{index, no_part};
use super::references::{of_light, of_object, of_part};
use crate::description::*;
use crate::schema::error::escape;
use crate::schema::{ErrorCode, KeyPart, PartId, Renumber, SceneError};

impl SceneDesc {
    /// Removes objects, lights, views, materials, textures, media and groups by their key paths. All paths are those
    /// before the removal. Materials that were written in place and everything that a model brought go with the last
    /// object that uses them.
    ///
    /// Errors: a path that names no such part; a material, texture, medium or group that is still in use, with what
    /// uses it. The description then stays the same.
    pub fn remove(&mut self, paths: &[&str]) -> Result<(), SceneError> {
        let names = self.names();
        let (mut objects, mut lights, mut views) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        let mut of_groups: BTreeSet<(usize, usize)> = BTreeSet::new();
        let mut parts: Vec<PartId> = Vec::new();
        for path in paths {
            let keys = KeyPart::split(path);
            let keys: Vec<&str> = keys.iter().map(|part| part.key.as_str()).collect();
            let number = |names: &[String], name: &str| {
                names.iter().position(|own| own == name).map(|i| i as u32).ok_or_else(|| no_part(path))
            };
            match keys.as_slice() {
                ["object", key] => _ = objects.insert(index(path, key, self.objects.len())?),
                ["light", key] => _ = lights.insert(index(path, key, self.lights.len())?),
                ["view", key] => _ = views.insert(index(path, key, self.cameras.len())?),
                ["texture", name] => parts.push(PartId::Texture(number(&names.textures, name)?)),
                ["material", name] => parts.push(PartId::Material(number(&names.materials, name)?)),
                ["medium", name] => parts.push(PartId::Medium(number(&names.media, name)?)),
                ["group", name] => parts.push(PartId::Group(number(&names.groups, name)?)),
                ["group", name, "object", key] => {
                    let group = number(&names.groups, name)? as usize;
                    let item = index(path, key, self.groups[group].value.objects.len())?;
                    of_groups.insert((group, item));
                }
                _ => return Err(no_part(path)),
            }
        }
        let mut left = self.clone();
        drop_items(&mut left.objects, &objects);
        drop_items(&mut left.lights, &lights);
        drop_items(&mut left.cameras, &views);
        for (group, item) in of_groups.into_iter().rev() {
            left.groups[group].value.objects.remove(item);
        }
        // Users come before what they use: a material before its textures.
        let rank = |part: &PartId| match part {
            PartId::Group(i) => (0, u32::MAX - i),
            PartId::Material(i) => (1, u32::MAX - i),
            PartId::Medium(i) => (2, u32::MAX - i),
            PartId::Texture(i) => (3, u32::MAX - i),
            PartId::Image(i) | PartId::Mesh(i) => (4, *i),
        };
        parts.sort_by_key(rank);
        parts.dedup();
        for part in &parts {
            if let Some(error) = left.in_use(*part, &parts) {
                return Err(error);
            }
        }
        // From the last of each kind to the first, so that the numbers of the others stay the same.
        parts.into_iter().for_each(|part| left.remove_part(part));
        left.drop_unused();
        for (section, removed) in [("object", &objects), ("light", &lights), ("view", &views)] {
            left.retarget_numbers(section, self, removed);
        }
        left.drop_animations_without_target();
        *self = left;
        Ok(())
    }

    /// The error that something other than the parts `gone` uses a part.
    fn in_use(&self, part: PartId, gone: &[PartId]) -> Option<SceneError> {
        let users = self.users(part, gone);
        let first = users.first()?;
        let names = self.names();
        let (kind, name) = match part {
            PartId::Texture(i) => ("texture", names.textures.get(i as usize)),
            PartId::Material(i) => ("material", names.materials.get(i as usize)),
            PartId::Medium(i) => ("medium", names.media.get(i as usize)),
            PartId::Group(i) => ("group", names.groups.get(i as usize)),
            PartId::Image(_) | PartId::Mesh(_) => return None,
        };
        let name = escape(name.map_or("", String::as_str));
        let others = match users.len() {
            1 => String::new(),
            2 => " and by 1 other".to_owned(),
            count => format!(" and by {} others", count - 1),
        };
        let message = format!("the {kind} \"{name}\" is used by {first}{others}");
        Some(
            SceneError::new(ErrorCode::Conflict, message)
                .help(format!("give them another {kind}, or remove them first")),
        )
    }

    /// What refers to a part, in words, except the parts `gone`.
    fn users(&self, part: PartId, gone: &[PartId]) -> Vec<String> {
        let mut users = Vec::new();
        let says = |what: &str, name: Option<&str>, path: String| match name {
            Some(name) => format!("the {what} \"{}\" ({path})", escape(name)),
            None => format!("the {what} {path}"),
        };
        let background = Renumber::recording();
        self.background.clone().renumber(&background);
        if background.recorded().contains(&part) {
            users.push("[background]".to_owned());
        }
        for (i, object) in self.objects.iter().enumerate() {
            if of_object(object).contains(&part) {
                users.push(says("object", object.name.as_deref(), format!("object.{i}")));
            }
        }
        for (i, light) in self.lights.iter().enumerate() {
            if of_light(light).contains(&part) {
                users.push(says("light", light.name.as_deref(), format!("light.{i}")));
            }
        }
        let names = self.names();
        let mut of_list = |kind: &str, names: &[String], id: fn(u32) -> PartId| {
            for (i, name) in (0..).zip(names) {
                if !gone.contains(&id(i)) && of_part(self, id(i)).contains(&part) {
                    users.push(format!("the {kind} \"{}\"", escape(name)));
                }
            }
        };
        of_list("group", &names.groups, PartId::Group);
        of_list("material", &names.materials, PartId::Material);
        of_list("medium", &names.media, PartId::Medium);
        of_list("texture", &names.textures, PartId::Texture);
        users
    }
}

fn drop_items<T>(list: &mut Vec<T>, gone: &BTreeSet<usize>) {
    let mut number = 0;
    list.retain(|_| {
        number += 1;
        !gone.contains(&(number - 1))
    });
}
