//! Whitted's recursion without recursion: the ray trees of a batch of samples, traced in rounds.
//!
//! The problem: each sample has a tree of rays (camera ray, then at each hit a reflected and a refracted ray).
//! Tracing one ray at a time leaves SIMD lanes idle. The idea: the samples of a tile advance together. Each round
//! traces one ray per sample.
//!
//! ```text
//! ray queue ─► closest hits ─► shade in blocks of 8: ambient term, then each light with its shadow rays ─► spawn
//!     ▲                                                                                                    │
//!     └──── per sample: the reflected ray, else the refracted ray, else the top of its stack ◄─────────────┘
//! ```
//!
//! Order: a hit that spawns two rays queues the reflected ray for the next round and pushes the refracted one on
//! the stack of its sample. When a branch ends, the sample pops its stack. So each tree is traced depth first,
//! reflection before refraction, as the recursive programs do. The additions to a pixel happen in the same order,
//! and the sum has the same bits whatever the other samples of the batch do. `max_rays` bounds the rays that one
//! tree may spawn.

use std::marker::PhantomData;

use turner_bvh::lanes::{LANES, dispatch};

use super::ClassicDesc;
use super::notes::TermNotes;
use super::points::{PointBlock, Surfaces, get, jitter_dimension, set};
use super::queue::{RayQueue, Waiting, resume};
use super::record::{Off, RayKind, Record};
use super::shade::{Accumulate, Ambient, Illuminate, Leave, LeavingBlock, TermBlock, illuminate_points};
use super::spawn::{SecondaryRay, Spawn};
use crate::color::Spectrum;
use crate::integrator::first_hits::FirstHits;
use crate::integrator::{AskedDetails, CameraSamples, Radiance, RayStats, SampleDetails, Tracer, footprint};
use crate::material::{Classic, Material, color_at};
use crate::math::{DVec2, DVec3, Ray, RayCone};
use crate::scene::{Hit, RayBatch, Scene, SpectrumBlock, SurfaceInteraction};
use crate::schema::ColorSource;
use crate::view::View;

/// A ray of a tree: its sample, its depth, and its weight in the pixel.
#[derive(Clone, Copy)]
pub(super) struct Task {
    pub(super) sample: u32,
    pub(super) depth: u32,
    pub(super) weight: f64,
    /// The ray cone, where textures are filtered; at a hit, the cone that arrives there. And the curvature of the
    /// surface at the hit, above 0 where it bulges towards the ray.
    pub(super) cone: RayCone,
    pub(super) curvature: f32,
}

impl Task {
    /// Advances the cone to the hit and stores the footprint in the surface.
    fn arrive(&mut self, scene: &Scene, surface: &mut SurfaceInteraction, direction: DVec3, t: f64) {
        footprint::arrive(&mut self.cone, surface, direction, t);
        let side = if direction.dot(surface.ng) <= 0.0 { 1.0 } else { -1.0 };
        self.curvature = (side * scene.curvature(&surface.hit)) as f32;
    }
}

/// The state of one sample's ray tree.
#[derive(Clone)]
pub(super) struct Tree {
    /// Number of rays spawned.
    pub(super) spawned: u32,
    /// Number of points shaded, which selects the random dimensions of area lights.
    shaded: u64,
    /// The top of the stack of rays still to be traced, an index into `TreeBatch::waiting`.
    pub(super) waiting: Option<u32>,
}

/// The state of a batch of samples. Its memory is reused from batch to batch.
pub(super) struct TreeBatch<'a, R = Off> {
    integrator: &'a ClassicDesc,
    scene: &'a Scene,
    view: &'a View,
    trees: Vec<Tree>,
    waiting: Vec<Waiting>,
    queue: RayQueue,
    next: RayQueue,
    hits: Vec<Option<Hit>>,
    first_hits: FirstHits,
    /// The hits of this round in the order of the queue; only the first `blocks` blocks are in use.
    points: Vec<PointBlock>,
    blocks: usize,
    shaded_hits: Vec<ShadedHit<'a>>,
    /// Physically based materials at the hits of this round, converted to classic ones.
    converted: Vec<Classic>,
    terms: Vec<TermBlock>,
    shadow_rays: RayBatch,
    through: Vec<SpectrumBlock>,
    leaving: Vec<LeavingBlock>,
    /// Records the sample, if the batch has only one.
    pub(super) record: R,
    /// Values for the recorder; empty without one.
    term_notes: Vec<TermNotes>,
}

