//! Inserting one description into another.

use std::collections::BTreeSet;

use super::parts::{index, no_part, unique};
use super::references::{Reached, of_light, of_object, of_part};
use crate::color::named;
use crate::description::*;
use crate::film::FilmDesc;
use crate::schema::value::Data;
use crate::schema::{IdMaps, KeyPart, Named, PartId, SceneError, path_part};

impl SceneDesc {
    /// Adds the objects, lights, views, textures, materials, media and groups of another scene. Names that are taken get
    /// a number, and references follow. A texture, material, medium or group that this scene has already, with the same
    /// name and values, is used instead of a copy. Camera, film and other settings of the other scene are ignored.
    /// Returns the key paths of what was added.
    ///
    /// Errors: an ID that one of the descriptions does not have. The description then stays the same.
    pub fn merge(&mut self, other: SceneDesc) -> Result<Vec<String>, SceneError> {
        let maps = self.places_of(&other)?;
        let own = [self.textures.len(), self.materials.len(), self.media.len(), self.groups.len()];
        let mut other = other;
        other.renumber_as(&maps);
        let mut paths = Vec::new();
        macro_rules! add {
            ($list:ident, $kind:literal, $map:expr, $own:expr, $allowed:expr) => {
                let mut taken: BTreeSet<String> = self.names().$list.into_iter().collect();
                for (item, new) in other.$list.into_iter().zip($map) {
                    if (*new as usize) < $own {
                        continue;
                    }
                    let name = item.name.map(|name| unique(&name, |n| taken.contains(n) || !$allowed(n)));
                    if let Some(name) = &name {
                        taken.insert(name.clone());
                        paths.push(format!("{}.{}", $kind, path_part(name)));
                    }
                    self.$list.push(Named { name, span: None, value: item.value });
                }
            };
        }
        add!(textures, "texture", &maps.textures, own[0], |name: &str| named(name).is_none());
        add!(materials, "material", &maps.materials, own[1], |_: &str| true);
        add!(media, "medium", &maps.media, own[2], |_: &str| true);
        add!(groups, "group", &maps.groups, own[3], |_: &str| true);
        let first = own[3].min(self.groups.len());
        let new_groups = self.groups[first..].iter_mut();
        new_groups.flat_map(|group| &mut group.value.objects).for_each(|object| object.span = None);
        self.images.append(&mut other.images);
        self.meshes.append(&mut other.meshes);
        for object in other.objects {
            let taken = |name: &str| self.objects.iter().any(|o| o.name.as_deref() == Some(name));
            let name = object.name.as_deref().map(|name| unique(name, taken));
            paths.push(self.add_object(ObjectDesc { name, span: None, ..object }));
        }
        for light in other.lights {
            let taken = |name: &str| self.lights.iter().any(|l| l.name.as_deref() == Some(name));
            let name = light.name.as_deref().map(|name| unique(name, taken));
            paths.push(self.add_light(SceneLight { name, span: None, ..light }));
        }
        for view in other.cameras {
            paths.push(self.add_view(view.name.as_deref().unwrap_or("view"), view.value));
        }
        self.imports.append(&mut other.imports);
        self.warnings.append(&mut other.warnings);
        Ok(paths)
    }

    /// For each part of another scene its number in this one: that of an equal part, or a new one.
    fn places_of(&self, other: &SceneDesc) -> Result<IdMaps, SceneError> {
        let mut maps = IdMaps {
            images: (self.images.len() as u32..).take(other.images.len()).collect(),
            meshes: (self.meshes.len() as u32..).take(other.meshes.len()).collect(),
            textures: vec![u32::MAX; other.textures.len()],
            materials: vec![u32::MAX; other.materials.len()],
            media: vec![u32::MAX; other.media.len()],
            groups: vec![u32::MAX; other.groups.len()],
        };
        let [ours, theirs] = [self.names(), other.names()];
        let mut next = [self.textures.len(), self.materials.len(), self.media.len(), self.groups.len()];
        macro_rules! place {
            ($list:ident, $kind:literal, $id:path, $slot:literal) => {
                for (i, item) in other.$list.iter().enumerate() {
                    let own =
                        item.name.as_ref().and_then(|name| ours.$list.iter().position(|own| own == name));
                    let path = format!("{}.{}", $kind, path_part(&theirs.$list[i]));
                    let part = $id(i as u32);
                    let reused = match own {
                        Some(own) if other.is_as_in(self, &path)? => {
                            let refers_to_new =
                                of_part(other, part).into_iter().any(|id| !is_reused(&maps, self, id));
                            Some(own as u32).filter(|_| !refers_to_new)
                        }
                        _ => None,
                    };
                    maps.$list[i] = reused.unwrap_or_else(|| {
                        next[$slot] += 1;
                        next[$slot] as u32 - 1
                    });
                }
            };
        }
        place!(textures, "texture", PartId::Texture, 0);
        place!(media, "medium", PartId::Medium, 2);
        place!(materials, "material", PartId::Material, 1);
        place!(groups, "group", PartId::Group, 3);
        Ok(maps)
    }

