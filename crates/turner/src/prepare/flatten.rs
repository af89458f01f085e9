//! From objects and groups to primitives in the world.

use super::shapes::PreparedShapes;
use crate::animation::motion::Motion;
use crate::description::*;
use crate::material::MaterialDesc;
use crate::math::{Bounds, DAffine3};
use crate::scene::alpha_test::{Faces, NO_FACES};
use crate::scene::camera_visibility::PrimitiveSet;
use crate::scene::light_groups::LightGroups;
use crate::scene::names::NameCollector;
use crate::scene::scene::{NO_TRANSFORM, ObjectTransform, Primitive};
use crate::schema::error::escape;
use crate::schema::{ErrorCode, MaterialId, Named, SceneError};
use crate::shape::{Shape, ShapeDesc, SolidGeometry};

/// Collects the primitives of a scene.
pub(crate) struct Flattener<'a> {
    pub(crate) shapes: &'a PreparedShapes,
    pub(crate) primitives: Vec<Primitive>,
    pub(crate) bounds: Vec<Option<Bounds>>,
    pub(crate) transforms: Vec<ObjectTransform>,
    pub(crate) faces: Vec<Faces>,
    pub(crate) materials: &'a [Named<MaterialDesc>],
    pub(crate) default_material: MaterialId,
    pub(crate) names: NameCollector,
    pub(crate) light_groups: LightGroups,
    pub(crate) shadow_catchers: PrimitiveSet,
    pub(crate) hidden_from_camera: PrimitiveSet,
    pub(crate) physical: bool,
    /// Opening and closing time of the shutter; equal without motion blur.
    pub(crate) shutter: [f64; 2],
}