/// A hit of this round: what is not in its [`PointBlock`].
struct ShadedHit<'a> {
    task: Task,
    /// A material of the scene, or an index into `TreeBatch::converted`.
    material: Result<&'a Classic, usize>,
    weights: Weights,
    refracted: Option<DVec3>,
}

impl<'a> ShadedHit<'a> {
    #[inline]
    fn material(&self, converted: &'a [Classic]) -> &'a Classic {
        self.material.unwrap_or_else(|i| &converted[i])
    }
}

/// Weights of the three terms at a hit.
#[derive(Clone, Copy)]
pub(super) struct Weights {
    pub(super) local: f64,
    pub(super) reflect: f64,
    pub(super) refract: f64,
}

impl<'a, R> TreeBatch<'a, R> {
    pub(super) fn new(
        integrator: &'a ClassicDesc,
        scene: &'a Scene,
        view: &'a View,
        record: R,
    ) -> TreeBatch<'a, R> {
        TreeBatch {
            integrator,
            scene,
            view,
            trees: Vec::new(),
            waiting: Vec::new(),
            queue: RayQueue::default(),
            next: RayQueue::default(),
            hits: Vec::new(),
            first_hits: FirstHits::default(),
            points: Vec::new(),
            blocks: 0,
            shaded_hits: Vec::new(),
            converted: Vec::new(),
            terms: Vec::new(),
            shadow_rays: RayBatch::default(),
            through: Vec::new(),
            leaving: Vec::new(),
            record,
            term_notes: Vec::new(),
        }
    }
}

impl<R: Record> Tracer for TreeBatch<'_, R> {
    fn ask(&mut self, asked: AskedDetails) {
        self.first_hits.turn_on(asked.hits);
    }

    fn details(&self) -> SampleDetails<'_> {
        SampleDetails { hits: self.first_hits.hits(), ..SampleDetails::default() }
    }

    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let count = samples.ids.len();
        stats.camera += count as u64;
        out.clear();
        out.resize(count, Radiance { color: Spectrum::BLACK, alpha: 1.0 });
        self.trees.clear();
        self.trees.resize(count, Tree { spawned: 0, shaded: 0, waiting: None });
        self.waiting.clear();
        self.first_hits.begin();
        self.queue.rays.copy(&samples.rays);
        self.queue.tasks.clear();
        self.queue.tasks.extend((0..count as u32).map(|sample| {
            let cone = footprint::of_camera(self.view, samples, sample as usize);
            Task { sample, depth: 0, weight: 1.0, cone, curvature: 0.0 }
        }));
        while !self.queue.tasks.is_empty() {
            self.round(samples, out, stats);
        }
        for tree in &self.trees {
            stats.dropped += u64::from(tree.spawned > self.integrator.max_rays);
        }
    }
}

