//! What things are called, for those who are told what a ray met.

use std::collections::BTreeMap;

use crate::material::ShadowKind;
use crate::math::Ray;
use crate::scene::{Hit, Scene};
use crate::schema::MaterialId;

/// Names of the primitives' objects: an entry for each run of primitives that share them, so that a scene without names has none and an
/// instance with a thousand parts has as many as it has named parts.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjectNames {
    names: Vec<String>,
    runs: Vec<Run>,
}

/// Primitives from `first` on, up to the next run.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    /// The name of the object of the scene, and of the one within it; [`NO_NAME`] where it has none.
    outer: u32,
    inner: u32,
}

const NO_NAME: u32 = u32::MAX;

/// What a primitive's object is called.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectName<'a> {
    /// The name of the object itself.
    pub own: Option<&'a str>,
    /// The name of the instance that placed it in the scene, where it is part of one.
    pub instance: Option<&'a str>,
}

impl ObjectName<'_> {
    /// Whether one of its names is this one.
    pub fn is(&self, name: &str) -> bool {
        self.own == Some(name) || self.instance == Some(name)
    }
}

/// Something that casts a shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caster {
    /// How far along the shadow ray.
    pub t: f64,
    /// The primitive's number in the description.
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
    /// The number of an object's name.
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

    /// The primitive `first` and those after it are called so.
    pub(crate) fn add(&mut self, first: u32, outer: Option<u32>, inner: Option<u32>) {
        let (outer, inner) = (outer.unwrap_or(NO_NAME), inner.unwrap_or(NO_NAME));
        let last = self.names.runs.last();
        if last.map_or((NO_NAME, NO_NAME), |r| (r.outer, r.inner)) != (outer, inner) {
            self.names.runs.push(Run { first, outer, inner });
        }
    }

    /// The same for something that the scene's description does not have.
    pub(crate) fn add_own(&mut self, first: u32, name: &str) {
        let number = self.number_of(name);
        self.add(first, None, Some(number));
    }

    pub(crate) fn finish(self) -> ObjectNames {
        self.names
    }
}

impl Scene {
    /// What the object of a primitive is called, by the primitive's number in the description ([`Scene::primitive_id`]).
    pub fn object_name(&self, primitive: u32) -> ObjectName<'_> {
        let names = &self.object_names;
        let behind = names.runs.partition_point(|run| run.first <= primitive);
        let Some(run) = behind.checked_sub(1).and_then(|i| names.runs.get(i)) else {
            return ObjectName::default();
        };
        let name = |number: u32| names.names.get(number as usize).map(String::as_str);
        ObjectName { own: name(run.inner), instance: name(run.outer) }
    }

    /// All names of objects that are in the scene, in the order of the description, each once.
    pub fn object_names(&self) -> &[String] {
        &self.object_names.names
    }

    /// The shape that was hit, in a word.
    pub fn shape_word(&self, hit: &Hit) -> &'static str {
        self.primitives.get(hit.primitive as usize).map_or("", |p| p.shape.word())
    }

    /// What casts a shadow along a ray, from its near end; nothing behind the first opaque thing. Beyond some hundreds of crossings no
    /// more are listed. Meshes are asked in double precision: at a silhouette it may happen that what blocks a shadow ray is not found.
    pub fn shadow_casters(&self, ray: &Ray) -> Vec<Caster> {
        const MOST: usize = 256;
        let mut ray = *ray;
        let mut caustic_targets = Vec::new();
        for _ in 0..MOST {
            let Some(hit) = self.intersect(&ray) else { break };
            let surface = self.surface(&ray, &hit);
            let kind = self.materials.get(surface.material.index()).map(|m| m.shadow());
            if kind != Some(ShadowKind::None) {
                caustic_targets.push(Caster {
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
        caustic_targets
    }
}
