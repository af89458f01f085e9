//! The recursion, many samples at a time: each round traces the next ray of every sample that has one.
//!
//! A sample's rays are traced in the order of the recursion, whatever the other samples do, so its sum does not
//! depend on them. Batches of closest hits and of shadow rays come of it, which the scene answers eight at a time.

use turner_bvh::lanes::{LANES, dispatch};

use super::points::{PointBlock, Surfaces, get, jitter_dimension, set};
use super::shade::{Accumulate, Ambient, Illuminate, Leave, LeavingBlock, TermBlock, ask};
use super::{AtDepth, ClassicDesc, Combine, Miss};
use crate::color::Spectrum;
use crate::integrator::{CameraSamples, Integrator, Radiance, RayStats, Tracer, footprint};
use crate::light::Light;
use crate::material::{Classic, Fresnel, Material, color_at};
use crate::math::elementary::Exponent;
use crate::math::{DVec2, DVec3, Ray, RayCone, refract};
use crate::scene::{ColorSource, Hit, RayBatch, Scene, SpectrumBlock, SurfaceInteraction};

/// A ray of a tree: whose it is, and its share of the pixel.
#[derive(Clone, Copy)]
struct Task {
    sample: u32,
    depth: u32,
    weight: f64,
    /// What the ray stands for, where textures are filtered, from its end on once it has arrived; and how much the surface there turns away from it.
    cone: RayCone,
    curvature: f32,
}

impl Task {
    /// The ray arrives at a surface, which learns of its cone.
    fn arrive(&mut self, scene: &Scene, surface: &mut SurfaceInteraction, direction: DVec3, t: f64) {
        footprint::arrive(&mut self.cone, surface, direction, t);
        let side = if direction.dot(surface.ng) <= 0.0 { 1.0 } else { -1.0 };
        self.curvature = (side * scene.curvature(surface)) as f32;
    }
}

/// A ray that waits until those before it, and all that these spawn, have been traced.
struct Waiting {
    ray: Ray,
    task: Task,
    /// The one that waits behind it, as `Tree::waiting`.
    next: Option<u32>,
}

/// How far the tree of one sample has come.
#[derive(Clone)]
struct Tree {
    /// Rays spawned.
    spawned: u32,
    /// Rays numbered for the jitter of area lights.
    shaded: u64,
    /// The ray to be traced when those under way are done, in the list of all that wait.
    waiting: Option<u32>,
}

/// The rays of one round, one for each sample that has one.
#[derive(Default)]
struct Front {
    rays: RayBatch,
    tasks: Vec<Task>,
}

impl Front {
    fn clear(&mut self) {
        self.rays.clear();
        self.tasks.clear();
    }

    #[inline]
    fn push(&mut self, ray: &Ray, task: Task) {
        self.rays.push(ray);
        self.tasks.push(task);
    }
}

/// All that is known of a batch of samples while it is traced; its memory serves one batch after the other.
struct Wave<'a> {
    integrator: &'a ClassicDesc,
    scene: &'a Scene,
    trees: Vec<Tree>,
    waiting: Vec<Waiting>,
    front: Front,
    next: Front,
    hits: Vec<Option<Hit>>,
    /// Hits of this round, in the order of the front, in the first so many blocks.
    points: Vec<PointBlock>,
    blocks: usize,
    struck: Vec<Struck<'a>>,
    /// Physical materials at the hits of this round, as classic ones.
    converted: Vec<Classic>,
    terms: Vec<TermBlock>,
    shadow_rays: RayBatch,
    through: Vec<SpectrumBlock>,
    leaving: Vec<LeavingBlock>,
}

/// What a hit needs beside its place in a block.
struct Struck<'a> {
    task: Task,
    /// A material of the scene, or the number of a converted one.
    material: Result<&'a Classic, usize>,
    weights: Weights,
    refracted: Option<DVec3>,
}

