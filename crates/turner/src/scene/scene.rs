//! The prepared scene: complete, immutable, shared by all threads. Intersection, shadow rays, and the surface at a
//! hit.

use std::cell::Cell;
use std::sync::Arc;

use turner_bvh::{BoxBvh, InstructionSet};

use crate::animation::motion::{Displacement, Motion};
use crate::color::Spectrum;
use crate::interaction::{Hit, NOT_SEEN, SurfaceInteraction};
use crate::light::{BackgroundDesc, Light};
use crate::material::{Material, ShadowKind};
use crate::math::{Bounds, DAffine3, DMat3, DVec3, Ray};
use crate::scene::alpha_test::{Faces, NO_FACES};
use crate::scene::batch::BatchShapes;
use crate::scene::camera_visibility::PrimitiveSet;
use crate::scene::emitters::Emitters;
use crate::scene::light_groups::LightGroups;
use crate::scene::names::ObjectNames;
use crate::scene::sphere_culler::SphereCuller;
use crate::scene::volumes::Volumes;
use crate::scene::world_mesh::StaticWorldMesh;
use crate::schema::MaterialId;
use crate::shape::traversal::TraversalFrame;
use crate::shape::{Shape, ShapeHit, Sphere, SurfacePoint};
use crate::texture::Textures;

/// A prepared scene. Its parts are shared (`Arc`), so a copy is cheap and an edit rebuilds only what it changes.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The background, seen by rays that hit nothing.
    pub background: BackgroundDesc,
    /// All textures.
    pub textures: Arc<Textures>,
    /// Materials, by id; after those of the description come the default material and those of the default studio.
    pub materials: Arc<[Material]>,
    /// All lights except ambient ones.
    pub lights: Arc<[Light]>,
    /// What moves each light while the shutter is open; empty if none moves.
    pub(crate) light_motions: Arc<[Option<Displacement>]>,
    /// Opening and closing time of the shutter.
    pub(crate) shutter: [f64; 2],
    /// The sum of the ambient lights.
    pub ambient: Spectrum,
    /// Bounded primitives in the BVH's leaf order, then unbounded ones, then those in the static world mesh.
    pub(crate) primitives: Arc<[Primitive]>,
    /// Number of primitives in the BVH.
    pub(crate) bounded: usize,
    /// Index of the first primitive in `world_mesh`.
    pub(crate) gathered: usize,
    pub(crate) world_mesh: Option<StaticWorldMesh>,
    pub(crate) transforms: Arc<[ObjectTransform]>,
    /// Empty if `culler` is used.
    pub(crate) bvh: Arc<BoxBvh>,
    /// Replaces the BVH in scenes of few shapes.
    pub(crate) culler: Option<SphereCuller>,
    pub(crate) frame: TraversalFrame,
    /// The shapes that batches test many rays at a time.
    pub(crate) batch: Arc<BatchShapes>,
    /// Faces of primitives with cut-outs or several materials.
    pub(crate) faces: Arc<[Faces]>,
    /// Whether the integrator is physical: then materials are physical ones and lights can be sampled.
    pub(crate) physical: bool,
    /// Whether anything moves: then camera rays have a time.
    pub(crate) moves: bool,
    /// Participating media, if the scene has any; for physical integrators.
    pub(crate) volumes: Option<Arc<Volumes>>,
    /// Emitters for light sampling, with physical integrators; empty otherwise.
    pub emitters: Arc<Emitters>,
    /// Names of objects.
    pub(crate) object_names: Arc<ObjectNames>,
    /// Names of materials, by id.
    pub(crate) material_names: Arc<[Option<String>]>,
    /// Light groups of lights and objects.
    pub light_groups: LightGroups,
    /// Objects of which the camera sees only the shadow on them.
    pub shadow_catchers: PrimitiveSet,
    /// Objects that rays from the camera pass through.
    pub hidden_from_camera: PrimitiveSet,
    /// For each light its index in the description; `None` for those of the default studio.
    pub light_sources: Vec<Option<u32>>,
    /// Counts and sizes, for `turner info`.
    pub stats: SceneStats,
    /// Instruction set with which batches are traced and shaded.
    pub instruction_set: InstructionSet,
}

