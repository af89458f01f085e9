//! From a description to a scene that can be rendered.

use std::sync::Arc;

use turner_bvh::{BoxBvh, BuildOptions, Quality};

use super::batch::BatchShapes;
use super::desc::*;
use super::doubts;
use super::emitters::Emitters;
use super::error::{ErrorCode, SceneError, escape};
use super::flatten::Flattener;
use super::light_groups::LightGroups;
use super::limits::Limits;
use super::merged::{self, Merged};
use super::names::NameCollector;
use super::placed_emitters::LightChoice;
use super::scene::{NO_TRANSFORM, ObjectTransform, Primitive, Scene, SceneStats};
use super::sieve::{MAX_SHAPES, Sieve};
use super::stage::Staging;
use super::volumes::Volumes;
use crate::camera::{CameraDesc, PixelCone};
use crate::color::Spectrum;
use crate::film::{Film, TextureFilter};
use crate::integrator::path::{Plan, decide};
use crate::light::Light;
use crate::material::{Material, MaterialDesc};
use crate::math::Bounds;
use crate::shape::traversal::TraversalFrame;
use crate::shape::{MeshCache, Shape, TriangleMesh};
use crate::texture::Textures;

/// How to prepare.
#[derive(Clone, Debug, Default)]
pub struct PrepareOptions {
    /// Threads for building trees; 0 takes all there are. The scene is the same for any number.
    pub threads: usize,
    /// How much work goes into the trees of meshes. It changes how long pictures take, not what they show.
    pub quality: Quality,
    /// What it may take.
    pub limits: Limits,
}

/// The most shapes a scene may have, instances flattened.
const MAX_PRIMITIVES: u64 = 1 << 24;

/// Bytes that a placed object takes at most while the scene is prepared: itself, its box, its transform, its place in the tree.
const PLACED: u64 = 640;

/// Scenes of so many shapes or fewer have no tree. Together with a cheaper sphere test 1.5x faster at four spheres; the
/// limit itself is a guess, not measured.
const MAX_LINEAR: usize = 6;