impl<'a> Struck<'a> {
    #[inline]
    fn material(&self, converted: &'a [Classic]) -> &'a Classic {
        self.material.unwrap_or_else(|i| &converted[i])
    }
}

/// Weights of the three terms at a hit.
#[derive(Clone, Copy)]
struct Weights {
    local: f64,
    reflect: f64,
    refract: f64,
}

impl Integrator for ClassicDesc {
    fn tracer<'a>(&'a self, scene: &'a Scene) -> Box<dyn Tracer + 'a> {
        Box::new(Wave {
            integrator: self,
            scene,
            trees: Vec::new(),
            waiting: Vec::new(),
            front: Front::default(),
            next: Front::default(),
            hits: Vec::new(),
            points: Vec::new(),
            blocks: 0,
            struck: Vec::new(),
            converted: Vec::new(),
            terms: Vec::new(),
            shadow_rays: RayBatch::default(),
            through: Vec::new(),
            leaving: Vec::new(),
        })
    }
}

impl Tracer for Wave<'_> {
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let count = samples.ids.len();
        stats.camera += count as u64;
        out.clear();
        out.resize(count, Radiance { color: Spectrum::BLACK, alpha: 1.0 });
        self.trees.clear();
        self.trees.resize(count, Tree { spawned: 0, shaded: 0, waiting: None });
        self.waiting.clear();
        self.front.rays.copy(&samples.rays);
        self.front.rays.coherent = true;
        self.front.tasks.clear();
        self.front.tasks.extend((0..count as u32).map(|sample| {
            let cone = footprint::of_camera(self.scene, samples, sample as usize);
            Task { sample, depth: 0, weight: 1.0, cone, curvature: 0.0 }
        }));
        while !self.front.tasks.is_empty() {
            self.round(samples, out, stats);
        }
        for tree in &self.trees {
            stats.dropped += u64::from(tree.spawned > self.integrator.max_rays);
        }
    }
}