/// Counts and sizes of a prepared scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneStats {
    /// Shapes, instances flattened.
    pub primitives: u64,
    /// Triangles of the meshes, each mesh counted once.
    pub triangles: u64,
    /// Bounds of everything bounded.
    pub bounds: Option<Bounds>,
    /// Bytes of primitives, transforms and the BVH over them.
    pub tree_bytes: u64,
    /// Bytes of meshes with their BVHs.
    pub mesh_bytes: u64,
    /// Bytes of images.
    pub texture_bytes: u64,
}

/// A shape with its material and transform.
#[derive(Clone, Debug)]
pub(crate) struct Primitive {
    pub(crate) shape: Shape,
    pub(crate) material: MaterialId,
    /// Index into the scene's transforms, or [`NO_TRANSFORM`].
    pub(crate) transform: u32,
    /// Index into the scene's faces, or [`NO_FACES`].
    pub(crate) faces: u32,
    /// ID in the description, instances in order. It breaks ties between equally near hits, so that the picture does
    /// not depend on the BVH.
    pub(crate) id: u32,
}

impl Primitive {
    /// An unbounded shape in world space.
    pub(crate) fn unbounded(shape: Shape, material: MaterialId, id: u32) -> Primitive {
        Primitive { shape, material, transform: NO_TRANSFORM, faces: NO_FACES, id }
    }
}

pub(crate) const NO_TRANSFORM: u32 = u32::MAX;

/// A transform and the matrices derived from it.
#[derive(Clone, Debug)]
pub(crate) struct ObjectTransform {
    pub(crate) to_world: DAffine3,
    pub(crate) to_object: DAffine3,
    /// Normals transform by the inverse transpose.
    pub(crate) normal: DMat3,
    /// Upper bound of the factor by which lengths grow.
    pub(crate) stretch: f64,
    /// Motion, if the object moves; the other fields are then the placement when the shutter opens.
    pub(crate) motion: Option<Box<Motion>>,
    /// The shape in world space, where rays without a transform meet it: see [`Shape::in_world`].
    pub(crate) in_world: Option<Box<Shape>>,
}

impl ObjectTransform {
    pub(crate) fn new(to_world: DAffine3) -> ObjectTransform {
        let to_object = to_world.inverse();
        let m = to_world.matrix3;
        let stretch =
            (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt();
        let normal = to_object.matrix3.transpose();
        ObjectTransform { to_world, to_object, normal, stretch, motion: None, in_world: None }
    }

    /// The shape and the ray that meet in one space, which is that of the world where it can be.
    #[inline(always)]
    fn met<'a>(&'a self, shape: &'a Shape, ray: &Ray) -> (&'a Shape, Ray) {
        self.in_world.as_deref().map_or_else(|| (shape, self.ray_to_object(ray)), |there| (there, *ray))
    }

    /// Transforms a ray from world space to object space at the ray's time.
    #[inline]
    pub(crate) fn ray_to_object(&self, ray: &Ray) -> Ray {
        match &self.motion {
            None => ray.transformed(&self.to_object),
            Some(motion) => ray.transformed(&motion.at(f64::from(ray.time)).inverse()),
        }
    }
}

impl Scene {
    /// The same scene with the lights of the default studio turned about +y, in degrees: they follow a camera that
    /// circles the scene. `None` if the studio does not light the scene.
    pub fn with_turned_studio(&self, degrees: f64) -> Option<Scene> {
        let of_studio = |i: usize| self.light_sources.get(i).is_some_and(Option::is_none);
        let turned = |(i, light): (usize, &Light)| match light {
            Light::Environment(l) if of_studio(i) => Light::Environment(l.turned(degrees)),
            light => light.clone(),
        };
        let has_studio = (0..self.lights.len()).any(of_studio);
        has_studio
            .then(|| Scene { lights: self.lights.iter().enumerate().map(turned).collect(), ..self.clone() })
    }

