//! Objects placed in the world, the input of the geometry.

use std::sync::Arc;

use super::default_studio::DefaultStudio;
use super::flatten::Flattener;
use super::shapes::PreparedShapes;
use super::surfaces::MaterialTraits;
use crate::description::framing::Subject;
use crate::description::{GroupDesc, ObjectDesc, SceneDesc};
use crate::math::Bounds;
use crate::scene::alpha_test::Faces;
use crate::scene::camera_visibility::PrimitiveSet;
use crate::scene::light_groups::LightGroups;
use crate::scene::names::NameCollector;
use crate::scene::outline::hull_points;
use crate::scene::scene::{ObjectTransform, Primitive};
use crate::schema::error::unknown_name;
use crate::schema::value::{FileId, Span};
use crate::schema::{ErrorCode, MaterialId, MeshData, PrepareOptions, SceneError, Warning};
use crate::shape::{CachedShapes, Plane, Shape, TriangleMesh};

/// Maximum size in bytes of a placed object during preparation: primitive, bounds, transform, part of the BVH.
const PLACED: u64 = 1024;

/// The primitives of a scene, in the order of the description.
#[derive(Clone)]
pub(super) struct Placed {
    pub(super) primitives: Vec<Primitive>,
    pub(super) bounds: Vec<Option<Bounds>>,
    pub(super) transforms: Vec<ObjectTransform>,
    pub(super) faces: Vec<Faces>,
    pub(super) names: NameCollector,
    pub(super) light_groups: LightGroups,
    pub(super) shadow_catchers: PrimitiveSet,
    pub(super) hidden_from_camera: PrimitiveSet,
    pub(super) meshes: Vec<Arc<TriangleMesh>>,
    pub(super) warnings: Vec<Warning>,
    /// The bounds of all bounded primitives.
    pub(super) total: Bounds,
}

impl Placed {
    /// What a camera is to show: all bounded objects, or those of a name.
    ///
    /// Errors: a name that no object has.
    pub(super) fn subject(&self, name: Option<&str>) -> Result<Subject, SceneError> {
        let is_chosen = |p: &Primitive| name.is_none_or(|name| self.names.is_named(p.id, name));
        let chosen = || self.primitives.iter().zip(&self.bounds).filter(|(p, _)| is_chosen(p));
        let bounds = chosen().filter_map(|(_, b)| b.as_ref()).fold(Bounds::EMPTY, |a, b| a.union(b));
        if let Some(name) = name.filter(|_| bounds.is_empty()) {
            let span = Span { file: FileId(u32::MAX), start: 0, end: 0 };
            let mut error = unknown_name(ErrorCode::UnknownName, span, "object", name, &self.names.all());
            error.span = None;
            return Err(error);
        }
        let primitives: Vec<&Primitive> = chosen().map(|(p, _)| p).collect();
        Ok(Subject::new(hull_points(&primitives, &self.transforms), &bounds))
    }

    /// Adds the floor of the default studio, with the material of this index.
    pub(super) fn add_ground(&mut self, studio: &DefaultStudio, material: usize) {
        let Some(plane) = ground_of(studio) else { return };
        let first = self.primitives.len() as u32;
        self.names.add_own(first, "floor");
        self.light_groups.add(first, None);
        let material = MaterialId(material as u32);
        self.primitives.push(Primitive::unbounded(Shape::Plane(plane), material, first));
        self.bounds.push(None);
    }
}

/// The objects of the last description, without the floor of the default studio.
#[derive(Default)]
pub(super) struct CachedObjects {
    made: Option<ObjectsByDesc>,
    shapes: CachedShapes,
    /// For a single preparation: nothing is compared later, so nothing is copied.
    once: bool,
}

struct ObjectsByDesc {
    objects: Vec<ObjectDesc>,
    groups: Vec<GroupDesc>,
    meshes: Vec<Arc<MeshData>>,
    traits: Vec<MaterialTraits>,
    physical: bool,
    shutter: [f64; 2],
    placed: Placed,
}

/// What changed among the objects.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ChangedObjects {
    pub(super) placed: bool,
    /// Number of new meshes, which have no BVH yet.
    pub(super) meshes: usize,
}

/// Whether two objects are equal, apart from their source positions.
fn same_object(a: &ObjectDesc, b: &ObjectDesc) -> bool {
    a.content == b.content
        && a.material == b.material
        && a.transform == b.transform
        && a.motion == b.motion
        && a.name == b.name
        && a.light_group == b.light_group
        && a.shadow_catcher == b.shadow_catcher
        && a.hidden_from_camera == b.hidden_from_camera
        && a.hidden == b.hidden
}

fn same_objects(a: &[ObjectDesc], b: &[ObjectDesc]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same_object(a, b))
}

