//! The scene at a time of its animations.

use super::read::Reader;
use crate::camera::CameraDesc;
use crate::description::{ObjectDesc, SceneAssets, SceneDesc};
use crate::math::{DAffine3, DMat3, DVec3};
use crate::schema::error::{escape, unknown_name};
use crate::schema::value::Span;
use crate::schema::{ErrorCode, KeyEdit, KeyPart, SceneError, Transform};

impl SceneDesc {
    /// Whether keyframes change anything over time.
    pub fn has_keyframes(&self) -> bool {
        self.animations.iter().any(|own| own.value.times.len() > 1)
    }

    /// Sets all animated keys to their values at `time`, in seconds. `frame` is the length of a frame in seconds, from
    /// shutter time 0 to 1: with it, `motion` of objects, lights and cameras becomes what the animations move them by in a
    /// frame, unless they have a `motion` of their own. Without it they stand still. `assets` reads the files that
    /// keyframes name.
    ///
    /// Errors: a target that does not exist; those of [`edit`](SceneDesc::edit). The description then stays the same.
    pub fn animate(
        &mut self,
        time: f64,
        frame: Option<f64>,
        assets: &mut dyn SceneAssets,
    ) -> Result<(), SceneError> {
        if self.animations.is_empty() {
            return Ok(());
        }
        let open = self.edits_at(time, assets)?;
        let later = match frame {
            Some(frame) => {
                let mut later = self.clone();
                let close = self.edits_at(time + frame, assets)?;
                later.edit(&close, assets)?;
                later.turn_models(&close);
                Some(later)
            }
            None => None,
        };
        self.edit(&open, assets)?;
        self.turn_models(&open);
        if let Some(later) = later {
            self.move_to(&later);
        }
        Ok(())
    }

    /// The edits that make the scene that of a time.
    fn edits_at(&self, time: f64, assets: &mut dyn SceneAssets) -> Result<Vec<KeyEdit>, SceneError> {
        let mut edits = Vec::new();
        for own in &self.animations {
            let span = own.span.unwrap_or(Span::NONE);
            let value = own.value.at(time, &mut Reader::new(assets))?;
            for path in self.animated(&own.value.target, span)? {
                edits.push(KeyEdit { path, value: value.clone() });
            }
        }
        Ok(edits)
    }

    /// The key paths of a target. A name stands for all objects, lights or views that have it.
    fn animated(&self, target: &str, span: Span) -> Result<Vec<Vec<KeyPart>>, SceneError> {
        let mut parts = KeyPart::split(target);
        parts.iter_mut().for_each(|part| part.span = span);
        let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
        let names_of = |objects: &[ObjectDesc]| objects.iter().map(|o| o.name.clone()).collect();
        // Position of the name in the path, and the names of the list.
        let (at, list): (usize, Vec<Option<String>>) = match keys.as_slice() {
            ["object", _, _, ..] => (1, names_of(&self.objects)),
            ["light", _, _, ..] => (1, self.lights.iter().map(|l| l.name.clone()).collect()),
            ["view", _, _, ..] => (1, self.cameras.iter().map(|c| c.name.clone()).collect()),
            ["group", group, "object", _, _, ..] => {
                let names = self.names().groups;
                let Some(i) = names.iter().position(|own| own == group) else {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    return Err(unknown_name(ErrorCode::UnknownName, span, "group", group, &names));
                };
                (3, names_of(&self.groups[i].value.objects))
            }
            ["camera" | "film" | "integrator" | "background" | "studio", _, ..]
            | ["texture" | "material" | "medium", _, _, ..] => return Ok(vec![parts]),
            _ => {
                let message = format!("\"{}\" is not the path of a key", escape(target));
                let help =
                    "write SECTION.KEY or SECTION.NAME.KEY: `camera.position`, `object.ball.transform`";
                return Err(SceneError::at(ErrorCode::UnknownKey, span, message).help(help));
            }
        };
        let name = keys[at];
        let found = list.iter().enumerate().filter(|(_, own)| own.as_deref() == Some(name));
        let paths: Vec<_> = found
            .map(|(i, _)| {
                let mut path = parts.clone();
                path[at].key = i.to_string();
                path
            })
            .collect();
        match paths.is_empty() {
            false => Ok(paths),
            true if name.parse::<usize>().is_ok_and(|i| i < list.len()) => Ok(vec![parts]),
            true => {
                let names: Vec<&str> = list.iter().flatten().map(String::as_str).collect();
                Err(unknown_name(ErrorCode::UnknownName, span, keys[at - 1], name, &names))
            }
        }
    }

    /// Sets the `motion` of all objects, lights and cameras that are elsewhere in `later`: the same scene at the end of a
    /// frame. What has a motion of its own keeps it.
    pub fn move_to(&mut self, later: &SceneDesc) {
        move_objects(&mut self.objects, &later.objects);
        for (group, later) in self.groups.iter_mut().zip(&later.groups) {
            move_objects(&mut group.value.objects, &later.value.objects);
        }
        for (light, later) in self.lights.iter_mut().zip(&later.lights) {
            if light.motion.is_none() && light.value != later.value {
                light.motion = light.value.motion_to(&later.value);
            }
        }
        let views = self.cameras.iter_mut().zip(&later.cameras);
        for (own, later) in self.camera.iter_mut().zip(&later.camera).chain(views) {
            let moved = motion_between(&own.value, &later.value);
            let motion = own.value.motion_mut();
            *motion = motion.or(moved);
        }
    }

    /// Turns animated models as the axes of their files ask for, which their transforms do not say.
    fn turn_models(&mut self, edits: &[KeyEdit]) {
        for edit in edits {
            let keys: Vec<&str> = edit.path.iter().map(|part| part.key.as_str()).collect();
            let ["object", i, key @ ("transform" | "motion")] = keys.as_slice() else { continue };
            let Ok(i) = i.parse::<usize>() else { continue };
            let Some(up) = self.model_of(i).map(|model| model.up.rotation()) else { continue };
            let Some(object) = self.objects.get_mut(i) else { continue };
            match *key {
                "transform" => object.transform.0 *= up,
                _ => object.motion.iter_mut().for_each(|motion| motion.0 *= up),
            }
        }
    }
}

fn move_objects(objects: &mut [ObjectDesc], later: &[ObjectDesc]) {
    for (own, later) in objects.iter_mut().zip(later) {
        if own.motion.is_none() && own.transform != later.transform {
            own.motion = Some(later.transform);
        }
    }
}

/// What moves a camera to where another one is; `None` if it does not move.
fn motion_between(from: &CameraDesc, to: &CameraDesc) -> Option<Transform> {
    let placed = |camera: &CameraDesc| {
        let [position, look_at, up] = camera.clone().placement_mut().map(|v| *v);
        placement(position, look_at - position, up)
    };
    let (from, to) = (placed(from)?, placed(to)?);
    (from != to).then(|| Transform(to * from.inverse()))
}

/// A placement at a position, with a direction and an up vector as axes.
fn placement(position: DVec3, direction: DVec3, up: DVec3) -> Option<DAffine3> {
    let forward = direction.try_normalize()?;
    let right = forward.cross(up).try_normalize()?;
    let matrix3 = DMat3::from_cols(right, right.cross(forward), -forward);
    Some(DAffine3 { matrix3, translation: position })
}
