//! Joining objects into a group, and taking a group apart.

use std::collections::BTreeSet;

use super::parts::{index, no_part, unique};
use crate::description::*;
use crate::schema::{ErrorCode, GroupId, KeyPart, Named, PartId, SceneError, Transform};

impl SceneDesc {
    /// Moves objects of the scene, by their key paths, into a new group that one instance places. Returns the key path
    /// of the instance, which is the last object. Nothing moves in the picture.
    ///
    /// Errors: a path that names no object of the scene; no path at all. The description then stays the same.
    pub fn group_objects(&mut self, paths: &[&str], name: &str) -> Result<String, SceneError> {
        let mut chosen = BTreeSet::new();
        for path in paths {
            let parts = KeyPart::split(path);
            let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
            let ["object", key] = keys.as_slice() else { return Err(no_part(path)) };
            chosen.insert(index(path, key, self.objects.len())?);
        }
        if chosen.is_empty() {
            return Err(SceneError::new(ErrorCode::MissingKey, "a group needs at least one object"));
        }
        let taken: BTreeSet<String> = self.names().groups.into_iter().collect();
        let name = unique(name, |name| taken.contains(name));
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for (i, object) in std::mem::take(&mut self.objects).into_iter().enumerate() {
            if chosen.contains(&i) {
                inside.push(ObjectDesc { span: None, ..object });
            } else {
                outside.push(object);
            }
        }
        self.objects = outside;
        let group = GroupId(self.groups.len() as u32);
        let value = GroupDesc { objects: inside, model: None };
        self.groups.push(Named { name: Some(name.clone()), span: None, value });
        let content = ObjectContent::Instance(group);
        Ok(self.add_object(ObjectDesc { name: Some(name), content, ..ObjectDesc::default() }))
    }

    /// Replaces an instance by the objects of its group and returns their key paths; they are the last objects. Nothing
    /// moves in the picture. The group is removed with its last instance.
    ///
    /// Errors: a path that names no instance of the scene. The description then stays the same.
    pub fn ungroup(&mut self, path: &str) -> Result<Vec<String>, SceneError> {
        let parts = KeyPart::split(path);
        let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
        let ["object", key] = keys.as_slice() else { return Err(no_part(path)) };
        let number = index(path, key, self.objects.len())?;
        let instance = self.objects[number].clone();
        let ObjectContent::Instance(group) = instance.content else {
            let message = format!("`{path}` is a shape: only an instance of a group can be taken apart");
            return Err(SceneError::new(ErrorCode::WrongType, message));
        };
        self.objects.remove(number);
        let first = self.objects.len();
        let inside = self.groups.get(group.index()).map_or(&[][..], |own| own.value.objects.as_slice());
        let placed: Vec<ObjectDesc> = inside.iter().map(|object| taken_out(object, &instance)).collect();
        self.objects.extend(placed);
        let places = |object: &ObjectDesc| object.content == ObjectContent::Instance(group);
        let in_groups = self.groups.iter().flat_map(|own| &own.value.objects);
        if !self.objects.iter().chain(in_groups).any(places) {
            self.remove_part(PartId::Group(group.0));
        }
        self.drop_unused();
        Ok((first..self.objects.len()).map(|i| format!("object.{i}")).collect())
    }
}

/// An object of a group as an object of the scene, where `instance` places it.
fn taken_out(object: &ObjectDesc, instance: &ObjectDesc) -> ObjectDesc {
    let ends = [object.motion.unwrap_or(object.transform), instance.motion.unwrap_or(instance.transform)];
    let moves = object.motion.is_some() || instance.motion.is_some();
    ObjectDesc {
        name: object.name.clone().or_else(|| instance.name.clone()),
        span: None,
        material: object.material.or(instance.material),
        light_group: object.light_group.clone().or_else(|| instance.light_group.clone()),
        shadow_catcher: object.shadow_catcher || instance.shadow_catcher,
        hidden: object.hidden || instance.hidden,
        transform: Transform(instance.transform.0 * object.transform.0),
        motion: moves.then(|| Transform(ends[1].0 * ends[0].0)),
        content: object.content.clone(),
    }
}
