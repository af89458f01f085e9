//! Adding parts to a description. New parts come last in their list, so that the key paths of all others stay the same;
//! only lights and cameras go before those of models, which a scene file has last.

use std::collections::BTreeSet;

use super::borrowed_assets::BorrowedAssets;
use super::write::Writer;
use crate::camera::CameraDesc;
use crate::color::named;
use crate::description::*;
use crate::material::MaterialDesc;
use crate::schema::value::Data;
use crate::schema::{ErrorCode, KeyEdit, KeyPart, Named, SceneError, TextureId, path_part};
use crate::texture::TextureDesc;

/// `wanted`, or if it is taken, the same with the first free number: `name 2`, `name 3`.
pub(super) fn unique(wanted: &str, is_taken: impl Fn(&str) -> bool) -> String {
    if !is_taken(wanted) {
        return wanted.to_owned();
    }
    let number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let base = wanted.rsplit_once(' ').filter(|(_, end)| number(end)).map_or(wanted, |(base, _)| base);
    let mut next = 2_u64;
    loop {
        let name = format!("{base} {next}");
        if !is_taken(&name) {
            return name;
        }
        next += 1;
    }
}

/// The error for a key path that names no part.
pub(super) fn no_part(path: &str) -> SceneError {
    SceneError::new(ErrorCode::UnknownName, format!("the scene has no `{path}`"))
        .help("name an item such as `object.0`, `light.0`, `view.0`, `material.NAME` or `texture.NAME`")
}

/// The index of a list item in a path.
pub(super) fn index(path: &str, key: &str, count: usize) -> Result<usize, SceneError> {
    key.parse::<usize>().ok().filter(|i| *i < count).ok_or_else(|| no_part(path))
}

impl SceneDesc {
    /// Adds an object and returns its key path.
    pub fn add_object(&mut self, object: ObjectDesc) -> String {
        self.objects.push(object);
        format!("object.{}", self.objects.len() - 1)
    }

    /// Adds a light, before the lights of models, and returns its key path.
    pub fn add_light(&mut self, light: SceneLight) -> String {
        let is_of_model = self.model_spans();
        let at = self.lights.iter().rposition(|own| !is_of_model(own.span)).map_or(0, |i| i + 1);
        self.lights.insert(at, light);
        format!("light.{at}")
    }

    /// Adds a camera to `[[view]]`, before the cameras of models, and returns its key path. If the name is taken, it
    /// gets a number.
    pub fn add_view(&mut self, name: &str, camera: CameraDesc) -> String {
        let is_of_model = self.model_spans();
        let at = self.cameras.iter().rposition(|own| !is_of_model(own.span)).map_or(0, |i| i + 1);
        let taken: BTreeSet<&str> = self.cameras.iter().filter_map(|c| c.name.as_deref()).collect();
        let name = unique(name, |name| taken.contains(name));
        self.cameras.insert(at, Named { name: Some(name), span: None, value: camera });
        format!("view.{at}")
    }

    /// Adds a material and returns its key path. If the name is taken, it gets a number.
    pub fn add_material(&mut self, name: &str, material: MaterialDesc) -> String {
        let taken: BTreeSet<String> = self.names().materials.into_iter().collect();
        let name = unique(name, |name| taken.contains(name));
        let path = format!("material.{}", path_part(&name));
        self.materials.push(Named { name: Some(name), span: None, value: material });
        path
    }

    /// Adds a texture and returns its key path. If the name is taken or that of a colour, it gets a number.
    pub fn add_texture(&mut self, name: &str, texture: TextureDesc) -> String {
        let taken: BTreeSet<String> = self.names().textures.into_iter().collect();
        let name = unique(name, |name| taken.contains(name) || named(name).is_some());
        let path = format!("texture.{}", path_part(&name));
        self.textures.push(Named { name: Some(name), span: None, value: texture });
        path
    }

    /// Adds a model file as one object and returns its key path. `file` of the model is relative to the scene.
    ///
    /// Errors: those of reading the model. The description then stays the same.
    pub fn add_model(
        &mut self,
        name: &str,
        model: &ModelDesc,
        assets: &mut dyn SceneAssets,
    ) -> Result<String, SceneError> {
        let mut table = {
            let mut lent = BorrowedAssets::of(self);
            model.write(&mut Writer::new(self, &mut lent))?
        };
        let taken: BTreeSet<&str> = self.objects.iter().filter_map(|o| o.name.as_deref()).collect();
        table.push("name", Data::String(unique(name, |name| taken.contains(name))));
        table.push("type", Data::String(ModelDesc::DOC.name.to_owned()));
        let path = self.add_object(ObjectDesc::default());
        let edited = self.edit(&[KeyEdit::new(&path, Data::Table(table))], assets);
        if edited.is_err() {
            self.objects.pop();
        }
        edited.map(|()| path)
    }

    /// Copies an object, light, view, material or texture and returns the key path of the copy. A name gets a number:
    /// `name 2`.
    ///
    /// Errors: a path that names no such part.
    pub fn duplicate(&mut self, path: &str) -> Result<String, SceneError> {
        let parts = KeyPart::split(path);
        let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
        let names = self.names();
        match keys.as_slice() {
            ["object", key] => {
                let object = self.objects[index(path, key, self.objects.len())?].clone();
                let name = copied(object.name.as_deref(), self.objects.iter().map(|o| o.name.as_deref()));
                let copy = self.with_own_parts(ObjectDesc { name, span: None, ..object });
                Ok(self.add_object(copy))
            }
            ["group", group, "object", key] => {
                let number = names.groups.iter().position(|own| own == group).ok_or_else(|| no_part(path))?;
                let objects = &self.groups[number].value.objects;
                let object = objects[index(path, key, objects.len())?].clone();
                let name = copied(object.name.as_deref(), objects.iter().map(|o| o.name.as_deref()));
                let copy = self.with_own_parts(ObjectDesc { name, span: None, ..object });
                let objects = &mut self.groups[number].value.objects;
                objects.push(copy);
                Ok(format!("group.{}.object.{}", path_part(group), objects.len() - 1))
            }
            ["light", key] => {
                let light = self.lights[index(path, key, self.lights.len())?].clone();
                let name = copied(light.name.as_deref(), self.lights.iter().map(|l| l.name.as_deref()));
                Ok(self.add_light(SceneLight { name, span: None, ..light }))
            }
            ["view", key] => {
                let view = self.cameras[index(path, key, self.cameras.len())?].clone();
                Ok(self.add_view(view.name.as_deref().unwrap_or("view"), view.value))
            }
            ["material", name] => {
                let number = names.materials.iter().position(|own| own == name);
                let value = self.materials[number.ok_or_else(|| no_part(path))?].value.clone();
                Ok(self.add_material(name, value))
            }
            ["texture", name] => {
                let number = names.textures.iter().position(|own| own == name);
                let id = TextureId(number.ok_or_else(|| no_part(path))? as u32);
                Ok(self.add_texture(name, self.textures[id.index()].value.clone()))
            }
            _ => Err(no_part(path)),
        }
    }
}

/// The name of a copy; none for a part without one.
fn copied<'a>(name: Option<&str>, all: impl Iterator<Item = Option<&'a str>>) -> Option<String> {
    let taken: BTreeSet<&str> = all.flatten().collect();
    name.map(|name| unique(name, |name| taken.contains(name)))
}