    /// Whether background, light groups, shadow catchers, hidden objects and names are those of another scene.
    pub(crate) fn has_settings_of(&self, other: &Scene) -> bool {
        self.background == other.background
            && self.ambient == other.ambient
            && self.light_groups == other.light_groups
            && self.shadow_catchers == other.shadow_catchers
            && self.hidden_from_camera == other.hidden_from_camera
            && self.light_sources == other.light_sources
            && self.material_names == other.material_names
    }

    /// From the object space of a primitive.
    pub(crate) fn to_world(&self, primitive: &Primitive) -> DAffine3 {
        match primitive.transform {
            NO_TRANSFORM => DAffine3::IDENTITY,
            i => self.transforms[i as usize].to_world,
        }
    }

    /// Radiance of a ray that hits nothing: the environment, if there is one and the background shows it, else the
    /// background's colour.
    pub fn background_radiance(&self, direction: DVec3) -> Spectrum {
        let mut around = self.lights.iter().filter_map(|light| light.around(direction));
        match around.next() {
            Some(first) if self.background.environment => around.fold(first, |sum, next| sum + next),
            _ => self.background.color(direction),
        }
    }

    /// The nearest hit with `t_min <= t <= t_max`; among equally near hits that of the object that comes first in the
    /// description.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut ray = *ray;
        let mut best: Option<Hit> = None;
        if let Some(world_mesh) = &self.world_mesh
            && let Some(hit) = self.intersect_world_mesh(world_mesh, &ray)
        {
            ray.t_max = hit.shape.t;
            best = Some(hit);
        }
        for i in self.bounded..self.gathered {
            self.try_primitive(i as u32, &mut ray, &mut best);
        }
        self.intersect_bounded(&mut ray, &mut best);
        best
    }

    /// The nearest hit among the primitives of the BVH or the sphere culler.
    #[inline]
    pub(crate) fn intersect_bounded(&self, ray: &mut Ray, best: &mut Option<Hit>) {
        let Some(search) = self.frame.ray(ray) else { return };
        if let Some(culler) = &self.culler {
            for i in Bits(culler.candidates(&search.ray)) {
                self.try_primitive(i, ray, best);
            }
        } else {
            self.bvh.closest(&search.ray, |leaf, t_max| {
                let before = ray.t_max;
                for i in leaf {
                    self.try_primitive(i, ray, best);
                }
                if ray.t_max < before { search.end(ray.t_max) } else { t_max }
            });
        }
    }

    #[inline(always)]
    pub(crate) fn try_primitive(&self, index: u32, ray: &mut Ray, best: &mut Option<Hit>) {
        let primitive = &self.primitives[index as usize];
        let Some(shape) = self.intersect_primitive(primitive, ray) else { return };
        self.keep_nearer(index, shape, ray, best);
    }

    /// Keeps a primitive's hit in `best` if it is nearer, and shortens the ray to it.
    #[inline(always)]
    pub(crate) fn keep_nearer(&self, index: u32, shape: ShapeHit, ray: &mut Ray, best: &mut Option<Hit>) {
        self.keep_nearer_before(Hit { shape, primitive: index }, &mut ray.t_max, best);
    }

    /// The same with the ray's end alone. Of equally near hits, those on boundaries of media come last, then the order of
    /// the description counts.
    #[inline(always)]
    pub(crate) fn keep_nearer_before(&self, hit: Hit, end: &mut f64, best: &mut Option<Hit>) {
        // By value: a reference would force every hit through memory.
        let nearer = hit.shape.t < *end || best.is_none_or(|best| self.comes_before(hit, best));
        if nearer {
            *end = hit.shape.t;
            *best = Some(hit);
        }
    }

    /// Whether the first of two equally near hits counts.
    #[cold]
    #[inline(never)]
    fn comes_before(&self, hit: Hit, best: Hit) -> bool {
        let order = |hit: &Hit| (self.material_at(hit).is_boundary(), self.primitive_id(hit));
        order(&hit) < order(&best)
    }

    #[inline(always)]
    fn intersect_primitive(&self, primitive: &Primitive, ray: &Ray) -> Option<ShapeHit> {
        if primitive.faces != NO_FACES {
            return self.intersect_faces(primitive, ray);
        }
        if primitive.transform == NO_TRANSFORM {
            // Spheres and planes are tested inline: a call costs as much as the test.
            match &primitive.shape {
                Shape::Sphere(sphere) => sphere.intersect(ray),
                Shape::Plane(plane) => plane.intersect(ray),
                shape => shape.intersect(ray),
            }
        } else {
            let (shape, ray) = self.transforms[primitive.transform as usize].met(&primitive.shape, ray);
            shape.intersect(&ray)
        }
    }

    #[inline(always)]
    pub(crate) fn primitive_blocks(&self, index: u32, ray: &Ray, tinted: &Cell<bool>) -> bool {
        let primitive = &self.primitives[index as usize];
        if primitive.faces != NO_FACES {
            return self.faces_block(primitive, ray, tinted);
        }
        let hit = if primitive.transform == NO_TRANSFORM {
            match &primitive.shape {
                Shape::Sphere(sphere) => sphere.intersect(ray).is_some(),
                Shape::Plane(plane) => plane.intersect(ray).is_some(),
                shape => shape.occludes(ray),
            }
        } else {
            let (shape, ray) = self.transforms[primitive.transform as usize].met(&primitive.shape, ray);
            shape.occludes(&ray)
        };
        hit && match self.materials[primitive.material.index()].shadow() {
            ShadowKind::Opaque => true,
            ShadowKind::None => false,
            ShadowKind::Tinted => {
                tinted.set(true);
                false
            }
        }
    }

    /// Whether anything that casts a shadow, even a tinted one, is hit with `t_min <= t <= t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        let tinted = Cell::new(false);
        self.blocked(ray, &tinted) || tinted.get()
    }

    /// Whether anything opaque is hit; if not, `tinted` says whether anything tinted is.
    #[inline]
    fn blocked(&self, ray: &Ray, tinted: &Cell<bool>) -> bool {
        if let Some(world_mesh) = &self.world_mesh
            && self.world_mesh_blocks(world_mesh, ray, tinted)
        {
            return true;
        }
        for i in self.bounded..self.gathered {
            if self.primitive_blocks(i as u32, ray, tinted) {
                return true;
            }
        }
        self.bounded_block(ray, tinted)
    }

    /// The same among the primitives of the BVH or the sphere culler.
    #[inline]
    pub(crate) fn bounded_block(&self, ray: &Ray, tinted: &Cell<bool>) -> bool {
        match (self.frame.ray(ray), &self.culler) {
            (None, _) => false,
            (Some(search), Some(culler)) => {
                Bits(culler.candidates(&search.ray)).any(|i| self.primitive_blocks(i, ray, tinted))
            }
            (Some(search), None) => self
                .bvh
                .any(&search.ray, |leaf| leaf.into_iter().any(|i| self.primitive_blocks(i, ray, tinted))),
        }
    }

    /// Transmittance of a shadow ray: 0, 1, or the product of the tints of what it crosses.
    #[inline]
    pub fn transmittance(&self, ray: &Ray) -> Spectrum {
        let tinted = Cell::new(false);
        if self.blocked(ray, &tinted) {
            Spectrum::BLACK
        } else if tinted.get() {
            self.tinted_transmittance(ray)
        } else {
            Spectrum::WHITE
        }
    }

    /// Crosses surfaces in order from the near end, so that the product does not depend on the BVH.
    pub(crate) fn tinted_transmittance(&self, ray: &Ray) -> Spectrum {
        /// More crossings than this count as opaque.
        const MAX_CROSSINGS: u32 = 4096;
        let mut ray = *ray;
        let mut through = Spectrum::WHITE;
        for _ in 0..MAX_CROSSINGS {
            let Some(hit) = self.intersect(&ray) else { return through };
            let surface = self.surface(&ray, &hit);
            let material = &self.materials[surface.material.index()];
            match material.shadow() {
                ShadowKind::Opaque => return Spectrum::BLACK,
                ShadowKind::None => {}
                ShadowKind::Tinted => through = through * material.shadow_tint(self, &surface, ray.direction),
            }
            if through.is_black() {
                return through;
            }
            ray.t_min = self.beyond(&ray, &hit, &surface);
        }
        Spectrum::BLACK
    }

    /// The t at which a ray continues behind a surface; t is unchanged except for the offset.
    pub(crate) fn beyond(&self, ray: &Ray, hit: &Hit, surface: &SurfaceInteraction) -> f64 {
        next_after(hit.shape.t.max(ray.t_min), surface.error * 8.0 / ray.direction.length())
    }

    /// The surface interaction at a hit of `ray`.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfaceInteraction {
        let primitive = &self.primitives[hit.primitive as usize];
        let material = self.material_of(primitive, &hit.shape);
        // A point may be exact, like the origin on a plane through it: an offset ray needs an error bound above 0
        // nevertheless.
        let time = ray.time;
        let floor = 1e-15 * hit.shape.t;
        let interaction = |p: DVec3, error: f64, ng: DVec3, ns: DVec3, object: SurfacePoint| {
            SurfaceInteraction { p, error, ng, ns, material, object, hit: *hit, time, seen: NOT_SEEN }
        };
        if primitive.transform == NO_TRANSFORM {
            let s = primitive.shape.surface(ray, &hit.shape);
            if let Some((p, error, ng, ns)) = self.world_mesh_surface(hit, &s) {
                return interaction(p, error, ng, ns, s);
            }
            return interaction(s.p, s.error.max(floor), s.ng, s.ns, s);
        }
        let placed = &self.transforms[primitive.transform as usize];
        let now = placed.motion.as_ref().map(|m| ObjectTransform::new(m.at(f64::from(ray.time))));
        let transform = now.as_ref().unwrap_or(placed);
        let s = match &primitive.shape {
            Shape::Mesh(mesh) => mesh.surface(&hit.shape),
            shape => shape.surface(&ray.transformed(&transform.to_object), &hit.shape),
        };
        if let Some((p, error, ng, ns)) = self.world_mesh_surface(hit, &s) {
            return interaction(p, error, ng, ns, s);
        }
        if let Some(shape) = &placed.in_world {
            let there = shape.surface(ray, &hit.shape);
            return interaction(there.p, there.error.max(floor), there.ng, there.ns, s);
        }
        let p = transform.to_world.transform_point3(s.p);
        let ng = (transform.normal * s.ng).normalize();
        let ns = (transform.normal * s.ns).normalize();
        let size = p.abs().max_element() + transform.to_world.translation.abs().max_element();
        let error = (s.error * transform.stretch + 1e-15 * size).max(floor);
        interaction(p, error, ng, ns, s)
    }

    /// The sphere that was hit, if the hit is on a sphere without a transform.
    #[inline]
    pub fn sphere_at(&self, hit: &Hit) -> Option<&Sphere> {
        match &self.primitives[hit.primitive as usize] {
            Primitive { shape: Shape::Sphere(s), transform: NO_TRANSFORM, faces: NO_FACES, .. } => Some(s),
            _ => None,
        }
    }

    /// The material at a hit.
    #[inline]
    pub fn material_at(&self, hit: &Hit) -> &Material {
        let primitive = &self.primitives[hit.primitive as usize];
        &self.materials[self.material_of(primitive, &hit.shape).index()]
    }

    /// Id of the material at a hit.
    #[inline]
    pub fn material_id_at(&self, hit: &Hit) -> MaterialId {
        self.material_of(&self.primitives[hit.primitive as usize], &hit.shape)
    }

    /// The name of a material of the description, if it has one.
    pub fn material_name(&self, material: MaterialId) -> Option<&str> {
        self.material_names.get(material.index())?.as_deref()
    }

    /// ID of the primitive that was hit: its index in the description, instances in order.
    pub fn primitive_id(&self, hit: &Hit) -> u32 {
        self.primitives[hit.primitive as usize].id
    }
}

/// The set bits of a word, from the lowest.
pub(crate) struct Bits(pub(crate) u64);

impl Iterator for Bits {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        let i = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (i < 64).then_some(i)
    }
}

/// A t greater than `t` by at least `step`, and in any case greater.
fn next_after(t: f64, step: f64) -> f64 {
    (t + step).max(t.next_up())
}