impl Wave<'_> {
    /// Traces the front and finds the next one.
    fn round(&mut self, samples: &CameraSamples, out: &mut [Radiance], stats: &mut RayStats) {
        self.scene.intersect_batch(&mut self.front.rays, &mut self.hits);
        self.front.rays.coherent = false;
        self.next.clear();
        self.gather(out);
        let facing = self.integrator.facing;
        dispatch(Surfaces { points: &mut self.points[..self.blocks], facing });
        self.weigh();
        let ambient = self.integrator.ambient.then_some(self.scene.ambient);
        dispatch(Ambient { points: &mut self.points[..self.blocks], ambient });
        self.lights(samples, stats);
        self.leave(samples, out, stats);
        std::mem::swap(&mut self.front, &mut self.next);
    }

    /// Settles rays that hit nothing and collects the hits of the others.
    fn gather(&mut self, out: &mut [Radiance]) {
        self.blocks = 0;
        self.struck.clear();
        self.converted.clear();
        for (i, hit) in self.hits.iter().enumerate() {
            let mut task = self.front.tasks[i];
            let Some(hit) = hit else {
                let tree = &mut self.trees[task.sample as usize];
                let direction = || get(&self.front.rays.blocks()[i / LANES].direction, i % LANES);
                let pixel = &mut out[task.sample as usize];
                self.integrator.miss(self.scene, &task, direction, pixel);
                resume(tree, &mut self.waiting, &mut self.next);
                continue;
            };
            let lane = self.struck.len() % LANES;
            if lane == 0 {
                self.blocks += 1;
                if self.blocks > self.points.len() {
                    self.points.push(PointBlock::default());
                }
                self.points[self.blocks - 1].clear();
            }
            let b = &mut self.points[self.blocks - 1];
            let filtered = self.scene.pixel_cone.is_some();
            let surface_of = |ray: &Ray, task: &mut Task| {
                let mut surface = self.scene.surface(ray, hit);
                if filtered {
                    task.arrive(self.scene, &mut surface, ray.direction, hit.shape.t);
                }
                surface
            };
            let (material, seen) = match self.scene.material_at(hit) {
                Material::Classic(material) => (Ok(material), None),
                // Never prepared for this integrator.
                Material::Physical(_) => continue,
                Material::Principled(physical, _) => {
                    let Some(ray) = self.front.rays.get(i) else { continue };
                    let mut surface = surface_of(&ray, &mut task);
                    let (converted, emitted) = physical.as_classic(self.scene, &mut surface, ray.direction);
                    out[task.sample as usize].color += emitted * task.weight as f32;
                    self.converted.push(converted);
                    (Err(self.converted.len() - 1), Some(surface))
                }
                Material::Mix(mix) => {
                    let Some(ray) = self.front.rays.get(i) else { continue };
                    let mut surface = surface_of(&ray, &mut task);
                    let (converted, emitted) = mix.as_classic(self.scene, &mut surface, ray.direction);
                    out[task.sample as usize].color += emitted * task.weight as f32;
                    self.converted.push(converted);
                    (Err(self.converted.len() - 1), Some(surface))
                }
            };
            let classic = material.unwrap_or_else(|i| &self.converted[i]);
            let rays = &self.front.rays.blocks()[i / LANES];
            for axis in 0..3 {
                b.d[axis].0[lane] = rays.direction[axis].0[i % LANES];
                b.origin[axis].0[lane] = rays.origin[axis].0[i % LANES];
            }
            b.t.0[lane] = hit.shape.t;
            let sphere = if seen.is_none() { self.scene.sphere_at(hit) } else { None };
            if let Some(sphere) = sphere {
                b.on_sphere |= 1 << lane;
                set(&mut b.center, lane, sphere.center);
                b.radius.0[lane] = sphere.radius;
            }
            let mut color = None;
            if let ColorSource::Constant(c) = classic.color
                && sphere.is_some()
                && !filtered
                && classic.bump.is_none()
            {
                color = Some(c);
            } else if let Some(ray) = self.front.rays.get(i) {
                let mut surface = seen.unwrap_or_else(|| surface_of(&ray, &mut task));
                if let Some(bump) = classic.bump {
                    self.scene.apply_bump_map(&mut surface, bump);
                }
                b.on_sphere &= !(1 << lane);
                set(&mut b.p, lane, surface.p);
                set(&mut b.ng, lane, surface.ng);
                set(&mut b.ns, lane, surface.ns);
                b.error.0[lane] = surface.error;
                color = Some(color_at(classic.color, self.scene, &surface));
            }
            b.color.set(lane, color.unwrap_or(Spectrum::BLACK));
            self.integrator.coefficients(classic, b, lane);
            self.struck.push(Struck {
                task,
                material,
                weights: Weights { local: 0.0, reflect: 0.0, refract: 0.0 },
                refracted: None,
            });
        }
    }

    /// Divides each ray's weight among local colour, reflection and refraction.
    fn weigh(&mut self) {
        for (i, struck) in self.struck.iter_mut().enumerate() {
            let (b, lane) = (&mut self.points[i / LANES], i % LANES);
            (struck.weights, struck.refracted) =
                self.integrator.weights(struck.material(&self.converted), struck.task.depth, b, lane);
            b.weight.0[lane] = struck.task.weight * struck.weights.local;
            if struck.weights.local > 0.0 && (b.kd.0[lane] != 0.0 || b.ks.0[lane] != 0.0) {
                b.shaded |= 1 << lane;
            }
            if struck.weights.reflect > 0.0 {
                b.mirrors |= 1 << lane;
            }
        }
    }

    /// Adds the lights, one after the other, to the local colours.
    fn lights(&mut self, samples: &CameraSamples, stats: &mut RayStats) {
        if self.points[..self.blocks].iter().all(|b| b.shaded == 0) {
            return;
        }
        self.terms.resize(self.blocks.max(self.terms.len()), TermBlock::default());
        for (number, light) in self.scene.lights.iter().enumerate() {
            let uniform = light.uniform();
            for i in 0..light.samples() {
                if uniform.is_none() {
                    let jitter = |at: usize| {
                        if !light.is_jittered() {
                            return DVec2::ZERO;
                        }
                        let sample = self.struck[at].task.sample as usize;
                        let dimension = jitter_dimension(self.trees[sample].shaded, number, i);
                        samples.ids[sample].unit_square(dimension)
                    };
                    ask(light, i, &self.points[..self.blocks], &mut self.terms, jitter);
                }
                self.shadow_rays.clear();
                let reached = dispatch(Illuminate {
                    integrator: self.integrator,
                    points: &self.points[..self.blocks],
                    terms: &mut self.terms,
                    uniform,
                    finite: light.is_finite(),
                    shadow_rays: &mut self.shadow_rays,
                });
                if reached == 0 {
                    continue;
                }
                let through = if self.integrator.shadows {
                    stats.shadow += reached;
                    self.scene.transmittance_batch(&mut self.shadow_rays, &mut self.through);
                    Some(&self.through[..])
                } else {
                    None
                };
                dispatch(Accumulate {
                    points: &mut self.points[..self.blocks],
                    terms: &self.terms,
                    intensity: uniform.map(|u| u.intensity()),
                    through,
                    shadow_factor: self.integrator.shadow_factor as f32,
                });
            }
        }
        for (i, struck) in self.struck.iter().enumerate() {
            if self.points[i / LANES].shaded >> (i % LANES) & 1 == 1 {
                self.trees[struck.task.sample as usize].shaded += 1;
            }
        }
    }

    /// Adds the local colours to the pixels and spawns the rays that leave the hits.
    fn leave(&mut self, samples: &CameraSamples, out: &mut [Radiance], stats: &mut RayStats) {
        let leaving = &mut self.leaving;
        leaving.resize(self.blocks.max(leaving.len()), LeavingBlock::default());
        dispatch(Leave { integrator: self.integrator, points: &self.points[..self.blocks], leaving });
        for (i, struck) in self.struck.iter().enumerate() {
            let (b, leaving, lane) = (&self.points[i / LANES], &self.leaving[i / LANES], i % LANES);
            let sample = struck.task.sample as usize;
            let (tree, pixel) = (&mut self.trees[sample], &mut out[sample]);
            if struck.weights.local > 0.0 {
                pixel.color += leaving.color.get(lane);
            }
            let length = samples.lengths[sample / LANES].0[sample % LANES];
            // The refracted ray comes first, but the reflected one is traced first: the documents' order.
            let mut spawned = None;
            if let Some(direction) = struck.refracted
                && struck.weights.refract > 0.0
            {
                let task = &struck.task;
                let weight = struck.weights.refract;
                if let Some(mut task) =
                    self.integrator.spawn(self.scene, task, weight, || direction, tree, pixel)
                {
                    stats.refracted += 1;
                    let ior = struck.material(&self.converted).ior;
                    let eta = if b.entering >> lane & 1 == 1 { ior } else { ior.recip() };
                    task.cone = struck.task.cone.refracted(eta, f64::from(struck.task.curvature));
                    let origin = if self.integrator.epsilon > 0.0 {
                        get(&b.p, lane)
                    } else {
                        b.leave(lane, direction)
                    };
                    spawned = Some((self.integrator.leaving_ray(origin, direction, length), task));
                }
            }
            if struck.weights.reflect > 0.0 {
                let direction = || get(&leaving.direction, lane);
                let weight = struck.weights.reflect;
                if let Some(mut task) =
                    self.integrator.spawn(self.scene, &struck.task, weight, direction, tree, pixel)
                {
                    stats.reflected += 1;
                    task.cone = struck.task.cone.reflected(f64::from(struck.task.curvature));
                    if let Some((ray, task)) = spawned {
                        let behind = tree.waiting.replace(self.waiting.len() as u32);
                        self.waiting.push(Waiting { ray, task, next: behind });
                    }
                    let origin = get(&leaving.origin, lane);
                    spawned = Some((self.integrator.leaving_ray(origin, direction(), length), task));
                }
            }
            match spawned {
                Some((ray, task)) => self.next.push(&ray, task),
                None => resume(tree, &mut self.waiting, &mut self.next),
            }
        }
    }
}

