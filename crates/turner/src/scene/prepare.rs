//! From a description to a scene that can be rendered.

use turner_bvh::{BoxBvh, BuildOptions, Quality};

use super::batch::BatchShapes;
use super::desc::*;
use super::doubts;
use super::emitters::Emitters;
use super::error::{ErrorCode, SceneError, escape};
use super::faces::{Faces, NO_FACES};
use super::scene::{NO_TRANSFORM, ObjectTransform, Primitive, Scene, SceneStats};
use super::sieve::{MAX_SHAPES, Sieve};
use super::stage::Staging;
use crate::camera::CameraDesc;
use crate::color::Spectrum;
use crate::film::Film;
use crate::light::Light;
use crate::material::{Material, MaterialDesc};
use crate::math::{Bounds, DAffine3};
use crate::shape::traversal::TraversalFrame;
use crate::shape::{MeshCache, Shape, ShapeDesc};
use crate::texture::Textures;

/// How to prepare.
#[derive(Clone, Copy, Debug, Default)]
pub struct PrepareOptions {
    /// Threads for building trees; 0 takes all there are. The scene is the same for any number.
    pub threads: usize,
    /// How much work goes into the trees of meshes. It changes how long pictures take, not what they show.
    pub quality: Quality,
}

/// The most shapes a scene may have, instances flattened.
const MAX_PRIMITIVES: u64 = 1 << 24;

/// Scenes of so many shapes or fewer have no tree. Together with a cheaper sphere test 1.5x faster at four spheres; the
/// limit itself is a guess, not measured.
const MAX_LINEAR: usize = 6;

