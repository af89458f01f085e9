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
use super::points::{PointBlock, Surfaces, get, jitter_dimension};
use super::queue::{RayQueue, Waiting, resume};
use super::record::{Off, RayKind, Record};
use super::shade::{Accumulate, Ambient, Illuminate, Leave, LeavingBlock, TermBlock, illuminate_points};
use super::spawn::{SecondaryRay, Spawn};
use crate::color::Spectrum;
use crate::integrator::first_hits::FirstHits;
use crate::integrator::{AskedDetails, CameraSamples, Radiance, RayStats, SampleDetails, Tracer, footprint};
use crate::material::Classic;
use crate::math::{DVec2, DVec3, RayCone};
use crate::scene::{Hit, RayBatch, Scene, SpectrumBlock, SurfaceInteraction};
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
    pub(super) fn arrive(
        &mut self,
        scene: &Scene,
        surface: &mut SurfaceInteraction,
        direction: DVec3,
        t: f64,
    ) {
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
    pub(super) integrator: &'a ClassicDesc,
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    pub(super) trees: Vec<Tree>,
    pub(super) waiting: Vec<Waiting>,
    pub(super) queue: RayQueue,
    pub(super) next: RayQueue,
    pub(super) hits: Vec<Option<Hit>>,
    pub(super) first_hits: FirstHits,
    /// The hits of this round; only the first `blocks` blocks are in use.
    pub(super) points: Vec<PointBlock>,
    pub(super) blocks: usize,
    pub(super) shaded_hits: Vec<ShadedHit<'a>>,
    /// The indices of the hits in `shaded_hits`: lane i of block b has the index 8 b + i. A block may have unused lanes.
    pub(super) slots: Vec<u32>,
    /// The block that takes single hits, and how many it has.
    pub(super) open: (usize, usize),
    /// The colour of the background where it is one, and all that a ray sees that hits nothing.
    pub(super) plain_miss: Option<Spectrum>,
    /// Physically based materials at the hits of this round, converted to classic ones.
    pub(super) converted: Vec<Classic>,
    pub(super) terms: Vec<TermBlock>,
    pub(super) shadow_rays: RayBatch,
    pub(super) through: Vec<SpectrumBlock>,
    pub(super) leaving: Vec<LeavingBlock>,
    /// Records the sample, if the batch has only one.
    pub(super) record: R,
    /// Values for the recorder; empty without one.
    pub(super) term_notes: Vec<TermNotes>,
}

/// A hit of this round: what is not in its [`PointBlock`].
#[derive(Clone, Copy)]
pub(super) struct ShadedHit<'a> {
    pub(super) task: Task,
    /// A material of the scene, or an index into `TreeBatch::converted`.
    pub(super) material: Result<&'a Classic, usize>,
    pub(super) weights: Weights,
    pub(super) refracted: Option<DVec3>,
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
            slots: Vec::new(),
            open: (0, 0),
            plain_miss: integrator.plain_miss(scene),
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

    /// Splits each ray's weight into local colour, reflection and refraction.
    fn weigh(&mut self) {
        for i in self.slots.iter().map(|slot| *slot as usize) {
            let hit = &mut self.shaded_hits[i];
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
        for i in self.slots.iter().map(|slot| *slot as usize) {
            let hit = &self.shaded_hits[i];
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
        for i in self.slots.iter().map(|slot| *slot as usize) {
            let hit = &self.shaded_hits[i];
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
