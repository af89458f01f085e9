//! The scene at a time of its animations.

use std::collections::BTreeMap;

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
        let mut targets = Targets::new(self);
        for own in &self.animations {
            let span = own.span.unwrap_or(Span::NONE);
            let value = own.value.at(time, &mut Reader::new(assets))?;
            for path in targets.paths(&own.value.target, span)? {
                edits.push(KeyEdit { path, value: value.clone() });
            }
        }
        Ok(edits)
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

/// The indices of a list's items by their names, and the number of items.
#[derive(Default)]
struct Numbers<'a> {
    by_name: BTreeMap<&'a str, Vec<usize>>,
    count: usize,
}

impl<'a> Numbers<'a> {
    fn of(names: impl Iterator<Item = Option<&'a str>>) -> Numbers<'a> {
        let mut numbers = Numbers::default();
        for name in names {
            if let Some(name) = name {
                numbers.by_name.entry(name).or_default().push(numbers.count);
            }
            numbers.count += 1;
        }
        numbers
    }
}

/// Finds what animations target. Names are collected once for all of them.
pub(super) struct Targets<'a> {
    desc: &'a SceneDesc,
    groups: Vec<String>,
    /// By list: `object`, `light`, `view`, or the number of a group.
    lists: BTreeMap<(&'static str, usize), Numbers<'a>>,
}

impl<'a> Targets<'a> {
    pub(super) fn new(desc: &'a SceneDesc) -> Targets<'a> {
        Targets { desc, groups: desc.names().groups, lists: BTreeMap::new() }
    }

    /// The names of a list.
    fn list(&mut self, list: &'static str, group: usize) -> &Numbers<'a> {
        let desc = self.desc;
        self.lists.entry((list, group)).or_insert_with(|| match list {
            "object" => Numbers::of(desc.objects.iter().map(|own| own.name.as_deref())),
            "light" => Numbers::of(desc.lights.iter().map(|own| own.name.as_deref())),
            "view" => Numbers::of(desc.cameras.iter().map(|own| own.name.as_deref())),
            _ => Numbers::of(desc.groups[group].value.objects.iter().map(|own| own.name.as_deref())),
        })
    }

    /// The key paths of a target. A name stands for all objects, lights or views that have it.
    pub(super) fn paths(&mut self, target: &str, span: Span) -> Result<Vec<Vec<KeyPart>>, SceneError> {
        let mut parts = KeyPart::split(target);
        parts.iter_mut().for_each(|part| part.span = span);
        let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
        // The position of the name in the path.
        let (at, list) = match keys.as_slice() {
            ["object", _, _, ..] => (1, self.list("object", 0)),
            ["light", _, _, ..] => (1, self.list("light", 0)),
            ["view", _, _, ..] => (1, self.list("view", 0)),
            ["group", group, "object", _, _, ..] => match self.groups.iter().position(|own| own == group) {
                Some(group) => (3, self.list("group", group)),
                None => {
                    let names: Vec<&str> = self.groups.iter().map(String::as_str).collect();
                    return Err(unknown_name(ErrorCode::UnknownName, span, "group", group, &names));
                }
            },
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
        if let Some(found) = list.by_name.get(name) {
            let path = |i: &usize| {
                let mut path = parts.clone();
                path[at].key = i.to_string();
                path
            };
            return Ok(found.iter().map(path).collect());
        }
        if name.parse::<usize>().is_ok_and(|i| i < list.count) {
            return Ok(vec![parts]);
        }
        let names: Vec<&str> = list.by_name.keys().copied().collect();
        Err(unknown_name(ErrorCode::UnknownName, span, keys[at - 1], name, &names))
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