    /// Whether both scenes write the same value at a path.
    fn is_as_in(&self, other: &SceneDesc, path: &str) -> Result<bool, SceneError> {
        let (a, b) = (self.value_at(path)?, other.value_at(path)?);
        Ok(a.zip(b).is_some_and(|(a, b)| same_data(&a.data, &b.data)))
    }
}

/// Whether a part of the other scene became one that this scene has already.
fn is_reused(maps: &IdMaps, own: &SceneDesc, id: PartId) -> bool {
    let is_own =
        |map: &[u32], i: u32, count: usize| map.get(i as usize).is_some_and(|new| (*new as usize) < count);
    match id {
        PartId::Texture(i) => is_own(&maps.textures, i, own.textures.len()),
        PartId::Material(i) => is_own(&maps.materials, i, own.materials.len()),
        PartId::Medium(i) => is_own(&maps.media, i, own.media.len()),
        PartId::Group(i) => is_own(&maps.groups, i, own.groups.len()),
        // Pictures are equal if their files are; meshes written in place are compared as values.
        PartId::Image(_) | PartId::Mesh(_) => true,
    }
}

/// Whether two values are equal, apart from their positions.
fn same_data(a: &Data, b: &Data) -> bool {
    match (a, b) {
        (Data::Array(a), Data::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same_data(&a.data, &b.data))
        }
        (Data::Table(a), Data::Table(b)) => {
            let mut pairs = a.entries.iter().zip(&b.entries);
            a.entries.len() == b.entries.len()
                && pairs.all(|(a, b)| a.key == b.key && same_data(&a.value.data, &b.value.data))
        }
        _ => a == b,
    }
}

impl SceneDesc {
    /// The scene with only some of its objects, lights, views and named parts, by their key paths, and everything that
    /// these refer to; without camera, film and other settings.
    ///
    /// Errors: a path that names no such part.
    pub fn extract(&self, paths: &[&str]) -> Result<SceneDesc, SceneError> {
        let names = self.names();
        let mut out = SceneDesc {
            film: FilmDesc { transfer: self.film.transfer, ..Default::default() },
            ..SceneDesc::default()
        };
        let mut wanted = Vec::new();
        for path in paths {
            let keys = KeyPart::split(path);
            let keys: Vec<&str> = keys.iter().map(|part| part.key.as_str()).collect();
            let number = |names: &[String], name: &str| {
                names.iter().position(|own| own == name).map(|i| i as u32).ok_or_else(|| no_part(path))
            };
            match keys.as_slice() {
                ["object", key] => {
                    out.objects.push(self.objects[index(path, key, self.objects.len())?].clone())
                }
                ["light", key] => out.lights.push(self.lights[index(path, key, self.lights.len())?].clone()),
                ["view", key] => {
                    out.cameras.push(self.cameras[index(path, key, self.cameras.len())?].clone())
                }
                ["texture", name] => wanted.push(PartId::Texture(number(&names.textures, name)?)),
                ["material", name] => wanted.push(PartId::Material(number(&names.materials, name)?)),
                ["medium", name] => wanted.push(PartId::Medium(number(&names.media, name)?)),
                ["group", name] => wanted.push(PartId::Group(number(&names.groups, name)?)),
                ["group", name, "object", key] => {
                    let group = &self.groups[number(&names.groups, name)? as usize].value.objects;
                    out.objects.push(group[index(path, key, group.len())?].clone());
                }
                _ => return Err(no_part(path)),
            }
        }
        out.objects.iter().for_each(|object| wanted.extend(of_object(object)));
        out.lights.iter().for_each(|light| wanted.extend(of_light(light)));
        let mut reached = Reached::none(self);
        reached.follow(self, wanted);
        out.textures.clone_from(&self.textures);
        out.materials.clone_from(&self.materials);
        out.media.clone_from(&self.media);
        out.groups.clone_from(&self.groups);
        out.images.clone_from(&self.images);
        out.meshes.clone_from(&self.meshes);
        out.keep_only(&reached);
        Ok(out)
    }
}