impl SceneDesc {
    /// Checks what only the whole scene shows and builds what rendering needs.
    pub fn prepare(&self, options: &PrepareOptions) -> Result<Scene, SceneError> {
        let mut warnings = self.warnings.clone();
        let memory = &options.limits.memory;
        memory.begin("preparing the scene");
        let film_bytes = Film::check(&self.film)?;
        memory.promise(Film::peak(&self.film)?, || {
            format!("a picture of {}x{} pixels", self.film.width, self.film.height)
        })?;
        let [open, close] = self.film.shutter;
        if open > close {
            let message = format!("the shutter opens at {open} and closes before, at {close}");
            return Err(SceneError::new(ErrorCode::Conflict, message).help("write shutter = [OPEN, CLOSE]"));
        }
        if self.film.ignores_filter() {
            let message = "`filter` and `filter_radius` have no effect without antialias = \"monte-carlo\"";
            warnings.push(Warning::new(WarningKind::Ignored, message));
        }
        let filtered = match self.film.texture_filter {
            TextureFilter::Auto => self.integrator.is_physical(),
            TextureFilter::On => true,
            TextureFilter::Off => false,
        };
        let filtered = filtered && !self.textures.is_empty();
        self.need_for_pictures(filtered, memory)?;
        let textures = Textures::prepare(&self.textures, &self.images, self.film.transfer, filtered)?;
        let physical = self.integrator.is_physical();
        crate::material::mix::check(&self.materials)?;
        warnings.extend(doubts::of_description(self, physical));
        let ready = |m: &MaterialDesc| m.prepare(physical, &self.materials);
        let mut materials: Vec<Material> = self.materials.iter().map(|m| ready(&m.value)).collect();
        let volumes = if physical { Volumes::prepare(self)? } else { None };
        let default_material = MaterialId(materials.len() as u32);
        materials.push(ready(&MaterialDesc::default()));

        let count = self.count_primitives()?;
        let triangles = self.meshes.iter().map(|m| m.data.triangles.len() as u64).sum();
        options.limits.check_triangles(triangles, || "the scene".to_owned())?;
        memory.need(count.saturating_mul(PLACED), || format!("a scene of {count} objects and instances"))?;
        let shapes = self.prepare_shapes(options, &mut warnings)?;
        let mut flat = Flattener {
            shapes: &shapes,
            primitives: Vec::new(),
            bounds: Vec::new(),
            transforms: Vec::new(),
            faces: Vec::new(),
            materials: &self.materials,
            default_material,
            names: NameCollector::default(),
            light_groups: LightGroups::default(),
            physical,
            shutter: [open, if physical { close } else { open }],
        };
        if flat.primitives.try_reserve_exact(count as usize).is_err() {
            let message = format!("there is no memory for {count} objects");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        let aspect = f64::from(self.film.width) / f64::from(self.film.height);
        let PreparedLights { mut lights, sources: mut light_sources, ambient } = self.prepare_lights()?;
        flat.light_groups = LightGroups::of_lights(self, &light_sources);
        flat.flatten(self)?;
        let invalid: u64 = lights.iter().map(|l| l.invalid_pixels()).sum();
        if invalid > 0 {
            let message = format!(
                "{invalid} pixels of the environment are negative or no finite numbers: they count as 0"
            );
            warnings.push(Warning::new(WarningKind::Doubtful, message));
        }
        let staging = self.set_stage(&mut flat, &mut lights, aspect)?;
        light_sources.resize(lights.len(), None);
        if let Some((plane, material)) = staging.ground {
            materials.push(ready(&MaterialDesc::Principled(material)));
            flat.names.add_own(flat.primitives.len() as u32, "floor");
            flat.light_groups.add(flat.primitives.len() as u32, None);
            flat.add_unbounded(Shape::Plane(plane), MaterialId(materials.len() as u32 - 1));
        }
        warnings.extend(staging.notes);
        let Flattener { primitives, bounds, transforms, faces, names, light_groups, .. } = flat;
        let total = bounds.iter().flatten().fold(Bounds::EMPTY, |a, b| a.union(b));
        let moving: Vec<bool> = primitives
            .iter()
            .map(|p| transforms.get(p.transform as usize).is_some_and(|t| t.motion.is_some()))
            .collect();
        let still: Vec<Option<Bounds>> =
            bounds.iter().zip(&moving).map(|(b, moves)| b.filter(|_| !moves)).collect();
        let (gathered, offset) = merged::choose(&primitives, &still);
        for (primitive, gathered) in primitives.iter().zip(&gathered) {
            if let (Shape::Mesh(mesh), false) = (&primitive.shape, gathered) {
                mesh.build_tree(options)?;
            }
        }
        // Few shapes are tested one by one, without a tree.
        let single = gathered.iter().filter(|gathered| !**gathered).count();
        let has_tree = single > MAX_LINEAR;
        let frame = TraversalFrame::new(&if has_tree { total } else { Bounds::EMPTY });

        let bounded_ids: Vec<u32> = (0..primitives.len() as u32)
            .filter(|i| has_tree && bounds[*i as usize].is_some() && !gathered[*i as usize])
            .collect();
        let boxes: Vec<_> =
            bounded_ids.iter().filter_map(|i| bounds[*i as usize].map(|b| frame.aabb(&b))).collect();
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
        let left = slots.into_iter().zip(&gathered);
        let (last, unbounded): (Vec<_>, Vec<_>) = left.partition(|(_, gathered)| **gathered);
        ordered.extend(unbounded.into_iter().filter_map(|(slot, _)| slot));
        let first = ordered.len();
        ordered.extend(last.into_iter().filter_map(|(slot, _)| slot));
        let merged = if first < ordered.len() {
            let members = &ordered[first..];
            Some(Merged::build(members, first, offset, &transforms, &materials, &faces, options)?)
        } else {
            None
        };

        let (camera_desc, span) = match staging.camera.as_ref().or(self.camera.as_ref()) {
            Some(camera) => (camera.value.clone(), camera.span),
            None => (CameraDesc::framing(&total, aspect), None),
        };
        let camera = camera_desc.prepare(aspect).map_err(|e| e.or_at(span))?;
        let sieved = if sieve.is_some() { bounded } else { 0 };
        let batch = BatchShapes::new(&ordered[..first], sieved, bounded - sieved, &materials, &faces);
        let stats = SceneStats {
            primitives: ordered.len() as u64,
            triangles: shapes.meshes.iter().map(|m| m.triangle_count() as u64).sum(),
            bounds: (!total.is_empty()).then_some(total),
            tree_bytes: (ordered.len() * size_of::<Primitive>()
                + transforms.len() * size_of::<ObjectTransform>()
                + bvh.bytes()
                + batch.bytes()) as u64,
            mesh_bytes: shapes.meshes.iter().map(|m| m.memory() as u64).sum::<u64>()
                + merged.as_ref().map_or(0, |m| m.bytes() as u64),
            texture_bytes: textures.picture_memory() as u64,
            film_bytes,
        };
        let mut scene = Scene {
            pixel_cone: filtered.then(|| PixelCone::new(&camera, &self.film)),
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
            gathered: first,
            merged,
            transforms,
            bvh,
            sieve,
            frame,
            batch,
            faces,
            moves: moving.contains(&true),
            volumes,
            emitters: Emitters::default(),
            caustics: None,
            reuses_paths: false,
            object_names: names.finish(),
            light_groups,
            light_sources,
            warnings,
            stats,
        };
        if physical {
            scene.choose_lights(LightChoice::Auto);
            scene.caustics = Plan::new(&scene);
            decide(&mut scene);
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

    fn prepare_lights(&self) -> Result<PreparedLights, SceneError> {
        let (mut lights, mut sources, mut ambient) = (Vec::new(), Vec::new(), Spectrum::BLACK);
        let (compensated, physical) = (self.integrator.compensates(), self.integrator.is_physical());
        for (number, light) in self.lights.iter().enumerate() {
            let prepared = light.value.prepare(&self.images, compensated, physical, &mut lights);
            ambient += prepared.map_err(|e| e.or_at(light.span))?;
            sources.resize(lights.len(), Some(number as u32));
        }
        Ok(PreparedLights { lights, sources, ambient })
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

/// Lights with a place or a direction, for each its number in the description, and the sum of the ambient ones.
struct PreparedLights {
    lights: Vec<Light>,
    sources: Vec<Option<u32>>,
    ambient: Spectrum,
}

/// Shapes made ready once, however often their groups are placed.
pub(super) struct PreparedShapes {
    /// For the scene's objects and for each group's, by index; `None` for instances.
    pub(super) objects: Vec<Option<Shape>>,
    pub(super) groups: Vec<Vec<Option<Shape>>>,
    pub(super) meshes: Vec<Arc<TriangleMesh>>,
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
        warnings.extend(cache.warnings().iter().map(|m| Warning::new(WarningKind::Doubtful, m.as_str())));
        let meshes = cache.prepared().cloned().collect();
        Ok(PreparedShapes { objects, groups, meshes })
    }
}