impl Flattener<'_> {
    /// Places all objects of the scene, and those of groups once per instance.
    pub(crate) fn flatten(&mut self, desc: &SceneDesc) -> Result<(), SceneError> {
        struct Level<'a> {
            objects: &'a [ObjectDesc],
            shapes: &'a [Option<Shape>],
            next: usize,
            /// At the times 0 and 1.
            to_world: [DAffine3; 2],
            material: Option<MaterialId>,
            /// The name of the scene's object that contains these.
            name: Option<u32>,
            /// The light group of the objects in this group.
            group: Option<u32>,
            /// Whether the object that contains these is a shadow catcher.
            catches: bool,
            /// Whether it is hidden from the camera.
            is_passed: bool,
            /// Whether the objects are the scene's own.
            is_top: bool,
        }
        let shapes = self.shapes;
        let mut stack = vec![Level {
            objects: &desc.objects,
            shapes: &shapes.objects,
            next: 0,
            to_world: [DAffine3::IDENTITY; 2],
            material: None,
            name: None,
            group: None,
            catches: false,
            is_passed: false,
            is_top: true,
        }];
        while let Some(level) = stack.last_mut() {
            let Some(object) = level.objects.get(level.next) else {
                stack.pop();
                continue;
            };
            if object.hidden {
                // It keeps its place among the scene's objects, so that all others keep their numbers there.
                if level.is_top {
                    self.names.begin_entry(self.primitives.len() as u32, None);
                }
                level.next += 1;
                continue;
            }
            let [begin, end] = level.to_world;
            let motion = object.motion.unwrap_or(object.transform);
            let to_world = [begin * object.transform.0, end * motion.0];
            let material = object.material.or(level.material);
            let shape = &level.shapes[level.next];
            let (outer, own) = (level.name, self.names.number(object.name.as_deref()));
            let is_entry = level.is_top;
            let own_group = object.light_group.as_deref().map(|name| self.light_groups.number(name));
            let group = own_group.or(level.group);
            let catches = object.shadow_catcher || level.catches;
            let is_passed = object.hidden_from_camera || level.is_passed;
            level.next += 1;
            if is_entry {
                self.names.begin_entry(self.primitives.len() as u32, own);
            }
            match (&object.content, shape) {
                (ObjectContent::Shape(_), Some(shape)) => {
                    let first = self.primitives.len() as u32;
                    self.names.add(first, outer, own);
                    self.light_groups.add(first, group);
                    self.place(shape, to_world, material, object).map_err(|e| e.or_at(object.span))?;
                    let end = self.primitives.len() as u32;
                    (first..end).filter(|_| catches).for_each(|id| self.shadow_catchers.add(id));
                    (first..end).filter(|_| is_passed).for_each(|id| self.hidden_from_camera.add(id));
                }
                (ObjectContent::Instance(g), _) => stack.push(Level {
                    objects: &desc.groups[g.index()].value.objects,
                    shapes: &shapes.groups[g.index()],
                    next: 0,
                    to_world,
                    material,
                    name: outer.or(own),
                    group,
                    catches,
                    is_passed,
                    is_top: false,
                }),
                (ObjectContent::Shape(_), None) => {}
            }
        }
        Ok(())
    }

    fn place(
        &mut self,
        shape: &Shape,
        ends: [DAffine3; 2],
        material: Option<MaterialId>,
        object: &ObjectDesc,
    ) -> Result<(), SceneError> {
        for end in &ends {
            if *end != DAffine3::IDENTITY && !(end.is_finite() && end.inverse().is_finite()) {
                let message = "the product of the transforms of this object and its groups is not invertible";
                return Err(SceneError::new(ErrorCode::Transform, message));
            }
        }
        let motion = if ends[0] == ends[1] { None } else { Some(Motion::new(&ends[0], &ends[1])?) };
        let [open, close] = self.shutter;
        let to_world = motion.as_ref().map_or(ends[0], |m| m.at(open));
        let motion = motion.filter(|_| open < close);
        let bounds = match (&motion, shape.bounds()) {
            (None, bounds) if to_world == DAffine3::IDENTITY => bounds,
            (None, bounds) => bounds.map(|b| b.transformed(&to_world)),
            (Some(motion), bounds) => bounds.map(|b| motion.bounds(&b, open, close)),
        };
        let transform = if to_world == DAffine3::IDENTITY && motion.is_none() {
            NO_TRANSFORM
        } else {
            let in_world = if motion.is_none() { shape.in_world(&to_world).map(Box::new) } else { None };
            let motion = motion.map(Box::new);
            self.transforms.push(ObjectTransform { motion, in_world, ..ObjectTransform::new(to_world) });
            self.transforms.len() as u32 - 1
        };
        if shape.bounds().is_some_and(|b| b.is_empty()) {
            // A mesh without a triangle of positive area.
            return Ok(());
        }
        // The BVH works in single precision.
        const LARGEST: f64 = 1e30;
        if let Some(b) = bounds
            && !(b.min.abs().max_element() < LARGEST && b.max.abs().max_element() < LARGEST)
        {
            let name = object.name.as_deref().map_or(String::new(), |n| format!(" \"{}\"", escape(n)));
            let message =
                format!("the object{name} reaches beyond {LARGEST:e} units: its coordinates are too large");
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        let id = self.primitives.len() as u32;
        let material = material.unwrap_or(self.default_material);
        let faces = self.faces(object, shape, material);
        self.primitives.push(Primitive { shape: shape.clone(), material, transform, faces, id });
        self.bounds.push(bounds);
        Ok(())
    }

    /// Index of its faces. Consecutive objects often have the same.
    fn faces(&mut self, object: &ObjectDesc, shape: &Shape, material: MaterialId) -> u32 {
        let mut materials = vec![material];
        if let (ObjectContent::Shape(ShapeDesc::Mesh(desc)), Shape::Mesh(mesh)) = (&object.content, shape)
            && desc.materials.iter().any(Option::is_some)
        {
            let own = |i| desc.materials.get(i).copied().flatten().unwrap_or(material);
            materials = (0..mesh.data().material_count()).map(own).collect();
        }
        if let Shape::Solid(solid) = shape
            && !solid.materials().is_empty()
        {
            materials = solid.materials().iter().map(|own| own.unwrap_or(material)).collect();
        }
        let Some(faces) = Faces::new(materials, self.materials, self.physical) else { return NO_FACES };
        if self.faces.last() != Some(&faces) {
            self.faces.push(faces);
        }
        self.faces.len() as u32 - 1
    }
}