impl SceneDesc {
    /// Checks what only the whole scene shows and builds what rendering needs.
    pub fn prepare(&self, options: &PrepareOptions) -> Result<Scene, SceneError> {
        let mut warnings = self.warnings.clone();
        let film_bytes = Film::check(&self.film)?;
        let textures = Textures::prepare(&self.textures, &self.images, self.film.transfer)?;
        let physical = self.integrator.is_physical();
        crate::material::mix::check(&self.materials)?;
        warnings.extend(doubts::of_description(self, physical));
        let ready = |m: &MaterialDesc| m.prepare(physical, &self.materials);
        let mut materials: Vec<Material> = self.materials.iter().map(|m| ready(&m.value)).collect();
        let default_material = MaterialId(materials.len() as u32);
        materials.push(ready(&MaterialDesc::default()));

        let count = self.count_primitives()?;
        let shapes = self.prepare_shapes(options, &mut warnings)?;
        let mut flat = Flattener {
            shapes: &shapes,
            primitives: Vec::new(),
            bounds: Vec::new(),
            transforms: Vec::new(),
            faces: Vec::new(),
            materials: &self.materials,
            default_material,
        };
        if flat.primitives.try_reserve_exact(count as usize).is_err() {
            let message = format!("there is no memory for {count} objects");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        flat.flatten(self)?;
        let aspect = f64::from(self.film.width) / f64::from(self.film.height);
        let (mut lights, ambient) = self.prepare_lights()?;
        let invalid: u64 = lights.iter().map(|l| l.invalid_pixels()).sum();
        if invalid > 0 {
            let message = format!(
                "{invalid} pixels of the environment are negative or no finite numbers: they count as 0"
            );
            warnings.push(Warning::new(WarningKind::Doubtful, message));
        }
        let staging = self.set_stage(&mut flat, &mut lights, aspect)?;
        if let Some((plane, material)) = staging.ground {
            materials.push(ready(&MaterialDesc::Principled(material)));
            flat.add_unbounded(Shape::Plane(plane), MaterialId(materials.len() as u32 - 1));
        }
        warnings.extend(staging.notes);
        let Flattener { primitives, bounds, transforms, faces, .. } = flat;
        let total = bounds.iter().flatten().fold(Bounds::EMPTY, |a, b| a.union(b));
        // Few shapes are tested one by one, without a tree.
        let in_tree = |b: &Option<Bounds>| b.is_some() && primitives.len() > MAX_LINEAR;
        let frame = TraversalFrame::new(&if primitives.len() > MAX_LINEAR { total } else { Bounds::EMPTY });

        let bounded_ids: Vec<u32> =
            (0..primitives.len() as u32).filter(|i| in_tree(&bounds[*i as usize])).collect();
        let boxes: Vec<_> = bounds.iter().filter(|b| in_tree(b)).flatten().map(|b| frame.aabb(b)).collect();
        let build = BuildOptions { threads: options.threads, ..BuildOptions::default() };
        let sieve = (1..=MAX_SHAPES).contains(&boxes.len()).then(|| {
            Sieve::new(
                &frame,
                bounded_ids.iter().map(|i| {
                    let primitive = &primitives[*i as usize];
                    let sphere = match &primitive.shape {
                        Shape::Sphere(s) if primitive.transform == NO_TRANSFORM => Some((s.center, s.radius)),
                        _ => None,
                    };
                    (bounds[*i as usize].unwrap_or(Bounds::EMPTY), sphere)
                }),
            )
        });
        let boxes = if sieve.is_some() { Vec::new() } else { boxes };
        let bvh =
            BoxBvh::build(&boxes, &build).map_err(|e| SceneError::new(ErrorCode::TooLarge, e.to_string()))?;
        let mut slots: Vec<Option<Primitive>> = primitives.into_iter().map(Some).collect();
        let mut ordered: Vec<Primitive> = Vec::with_capacity(slots.len());
        if sieve.is_some() {
            ordered.extend(bounded_ids.iter().filter_map(|i| slots[*i as usize].take()));
        }
        ordered.extend(bvh.order().iter().filter_map(|i| slots[bounded_ids[*i as usize] as usize].take()));
        let bounded = ordered.len();
        ordered.extend(slots.into_iter().flatten());

        let (camera_desc, span) = match staging.camera.as_ref().or(self.camera.as_ref()) {
            Some(camera) => (camera.value.clone(), camera.span),
            None => (CameraDesc::framing(&total, aspect), None),
        };
        let camera = camera_desc.prepare(aspect).map_err(|e| e.or_at(span))?;
        let batch = (sieve.is_some() || bounded == 0)
            .then(|| BatchShapes::new(&ordered, bounded, &materials, &faces));
        let stats = SceneStats {
            primitives: ordered.len() as u64,
            triangles: shapes.meshes.iter().map(|m| m.triangles).sum(),
            bounds: (!total.is_empty()).then_some(total),
            tree_bytes: (ordered.len() * size_of::<Primitive>()
                + transforms.len() * size_of::<ObjectTransform>()
                + bvh.bytes()
                + batch.as_ref().map_or(0, BatchShapes::bytes)) as u64,
            mesh_bytes: shapes.meshes.iter().map(|m| m.bytes).sum(),
            texture_bytes: self.images.iter().map(|i| i.data.memory() as u64).sum(),
            film_bytes,
        };
        let mut scene = Scene {
            camera,
            camera_desc,
            film: self.film.clone(),
            integrator: self.integrator.clone(),
            background: self.background.prepared(),
            textures,
            materials,
            lights,
            ambient,
            primitives: ordered,
            bounded,
            transforms,
            bvh,
            sieve,
            frame,
            batch,
            faces,
            emitters: Emitters::default(),
            warnings,
            stats,
        };
        if physical {
            scene.emitters = Emitters::new(&scene);
        }
        let doubts = doubts::of_scene(&scene, &self.lights);
        scene.warnings.extend(doubts);
        Ok(scene)
    }

    /// What the scene lacks and its stage has; lights are added at once.
    fn set_stage(
        &self,
        flat: &mut Flattener<'_>,
        lights: &mut Vec<Light>,
        aspect: f64,
    ) -> Result<Staging, SceneError> {
        let Some(stage) = &self.stage else { return Ok(Staging::default()) };
        let bounds = flat.bounds.iter().flatten().fold(Bounds::EMPTY, |a, b| a.union(b));
        stage.complete(self, &bounds, aspect, lights)
    }

    fn prepare_lights(&self) -> Result<(Vec<Light>, Spectrum), SceneError> {
        let (mut lights, mut ambient) = (Vec::new(), Spectrum::BLACK);
        for light in &self.lights {
            match light
                .value
                .prepare(&self.images, self.integrator.compensates())
                .map_err(|e| e.or_at(light.span))?
            {
                Ok(light) => lights.push(light),
                Err(color) => ambient += color,
            }
        }
        Ok((lights, ambient))
    }

    /// Shapes of the scene with instances flattened, counted without flattening them; refuses groups that
    /// contain themselves and scenes that multiply beyond [`MAX_PRIMITIVES`].
    fn count_primitives(&self) -> Result<u64, SceneError> {
        #[derive(Clone, Copy, PartialEq)]
        enum State {
            New,
            Open,
            Done(u64),
        }
        let mut states = vec![State::New; self.groups.len()];
        let placed = |objects: &[ObjectDesc], states: &[State]| {
            objects.iter().fold(0u64, |sum, o| {
                sum.saturating_add(match o.content {
                    ObjectContent::Shape(_) => 1,
                    ObjectContent::Instance(g) => match states[g.index()] {
                        // An empty group still takes time to place.
                        State::Done(n) => n.saturating_add(1),
                        _ => 0,
                    },
                })
            })
        };
        let children = |objects: &[ObjectDesc]| {
            objects
                .iter()
                .filter_map(|o| match o.content {
                    ObjectContent::Instance(g) => Some((g, o.span)),
                    ObjectContent::Shape(_) => None,
                })
                .collect::<Vec<_>>()
        };
        // Depth-first with a stack of our own: groups may nest a hundred thousand deep.
        for start in 0..self.groups.len() {
            let mut stack = vec![(GroupId(start as u32), None)];
            while let Some((g, span)) = stack.pop() {
                match states[g.index()] {
                    State::Done(_) => {}
                    State::Open => {
                        states[g.index()] =
                            State::Done(placed(&self.groups[g.index()].value.objects, &states));
                    }
                    State::New => {
                        states[g.index()] = State::Open;
                        stack.push((g, span));
                        for (child, child_span) in children(&self.groups[g.index()].value.objects) {
                            if states[child.index()] == State::Open {
                                let name = self.groups[child.index()].name.as_deref().unwrap_or("?");
                                let message = format!("the group \"{}\" contains itself", escape(name));
                                return Err(SceneError::new(ErrorCode::Cycle, message).or_at(child_span));
                            }
                            stack.push((child, child_span));
                        }
                    }
                }
            }
        }
        let total = placed(&self.objects, &states);
        if total > MAX_PRIMITIVES {
            let message = format!("the scene has {total} objects and instances, more than {MAX_PRIMITIVES}");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        Ok(total)
    }
}

/// Shapes made ready once, however often their groups are placed.
pub(super) struct PreparedShapes {
    /// For the scene's objects and for each group's, by index; `None` for instances.
    pub(super) objects: Vec<Option<Shape>>,
    pub(super) groups: Vec<Vec<Option<Shape>>>,
    pub(super) meshes: Vec<MeshStats>,
}

/// What one mesh takes.
pub(super) struct MeshStats {
    pub(super) triangles: u64,
    pub(super) bytes: u64,
}

struct Flattener<'a> {
    shapes: &'a PreparedShapes,
    primitives: Vec<Primitive>,
    bounds: Vec<Option<Bounds>>,
    transforms: Vec<ObjectTransform>,
    faces: Vec<Faces>,
    materials: &'a [Named<MaterialDesc>],
    default_material: MaterialId,
}

impl Flattener<'_> {
    /// A shape without end, in the world's space.
    fn add_unbounded(&mut self, shape: Shape, material: MaterialId) {
        let id = self.primitives.len() as u32;
        self.primitives.push(Primitive { shape, material, transform: NO_TRANSFORM, faces: NO_FACES, id });
        self.bounds.push(None);
    }