/// Takes up the ray of a sample that has waited for the shortest time, if there is one.
#[inline]
fn resume(tree: &mut Tree, waiting: &mut [Waiting], next: &mut Front) {
    if let Some(i) = tree.waiting {
        let Waiting { ray, task, next: behind } = &waiting[i as usize];
        tree.waiting = *behind;
        next.push(ray, *task);
    }
}

impl ClassicDesc {
    /// The coefficients of a material as far as their terms count.
    #[inline]
    fn coefficients(&self, material: &Classic, b: &mut PointBlock, lane: usize) {
        b.ka.0[lane] = material.ka as f32;
        b.kd.0[lane] = if self.diffuse { material.kd } else { 0.0 };
        let ks = if self.highlights { material.ks } else { 0.0 };
        b.ks.0[lane] = ks;
        if ks > 0.0 {
            b.glossy |= 1 << lane;
            b.dark.0[lane] = material.dark;
            match material.exponent {
                Exponent::Whole(n) => {
                    b.exponent.0[lane] = f64::from_bits(u64::from(n));
                    b.exponent_bits |= n;
                }
                Exponent::Real(y) => {
                    b.exponent.0[lane] = y;
                    b.real_exponent |= 1 << lane;
                }
            }
        }
    }

    /// The weights of local, reflected and refracted colour, and the refracted direction if there is one.
    #[inline]
    fn weights(&self, m: &Classic, depth: u32, b: &PointBlock, lane: usize) -> (Weights, Option<DVec3>) {
        let k_reflect = if self.reflection { m.k_reflect } else { 0.0 };
        let k_refract = if self.refraction { m.k_refract } else { 0.0 };
        if k_reflect == 0.0 && k_refract == 0.0 {
            return (Weights { local: m.k_local.unwrap_or(1.0), reflect: 0.0, refract: 0.0 }, None);
        }
        if self.at_depth == AtDepth::Local && depth >= self.max_depth {
            return (Weights { local: 1.0, reflect: 0.0, refract: 0.0 }, None);
        }
        let d = get(&b.d, lane);
        let n = b.facing(&b.ns, lane);
        let eta = if b.entering >> lane & 1 == 1 { 1.0 / m.ior } else { m.ior };
        let direction = if k_refract > 0.0 { refract(d, n, eta) } else { None };
        let (reflect, refracted) = match (m.fresnel, k_refract > 0.0 && direction.is_none()) {
            // Total internal reflection: the refracted share goes along the mirror direction.
            (Fresnel::Off, true) => (k_reflect + k_refract, 0.0),
            (_, true) => (k_reflect.max(k_refract), 0.0),
            (Fresnel::Off, false) => (k_reflect, k_refract),
            (fresnel, false) => {
                let f = fresnel.reflectance((-d.dot(n)).clamp(0.0, 1.0), eta);
                (k_reflect * f, k_refract * (1.0 - f))
            }
        };
        let local = m.k_local.unwrap_or(match self.combine {
            Combine::Add => 1.0,
            Combine::Blend => (1.0 - reflect - refracted).max(0.0),
        });
        (Weights { local, reflect, refract: refracted }, direction)
    }

