//! New names for parts of a description.

use super::parts::{index, no_part};
use crate::color::named;
use crate::description::*;
use crate::schema::error::escape;
use crate::schema::{ErrorCode, KeyPart, Named, SceneError, path_part};

/// The most characters of a name.
const LONGEST: usize = 200;

impl SceneDesc {
    /// Gives an object, light, view, material, texture, medium or group another name and returns its key path. What refers to
    /// the part refers to it by its new name. An empty name takes the name away from an object, a light or a view.
    ///
    /// Errors: a path that names no such part; a name that another material, texture, medium, group or view has; one that a
    /// scene file cannot have. The description then stays the same.
    pub fn rename(&mut self, path: &str, name: &str) -> Result<String, SceneError> {
        let name = name.trim();
        if name.chars().any(char::is_control) || name.chars().count() > LONGEST {
            let message = format!("a name has at most {LONGEST} characters, all on one line");
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        let parts = KeyPart::split(path);
        let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
        let names = self.names();
        let own = (!name.is_empty()).then(|| name.to_owned());
        match keys.as_slice() {
            ["object", key] => {
                let i = index(path, key, self.objects.len())?;
                let old = std::mem::replace(&mut self.objects[i].name, own.clone());
                // Another object with the old name keeps the animations.
                if let Some(old) = old.filter(|old| !self.has_object(old)) {
                    self.retarget_name("object", &old, own.as_deref().unwrap_or(key));
                }
                return Ok(path.to_owned());
            }
            ["light", key] => {
                let i = index(path, key, self.lights.len())?;
                let old = std::mem::replace(&mut self.lights[i].name, own.clone());
                if let Some(old) = old.filter(|old| !self.lights.iter().any(|l| l.name.as_ref() == Some(old)))
                {
                    self.retarget_name("light", &old, own.as_deref().unwrap_or(key));
                }
                return Ok(path.to_owned());
            }
            ["view", key] => {
                let i = index(path, key, self.cameras.len())?;
                let others = self.cameras.iter().enumerate().filter(|(other, _)| *other != i);
                if own.is_some() && others.into_iter().any(|(_, other)| other.name == own) {
                    return Err(taken("view", name));
                }
                if let Some(old) = std::mem::replace(&mut self.cameras[i].name, own.clone()) {
                    self.retarget_name("view", &old, own.as_deref().unwrap_or(key));
                }
                return Ok(path.to_owned());
            }
            ["texture", old] => {
                if named(name).is_some() {
                    let message = format!("\"{}\" is the name of a colour, not of a texture", escape(name));
                    return Err(SceneError::new(ErrorCode::Conflict, message).help("choose another name"));
                }
                renamed(&mut self.textures, "texture", &names.textures, (path, old), name)?;
            }
            ["material", old] => {
                renamed(&mut self.materials, "material", &names.materials, (path, old), name)?
            }
            ["medium", old] => renamed(&mut self.media, "medium", &names.media, (path, old), name)?,
            ["group", old] => renamed(&mut self.groups, "group", &names.groups, (path, old), name)?,
            _ => return Err(no_part(path)),
        }
        self.retarget_name(keys[0], keys[1], name);
        Ok(format!("{}.{}", keys[0], path_part(name)))
    }
}

fn taken(kind: &str, name: &str) -> SceneError {
    let message = format!("there is another {kind} with the name \"{}\"", escape(name));
    SceneError::new(ErrorCode::Conflict, message).help("choose another name")
}

/// Names a part of a list whose parts are referred to by their names.
fn renamed<T>(
    list: &mut [Named<T>],
    kind: &str,
    names: &[String],
    (path, old): (&str, &str),
    name: &str,
) -> Result<(), SceneError> {
    let i = names.iter().position(|own| own == old).ok_or_else(|| no_part(path))?;
    if name.is_empty() {
        let message = format!("a {kind} needs a name, because others refer to it");
        return Err(SceneError::new(ErrorCode::OutOfRange, message).help("write a name"));
    }
    if names.iter().enumerate().any(|(other, own)| other != i && own == name) {
        return Err(taken(kind, name));
    }
    match list.get_mut(i) {
        Some(part) => part.name = Some(name.to_owned()),
        None => return Err(no_part(path)),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{MaterialDesc, MatteMaterial};
    use crate::testing::scenes::{sphere, v};

    #[test]
    fn references_follow_and_names_stay_unique() {
        let mut desc = SceneDesc::default();
        for name in ["gold", "chalk"] {
            desc.add_material(name, MaterialDesc::Matte(MatteMaterial::default()));
        }
        let mut ball = ObjectDesc::new(sphere(v(0.0, 0.0, 0.0), 1.0));
        ball.material = Some(crate::schema::MaterialId(0));
        desc.add_object(ball);
        let before = desc.clone();
        for (path, name) in [
            ("material.gold", "chalk"),
            ("material.gold", ""),
            ("material.none", "x"),
            ("material.gold", "two\nlines"),
            ("camera", "x"),
            ("object.7", "x"),
        ] {
            assert!(desc.rename(path, name).is_err(), "{path} {name}");
            assert_eq!(desc, before);
        }
        assert_eq!(desc.rename("material.gold", " old gold ").unwrap(), "material.old gold");
        assert_eq!(desc.names().materials, ["old gold", "chalk"]);
        let of_ball = desc.value_at("object.0.material").unwrap().unwrap();
        assert_eq!(of_ball.data, crate::schema::value::Data::String("old gold".into()));
        // Its own name is no conflict.
        assert!(desc.rename("material.old gold", "old gold").is_ok());
        assert_eq!(desc.rename("object.0", "ball").unwrap(), "object.0");
        assert_eq!(desc.objects[0].name.as_deref(), Some("ball"));
        desc.rename("object.0", "").unwrap();
        assert_eq!(desc.objects[0].name, None);
    }
}
