//! Names of objects, for reports about what a ray hit.

use std::collections::BTreeMap;

use crate::material::ShadowKind;
use crate::math::Ray;
use crate::scene::{Hit, Scene};
use crate::schema::MaterialId;

/// Object names, stored per run of primitives that share them: a scene without names has no entries, and an instance
/// of a thousand parts has one per named part.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjectNames {
    names: Vec<String>,
    runs: Vec<Run>,
    /// For each entry of the scene's list of objects: its first primitive, and its name or [`NO_NAME`].
    entries: Vec<(u32, u32)>,
}

/// Primitives from `first` up to the next run.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    /// Names of the top-level object and of the object within it; [`NO_NAME`] without a name.
    outer: u32,
    inner: u32,
}

const NO_NAME: u32 = u32::MAX;

/// The names of a primitive's object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectName<'a> {
    /// The name of the object itself.
    pub own: Option<&'a str>,
    /// The name of the instance that placed it, if it is part of one.
    pub instance: Option<&'a str>,
}

impl ObjectName<'_> {
    /// Whether `name` is one of its names.
    pub fn is(&self, name: &str) -> bool {
        self.own == Some(name) || self.instance == Some(name)
    }
}

/// An object that casts a shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caster {
    /// Distance along the shadow ray, as t.
    pub t: f64,
    /// ID of the primitive.
    pub primitive: u32,
    /// Its shape, in a word.
    pub shape: &'static str,
    /// Its material.
    pub material: MaterialId,
}

/// Collects names in the order of the primitives.
#[derive(Clone, Default)]
pub(crate) struct NameCollector {
    known: BTreeMap<String, u32>,
    names: ObjectNames,
}

impl NameCollector {
    /// The index of an object's name.
    pub(crate) fn number(&mut self, name: Option<&str>) -> Option<u32> {
        name.map(|name| self.number_of(name))
    }

    fn number_of(&mut self, name: &str) -> u32 {
        if let Some(&number) = self.known.get(name) {
            return number;
        }
        let number = self.names.names.len() as u32;
        self.names.names.push(name.to_owned());
        self.known.insert(name.to_owned(), number);
        number
    }

    /// Names primitive `first` and the following ones.
    pub(crate) fn add(&mut self, first: u32, outer: Option<u32>, inner: Option<u32>) {
        let (outer, inner) = (outer.unwrap_or(NO_NAME), inner.unwrap_or(NO_NAME));
        let last = self.names.runs.last();
        if last.map_or((NO_NAME, NO_NAME), |r| (r.outer, r.inner)) != (outer, inner) {
            self.names.runs.push(Run { first, outer, inner });
        }
    }

    /// Primitive `first` and the following ones belong to the next entry of the scene's list of objects.
    pub(crate) fn begin_entry(&mut self, first: u32, name: Option<u32>) {
        self.names.entries.push((first, name.unwrap_or(NO_NAME)));
    }

    /// Names an object that is not in the scene description.
    pub(crate) fn add_own(&mut self, first: u32, name: &str) {
        let number = self.number_of(name);
        self.begin_entry(first, Some(number));
        self.add(first, None, Some(number));
    }

    /// Whether a primitive belongs to an object or an instance of a name, by its ID.
    pub(crate) fn is_named(&self, primitive: u32, name: &str) -> bool {
        let Some(number) = self.known.get(name) else { return false };
        let next = self.names.runs.partition_point(|run| run.first <= primitive);
        let run = next.checked_sub(1).and_then(|i| self.names.runs.get(i));
        let entry = self.names.entries.partition_point(|(first, _)| *first <= primitive);
        let entry = entry.checked_sub(1).and_then(|i| self.names.entries.get(i));
        run.is_some_and(|run| run.outer == *number || run.inner == *number)
            || entry.is_some_and(|(_, name)| name == number)
    }

    /// All names.
    pub(crate) fn all(&self) -> Vec<&str> {
        self.names.names.iter().map(String::as_str).collect()
    }

    pub(crate) fn finish(self) -> ObjectNames {
        self.names
    }
}

impl Scene {
    /// The names of a primitive's object, by the primitive's ID ([`Scene::primitive_id`]).
    pub fn object_name(&self, primitive: u32) -> ObjectName<'_> {
        let names = &self.object_names;
        let next = names.runs.partition_point(|run| run.first <= primitive);
        let Some(run) = next.checked_sub(1).and_then(|i| names.runs.get(i)) else {
            return ObjectName::default();
        };
        let name = |number: u32| names.names.get(number as usize).map(String::as_str);
        ObjectName { own: name(run.inner), instance: name(run.outer) }
    }

    /// The entry of the scene's list of objects that a primitive belongs to, by the primitive's ID. The floor of the
    /// default studio is an entry of its own.
    pub fn entry_of(&self, primitive: u32) -> u32 {
        let behind = self.object_names.entries.partition_point(|(first, _)| *first <= primitive);
        behind.saturating_sub(1) as u32
    }

    /// The number of entries of the scene's list of objects, with the floor of the default studio.
    pub fn entry_count(&self) -> usize {
        self.object_names.entries.len()
    }

    /// The name of an entry of the scene's list of objects.
    pub fn entry_name(&self, entry: u32) -> Option<&str> {
        let (_, name) = self.object_names.entries.get(entry as usize)?;
        self.object_names.names.get(*name as usize).map(String::as_str)
    }

    /// All object names of the scene in the order of the description, each once.
    pub fn object_names(&self) -> &[String] {
        &self.object_names.names
    }

    /// The shape that was hit, in a word.
    pub fn shape_word(&self, hit: &Hit) -> &'static str {
        self.primitives.get(hit.primitive as usize).map_or("", |p| p.shape.word())
    }

    /// The objects that cast a shadow along a ray, from its near end up to the first opaque one. Lists at most some
    /// hundreds of crossings. Meshes are intersected in double precision: at a silhouette, what blocks a shadow ray
    /// may be missing here.
    pub fn shadow_casters(&self, ray: &Ray) -> Vec<Caster> {
        const MOST: usize = 256;
        let mut ray = *ray;
        let mut casters = Vec::new();
        for _ in 0..MOST {
            let Some(hit) = self.intersect(&ray) else { break };
            let surface = self.surface(&ray, &hit);
            let kind = self.materials.get(surface.material.index()).map(|m| m.shadow());
            if kind != Some(ShadowKind::None) {
                casters.push(Caster {
                    t: hit.shape.t,
                    primitive: self.primitive_id(&hit),
                    shape: self.shape_word(&hit),
                    material: surface.material,
                });
            }
            if kind == Some(ShadowKind::Opaque) {
                break;
            }
            ray.t_min = self.beyond(&ray, &hit, &surface);
        }
        casters
    }
}