    fn flatten(&mut self, desc: &SceneDesc) -> Result<(), SceneError> {
        struct Level<'a> {
            objects: &'a [ObjectDesc],
            shapes: &'a [Option<Shape>],
            next: usize,
            to_world: DAffine3,
            material: Option<MaterialId>,
        }
        let shapes = self.shapes;
        let mut stack = vec![Level {
            objects: &desc.objects,
            shapes: &shapes.objects,
            next: 0,
            to_world: DAffine3::IDENTITY,
            material: None,
        }];
        while let Some(level) = stack.last_mut() {
            let Some(object) = level.objects.get(level.next) else {
                stack.pop();
                continue;
            };
            let to_world = level.to_world * object.transform.0;
            let material = object.material.or(level.material);
            let shape = &level.shapes[level.next];
            level.next += 1;
            match (&object.content, shape) {
                (ObjectContent::Shape(_), Some(shape)) => {
                    self.place(shape, to_world, material, object).map_err(|e| e.or_at(object.span))?;
                }
                (ObjectContent::Instance(g), _) => stack.push(Level {
                    objects: &desc.groups[g.index()].value.objects,
                    shapes: &shapes.groups[g.index()],
                    next: 0,
                    to_world,
                    material,
                }),
                (ObjectContent::Shape(_), None) => {}
            }
        }
        Ok(())
    }

    fn place(
        &mut self,
        shape: &Shape,
        to_world: DAffine3,
        material: Option<MaterialId>,
        object: &ObjectDesc,
    ) -> Result<(), SceneError> {
        let transform = if to_world == DAffine3::IDENTITY {
            NO_TRANSFORM
        } else {
            let transform = ObjectTransform::new(to_world);
            if !to_world.is_finite() || !transform.to_object.is_finite() {
                let message = "the transforms of this object and the groups around it multiply to one that cannot be undone";
                return Err(SceneError::new(ErrorCode::Transform, message));
            }
            self.transforms.push(transform);
            self.transforms.len() as u32 - 1
        };
        if shape.bounds().is_some_and(|b| b.is_empty()) {
            // A mesh without a triangle that has an area: nothing is there.
            return Ok(());
        }
        let bounds =
            shape.bounds().map(|b| if transform == NO_TRANSFORM { b } else { b.transformed(&to_world) });
        // The tree works in single precision.
        const LARGEST: f64 = 1e30;
        if let Some(b) = bounds
            && !(b.min.abs().max_element() < LARGEST && b.max.abs().max_element() < LARGEST)
        {
            let name = object.name.as_deref().map_or(String::new(), |n| format!(" \"{}\"", escape(n)));
            let message =
                format!("the object{name} reaches beyond {LARGEST:e} units: its numbers are too large");
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        let id = self.primitives.len() as u32;
        let material = material.unwrap_or(self.default_material);
        let faces = self.faces(object, shape, material);
        self.primitives.push(Primitive { shape: shape.clone(), material, transform, faces, id });
        self.bounds.push(bounds);
        Ok(())
    }

    /// Index of its faces. Objects that follow one another often have the same.
    fn faces(&mut self, object: &ObjectDesc, shape: &Shape, material: MaterialId) -> u32 {
        let mut materials = vec![material];
        if let (ObjectContent::Shape(ShapeDesc::Mesh(desc)), Shape::Mesh(mesh)) = (&object.content, shape)
            && desc.materials.iter().any(Option::is_some)
        {
            let own = |i| desc.materials.get(i).copied().flatten().unwrap_or(material);
            materials = (0..mesh.data().material_count()).map(own).collect();
        }
        let Some(faces) = Faces::new(materials, self.materials) else { return NO_FACES };
        if self.faces.last() != Some(&faces) {
            self.faces.push(faces);
        }
        self.faces.len() as u32 - 1
    }
}

impl SceneDesc {
    fn prepare_shapes(
        &self,
        options: &PrepareOptions,
        warnings: &mut Vec<Warning>,
    ) -> Result<PreparedShapes, SceneError> {
        let mut cache = MeshCache::with_options(&self.meshes, options);
        let mut prepare = |objects: &[ObjectDesc]| -> Result<Vec<Option<Shape>>, SceneError> {
            objects
                .iter()
                .map(|o| match &o.content {
                    ObjectContent::Shape(s) => s.prepare(&mut cache).map(Some).map_err(|e| e.or_at(o.span)),
                    ObjectContent::Instance(_) => Ok(None),
                })
                .collect()
        };
        let objects = prepare(&self.objects)?;
        let groups = self.groups.iter().map(|g| prepare(&g.value.objects)).collect::<Result<_, _>>()?;
        warnings.extend(cache.warnings.iter().map(|m| Warning::new(WarningKind::Doubtful, m.as_str())));
        let meshes = cache
            .prepared()
            .map(|m| MeshStats { triangles: m.triangle_count() as u64, bytes: m.memory() as u64 })
            .collect();
        Ok(PreparedShapes { objects, groups, meshes })
    }
}
