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
        let before = self.objects.clone();
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
        self.retarget(|keys| {
            let ["object", key, rest @ ..] = keys else { return None };
            let has_name = |own: &ObjectDesc| own.name.as_deref() == Some(*key);
            let found = before.iter().position(has_name);
            let inner = match (found, key.parse::<usize>()) {
                // Where others of the name stay outside, the animation stays with them.
                (Some(i), _) => {
                    let all_inside = (0..before.len()).all(|k| chosen.contains(&k) || !has_name(&before[k]));
                    all_inside.then(|| (*key).to_owned()).filter(|_| chosen.contains(&i))
                }
                (None, Ok(i)) if chosen.contains(&i) => Some(chosen.range(..i).count().to_string()),
                (None, Ok(i)) => {
                    let left = i.saturating_sub(chosen.range(..i).count()).to_string();
                    let rest = rest.iter().map(|part| (*part).to_owned());
                    return Some(["object".to_owned(), left].into_iter().chain(rest).collect());
                }
                (None, Err(_)) => None,
            };
            let head = ["group".to_owned(), name.clone(), "object".to_owned(), inner?];
            Some(head.into_iter().chain(rest.iter().map(|part| (*part).to_owned())).collect())
        });
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
        let group_name = self.names().groups.get(group.index()).cloned().unwrap_or_default();
        let own_name = instance.name.clone().unwrap_or_else(|| key.to_string());
        let is_animated = self.animations.iter().any(|own| {
            let parts = KeyPart::split(&own.value.target);
            let is = |section: &str, name: &str| {
                parts.len() > 1 && parts[0].key == section && parts[1].key == name
            };
            is("group", &group_name) || is("object", &own_name) || is("object", key)
        });
        if is_animated {
            let message = format!("`{path}` is animated: its objects cannot be taken out");
            return Err(SceneError::new(ErrorCode::Conflict, message).help("remove its [[animation]] first"));
        }
        let before = self.clone();
        self.objects.remove(number);
        self.retarget_numbers("object", &before, &BTreeSet::from([number]));
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
        hidden_from_camera: object.hidden_from_camera || instance.hidden_from_camera,
        hidden: object.hidden || instance.hidden,
        transform: Transform(instance.transform.0 * object.transform.0),
        motion: moves.then(|| Transform(ends[1].0 * ends[0].0)),
        content: object.content.clone(),
    }
}