    /// A reflected or refracted ray to be traced; beyond the depth limit adds what stands for it instead.
    #[inline]
    fn spawn(
        &self,
        scene: &Scene,
        from: &Task,
        weight: f64,
        direction: impl Fn() -> DVec3,
        tree: &mut Tree,
        pixel: &mut Radiance,
    ) -> Option<Task> {
        let weight = from.weight * weight;
        let depth = from.depth + 1;
        if depth > self.max_depth {
            let color = match self.at_depth {
                AtDepth::Background => scene.surroundings(direction()),
                AtDepth::Ambient => scene.ambient,
                AtDepth::Black | AtDepth::Local => return None,
            };
            pixel.color += color * weight as f32;
            return None;
        }
        tree.spawned = tree.spawned.saturating_add(1);
        (tree.spawned <= self.max_rays).then_some(Task {
            sample: from.sample,
            depth,
            weight,
            cone: from.cone,
            curvature: 0.0,
        })
    }

    /// A ray that leaves a surface; `length` is that of the camera ray, as the documents form it, which reflection and
    /// refraction keep: `epsilon` is a t.
    #[inline]
    fn leaving_ray(&self, origin: DVec3, direction: DVec3, length: f64) -> Ray {
        let mut ray = Ray::new(origin, direction);
        if self.epsilon > 0.0 {
            ray.t_min = self.epsilon * length;
        }
        ray
    }

    fn miss(&self, scene: &Scene, task: &Task, direction: impl Fn() -> DVec3, pixel: &mut Radiance) {
        if self.light_seen {
            let mut seen = Spectrum::BLACK;
            let mut any = false;
            for light in &scene.lights {
                if let Light::Directional(light) = light
                    && light.is_seen(direction())
                {
                    seen += light.intensity;
                    any = true;
                }
            }
            if any {
                pixel.color += seen * task.weight as f32;
                return;
            }
        }
        if task.depth == 0 && scene.background.transparent {
            pixel.alpha = 0.0;
            return;
        }
        if self.miss == Miss::Background {
            pixel.color += scene.surroundings(direction()) * task.weight as f32;
        }
    }
}