impl<R: Record> TreeBatch<'_, R> {
    /// Traces and shades the rays of the queue and fills the next one.
    fn round(&mut self, samples: &CameraSamples, out: &mut [Radiance], stats: &mut RayStats) {
        self.scene.intersect_batch(&mut self.queue.rays, &mut self.hits);
        if !self.scene.hidden_from_camera.is_empty() {
            for (i, (hit, task)) in self.hits.iter_mut().zip(&self.queue.tasks).enumerate() {
                if let Some(ray) = self.queue.rays.get(i).filter(|_| task.depth == 0) {
                    *hit = self.scene.seen_by_camera(&ray, *hit);
                }
            }
        }
        self.first_hits.found(&self.hits);
        self.next.clear();
        self.gather(out);
        let facing = self.integrator.facing;
        dispatch(self.scene.instruction_set, Surfaces { points: &mut self.points[..self.blocks], facing });
        self.weigh();
        let ambient = self.integrator.ambient.then_some(self.scene.ambient);
        dispatch(self.scene.instruction_set, Ambient { points: &mut self.points[..self.blocks], ambient });
        let shaded = self.points[..self.blocks].first();
        self.record.note(|n| shaded.into_iter().for_each(|b| n.ambient(b)));
        self.lights(samples, stats);
        self.leave(samples, out, stats);
        std::mem::swap(&mut self.queue, &mut self.next);
    }

    /// Finishes the rays that hit nothing and gathers the hits of the others into blocks.
    fn gather(&mut self, out: &mut [Radiance]) {
        self.blocks = 0;
        self.shaded_hits.clear();
        self.converted.clear();
        for (i, hit) in self.hits.iter().enumerate() {
            let mut task = self.queue.tasks[i];
            let (depth, weight) = (task.depth, task.weight);
            let ray = || self.queue.rays.get(i);
            self.record.note(|n| ray().iter().for_each(|ray| n.traced(ray, depth, weight)));
            let Some(hit) = hit else {
                let tree = &mut self.trees[task.sample as usize];
                let direction = || get(&self.queue.rays.blocks()[i / LANES].direction, i % LANES);
                let pixel = &mut out[task.sample as usize];
                self.integrator.miss(self.scene, &task, direction, pixel, &mut self.record);
                resume(tree, &mut self.waiting, &mut self.next);
                continue;
            };
            self.record.note(|n| ray().iter().for_each(|ray| n.hit_surface(self.scene, ray, hit)));
            let lane = self.shaded_hits.len() % LANES;
            if lane == 0 {
                self.blocks += 1;
                if self.blocks > self.points.len() {
                    self.points.push(PointBlock::default());
                }
                self.points[self.blocks - 1].clear();
            }
            let b = &mut self.points[self.blocks - 1];
            let filtered = self.view.pixel_cone.is_some();
            let surface_of = |ray: &Ray, task: &mut Task| {
                let mut surface = self.scene.surface(ray, hit);
                if filtered {
                    task.arrive(self.scene, &mut surface, ray.direction, hit.shape.t);
                }
                surface
            };
            let (material, seen) = match self.scene.material_at(hit) {
                Material::Classic(material) => (Ok(material), None),
                // Materials are never prepared like this for the classic integrator.
                Material::OpenPbr(_) => continue,
                Material::Principled(physical, _) => {
                    let Some(ray) = self.queue.rays.get(i) else { continue };
                    let mut surface = surface_of(&ray, &mut task);
                    let (converted, emitted) = physical.as_classic(self.scene, &mut surface, ray.direction);
                    let emitted = emitted * task.weight as f32;
                    out[task.sample as usize].color += emitted;
                    self.record.note(|n| n.emitted(emitted));
                    self.converted.push(converted);
                    (Err(self.converted.len() - 1), Some(surface))
                }
                Material::Mix(mix) => {
                    let Some(ray) = self.queue.rays.get(i) else { continue };
                    let mut surface = surface_of(&ray, &mut task);
                    let (converted, emitted) = mix.as_classic(self.scene, &mut surface, ray.direction);
                    let emitted = emitted * task.weight as f32;
                    out[task.sample as usize].color += emitted;
                    self.record.note(|n| n.emitted(emitted));
                    self.converted.push(converted);
                    (Err(self.converted.len() - 1), Some(surface))
                }
            };
            let classic = material.unwrap_or_else(|i| &self.converted[i]);
            let rays = &self.queue.rays.blocks()[i / LANES];
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
            } else if let Some(ray) = self.queue.rays.get(i) {
                let mut surface = seen.unwrap_or_else(|| surface_of(&ray, &mut task));
                if let Some(bump) = classic.bump {
                    crate::material::apply_bump_map(self.scene, &mut surface, bump);
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
            self.shaded_hits.push(ShadedHit {
                task,
                material,
                weights: Weights { local: 0.0, reflect: 0.0, refract: 0.0 },
                refracted: None,
            });
        }
    }

    /// Splits each ray's weight into local colour, reflection and refraction.
    fn weigh(&mut self) {
        for (i, hit) in self.shaded_hits.iter_mut().enumerate() {
            let (b, lane) = (&mut self.points[i / LANES], i % LANES);
            (hit.weights, hit.refracted) =
                self.integrator.weights(hit.material(&self.converted), hit.task.depth, b, lane);
            b.weight.0[lane] = hit.task.weight * hit.weights.local;
            if hit.weights.local > 0.0 && (b.kd.0[lane] != 0.0 || b.ks.0[lane] != 0.0) {
                b.shaded |= 1 << lane;
            }
            if hit.weights.reflect > 0.0 {
                b.mirrors |= 1 << lane;
            }
            self.record.note(|n| {
                let (m, w) = (hit.material(&self.converted), hit.weights);
                let total = w.reflect > 0.0
                    && self.integrator.refraction
                    && m.k_refract > 0.0
                    && hit.refracted.is_none();
                n.shaded(b, m, [w.local, w.reflect, w.refract], total);
            });
        }
    }

    /// Adds one light after another to the local colours.
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
                        let sample = self.shaded_hits[at].task.sample as usize;
                        let dimension = jitter_dimension(self.trees[sample].shaded, number, i);
                        samples.ids[sample].unit_square(dimension)
                    };
                    illuminate_points(light, i, &self.points[..self.blocks], &mut self.terms, jitter);
                }
                self.shadow_rays.clear();
                if R::NOTES {
                    self.term_notes.clear();
                    self.term_notes.resize(self.blocks, TermNotes::default());
                }
                let reached = dispatch(
                    self.scene.instruction_set,
                    Illuminate::<'_, R> {
                        integrator: self.integrator,
                        points: &self.points[..self.blocks],
                        terms: &mut self.terms,
                        uniform,
                        finite: light.is_finite(),
                        shadow_rays: &mut self.shadow_rays,
                        notes: &mut self.term_notes,
                        recorder: PhantomData,
                    },
                );
                let notes = &mut self.term_notes;
                self.record.note(|n| notes.iter().for_each(|t| n.lit(number, i, light.is_finite(), t)));
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
                dispatch(
                    self.scene.instruction_set,
                    Accumulate::<'_, R> {
                        points: &mut self.points[..self.blocks],
                        terms: &self.terms,
                        intensity: uniform.map(|u| u.intensity()),
                        through,
                        shadow_factor: self.integrator.shadow_factor as f32,
                        notes,
                        recorder: PhantomData,
                    },
                );
                self.record.note(|n| {
                    let points = &self.points[..self.blocks];
                    for (b, terms) in points.iter().zip(&self.term_notes) {
                        n.arrived(self.scene, b, terms, &self.shadow_rays, through);
                    }
                });
            }
        }
        for (i, hit) in self.shaded_hits.iter().enumerate() {
            if self.points[i / LANES].shaded >> (i % LANES) & 1 == 1 {
                self.trees[hit.task.sample as usize].shaded += 1;
            }
        }
    }

    /// Adds the local colours to the pixels and spawns reflected and refracted rays.
    fn leave(&mut self, samples: &CameraSamples, out: &mut [Radiance], stats: &mut RayStats) {
        let leaving = &mut self.leaving;
        leaving.resize(self.blocks.max(leaving.len()), LeavingBlock::default());
        dispatch(
            self.scene.instruction_set,
            Leave { integrator: self.integrator, points: &self.points[..self.blocks], leaving },
        );
        for (i, hit) in self.shaded_hits.iter().enumerate() {
            let (b, leaving, lane) = (&self.points[i / LANES], &self.leaving[i / LANES], i % LANES);
            let sample = hit.task.sample as usize;
            let (tree, pixel) = (&mut self.trees[sample], &mut out[sample]);
            if hit.weights.local > 0.0 {
                pixel.color += leaving.color.get(lane);
                self.record.note(|n| n.added(leaving.color.get(lane)));
            }
            let length = samples.lengths[sample / LANES].0[sample % LANES];
            // The refracted ray is spawned first, but the reflected ray is traced first: the order of the
            // documents.
            let mut spawned = None;
            if let Some(direction) = hit.refracted
                && hit.weights.refract > 0.0
            {
                let secondary = SecondaryRay { kind: RayKind::Refracted, weight: hit.weights.refract };
                let spawn = Spawn { from: &hit.task, tree, pixel, record: &mut self.record };
                if let Some(mut task) = self.integrator.spawn(self.scene, secondary, || direction, spawn) {
                    stats.refracted += 1;
                    let ior = hit.material(&self.converted).ior;
                    let eta = if b.entering >> lane & 1 == 1 { ior } else { ior.recip() };
                    task.cone = hit.task.cone.refracted(eta, f64::from(hit.task.curvature));
                    let origin = if self.integrator.epsilon > 0.0 {
                        get(&b.p, lane)
                    } else {
                        b.leave(lane, direction)
                    };
                    spawned = Some((self.integrator.leaving_ray(origin, direction, length), task));
                }
            }
            if hit.weights.reflect > 0.0 {
                let direction = || get(&leaving.direction, lane);
                let secondary = SecondaryRay { kind: RayKind::Reflected, weight: hit.weights.reflect };
                let spawn = Spawn { from: &hit.task, tree, pixel, record: &mut self.record };
                if let Some(mut task) = self.integrator.spawn(self.scene, secondary, direction, spawn) {
                    stats.reflected += 1;
                    task.cone = hit.task.cone.reflected(f64::from(hit.task.curvature));
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