impl ObjectsByDesc {
    fn is_of(&self, desc: &SceneDesc, traits: &[MaterialTraits], lights: &LightGroups) -> bool {
        let meshes = self.meshes.len() == desc.meshes.len()
            && self.meshes.iter().zip(&desc.meshes).all(|(a, b)| Arc::ptr_eq(a, &b.data));
        meshes
            && self.traits == traits
            && self.placed.light_groups.begins_with(lights)
            && same_objects(&self.objects, &desc.objects)
            && self.groups.len() == desc.groups.len()
            && self.groups.iter().zip(&desc.groups).all(|(a, b)| same_objects(&a.objects, &b.value.objects))
    }
}

impl CachedObjects {
    /// Places all objects of the scene in the world, unless the last ones can be reused. Returns what changed.
    ///
    /// Errors: groups that contain themselves, singular transforms, coordinates that are too large, not enough
    /// memory.
    pub(super) fn prepare(
        &mut self,
        desc: &SceneDesc,
        traits: &[MaterialTraits],
        light_sources: &[Option<u32>],
        physical: bool,
        options: &PrepareOptions,
    ) -> Result<ChangedObjects, SceneError> {
        let [open, close] = desc.film.shutter;
        let shutter = [open, if physical { close } else { open }];
        let group_of =
            |source: &Option<u32>| desc.lights.get(source.as_ref().copied()? as usize)?.group.as_deref();
        let groups = LightGroups::of_lights(light_sources.iter().map(group_of));
        let same = |m: &&ObjectsByDesc| {
            m.physical == physical && m.shutter == shutter && m.is_of(desc, traits, &groups)
        };
        if self.made.as_ref().is_some_and(|made| same(&made)) {
            if let Some(made) = &mut self.made {
                made.placed.light_groups = made.placed.light_groups.with_lights(groups);
            }
            return Ok(ChangedObjects::default());
        }
        let memory = &options.limits.memory;
        let count = desc.count_primitives()?;
        let triangles = desc.meshes.iter().map(|m| m.data.triangles.len() as u64).sum();
        options.limits.check_triangles(triangles, || "the scene".to_owned())?;
        memory.need(count.saturating_mul(PLACED), || format!("a scene of {count} objects and instances"))?;
        let mut kept = self.shapes.clone();
        let shapes = PreparedShapes::new(desc, options, &mut kept)?;
        let meshes = self.shapes.new_meshes(&kept);
        let mut flat = Flattener {
            shapes: &shapes,
            primitives: Vec::new(),
            bounds: Vec::new(),
            transforms: Vec::new(),
            faces: Vec::new(),
            materials: &desc.materials,
            default_material: MaterialId(desc.materials.len() as u32),
            names: NameCollector::default(),
            light_groups: groups,
            shadow_catchers: PrimitiveSet::default(),
            hidden_from_camera: PrimitiveSet::default(),
            physical,
            shutter,
        };
        if flat.primitives.try_reserve_exact(count as usize).is_err() {
            let message = format!("not enough memory for {count} objects");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        flat.flatten(desc)?;
        let Flattener {
            primitives,
            bounds,
            transforms,
            faces,
            names,
            light_groups,
            shadow_catchers,
            hidden_from_camera,
            ..
        } = flat;
        let PreparedShapes { meshes: used, warnings, .. } = shapes;
        let total = bounds.iter().flatten().fold(Bounds::EMPTY, |a, b| a.union(b));
        let placed = Placed {
            primitives,
            bounds,
            transforms,
            faces,
            names,
            light_groups,
            shadow_catchers,
            hidden_from_camera,
            meshes: used,
            warnings,
            total,
        };
        self.shapes = kept;
        self.made = Some(ObjectsByDesc {
            objects: if self.once { Vec::new() } else { desc.objects.clone() },
            groups: desc.groups.iter().filter(|_| !self.once).map(|g| g.value.clone()).collect(),
            meshes: desc.meshes.iter().map(|m| m.data.clone()).collect(),
            traits: traits.to_vec(),
            physical,
            shutter,
            placed,
        });
        Ok(ChangedObjects { placed: true, meshes })
    }

    /// For a single preparation.
    pub(super) fn once() -> CachedObjects {
        CachedObjects { once: true, ..CachedObjects::default() }
    }

    /// The placed objects, for use by the geometry.
    pub(super) fn take(&mut self) -> Option<Placed> {
        match self.once {
            true => self.made.take().map(|made| made.placed),
            false => self.placed().cloned(),
        }
    }

    /// The placed objects.
    pub(super) fn placed(&self) -> Option<&Placed> {
        self.made.as_ref().map(|made| &made.placed)
    }
}

/// The plane of the default studio's floor.
pub(super) fn ground_of(studio: &DefaultStudio) -> Option<Plane> {
    studio.ground.as_ref().map(|(plane, _)| *plane)
}
