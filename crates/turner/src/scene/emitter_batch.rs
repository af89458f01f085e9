//! Light samples for a batch of points. Each result equals that of [`Emitters::sample`] bit by bit, but rectangles
//! and spheres are sampled eight points at a time, and environment look-ups of all points run in one loop, where
//! cache misses overlap.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::LANES;

use crate::color::Spectrum;
use crate::light::emission::{EmitterBlock, RectangleEmitter, SphereEmitter};
use crate::light::{AdaptiveEnvironment, EnvironmentBatch, Light, NO_CELL, Receiver};
use crate::math::DVec3;
use crate::scene::Scene;
use crate::scene::emitters::{Emitter, Emitters, LightSample};
use crate::scene::shape_emitters::{BlockShape, ShapeEmitter};

/// Requests for light samples, and the results.
#[derive(Default)]
pub struct LightBatch {
    requests: Vec<(Receiver, [f64; 3])>,
    samples: Vec<Option<LightSample>>,
    /// Requests for one environment: index of the request, and probability of the choice.
    environment_requests: Vec<(u32, f64)>,
    environment_u: Vec<[f64; 2]>,
    /// The same for requests in cells of an adaptive environment, with the cell.
    adaptive_requests: Vec<(u32, f64)>,
    adaptive_u: Vec<(u32, [f64; 2])>,
    scratch: EnvironmentBatch,
}

/// Directions of rays that leave the scene, and the infinite lights that they hit.
#[derive(Default)]
pub struct EscapedRays {
    directions: Vec<DVec3>,
    /// The cells of an adaptive environment that the rays come from.
    cells: Vec<u32>,
    found: Vec<Option<(Spectrum, f64)>>,
    /// Number of infinite lights.
    lights: usize,
    scratch: EnvironmentBatch,
}

impl EscapedRays {
    /// Removes all directions.
    pub fn clear(&mut self) {
        self.directions.clear();
        self.cells.clear();
        self.found.clear();
    }

    /// Adds a unit direction, and the cell of the receiver it was sampled at. Indices start at 0.
    #[inline]
    pub fn push(&mut self, direction: DVec3, cell: u32) {
        self.directions.push(direction);
        self.cells.push(cell);
    }

    /// The infinite lights in a direction, by the direction's index: for each its index among them, its radiance, and
    /// the pdf with which light sampling gives the direction.
    #[inline]
    pub fn get(&self, index: usize) -> impl Iterator<Item = (usize, Spectrum, f64)> {
        let found = self.found.get(index * self.lights..(index + 1) * self.lights);
        let found = found.unwrap_or_default().iter().enumerate();
        found.filter_map(|(place, found)| found.map(|(radiance, pdf)| (place, radiance, pdf)))
    }
}

impl LightBatch {
    /// Removes all requests.
    pub fn clear(&mut self) {
        self.requests.clear();
        self.samples.clear();
    }

    /// Requests light at a point, with `u` as in [`Emitters::sample`]: one sample for each candidate, each with its
    /// own `u`. Returns the index of the first.
    #[inline]
    pub fn ask(&mut self, at: impl Into<Receiver>, u: impl Fn(u32) -> [f64; 3]) -> usize {
        let (at, first) = (at.into(), self.requests.len());
        for index in 0..=at.extra_candidates {
            self.requests.push((at, u(index)));
        }
        first
    }

    /// Number of samples requested.
    pub fn len(&self) -> usize {
        self.requests.len()
    }

    /// Whether nothing was requested.
    pub fn is_empty(&self) -> bool {
        self.requests.is_empty()
    }

    /// The samples of the request with this index; their pdfs include the number of candidates.
    #[inline]
    pub fn get(&self, index: usize) -> &[Option<LightSample>] {
        let Some((at, _)) = self.requests.get(index) else { return &[] };
        self.samples.get(index..index + at.extra_candidates as usize + 1).unwrap_or_default()
    }
}

/// Requests for emitters of one type that wait until there are eight.
struct Queue<'a, E> {
    len: usize,
    shapes: [Option<&'a E>; LANES],
    waiting: [Option<Waiting<'a>>; LANES],
    block: EmitterBlock,
}

#[derive(Clone, Copy)]
struct Waiting<'a> {
    index: usize,
    emitter: &'a ShapeEmitter,
    choice: f64,
}

impl<'a, E> Queue<'a, E> {
    fn new() -> Queue<'a, E> {
        Queue { len: 0, shapes: [None; LANES], waiting: [None; LANES], block: EmitterBlock::default() }
    }

    /// Adds a request; true when there are eight.
    #[inline]
    fn push(&mut self, form: &'a E, waiting: Waiting<'a>, p: DVec3, u: [f64; 2]) -> bool {
        let lane = self.len % LANES;
        self.shapes[lane] = Some(form);
        self.waiting[lane] = Some(waiting);
        self.block.ask(lane, p, u);
        self.len += 1;
        self.len == LANES
    }

    /// Computes the waiting samples.
    fn flush(
        &mut self,
        scene: &Scene,
        sample: impl Fn(InstructionSet, [&E; LANES], &mut EmitterBlock),
        samples: &mut [Option<LightSample>],
    ) {
        let [Some(first), ..] = self.shapes else { return };
        sample(scene.instruction_set, self.shapes.map(|form| form.unwrap_or(first)), &mut self.block);
        for (lane, waiting) in self.waiting.iter().enumerate() {
            let Some(Waiting { index, emitter, choice }) = waiting else { continue };
            samples[*index] = self.block.get(lane).and_then(|s| {
                let light = emitter.emit(scene, self.block.lit(lane), s, emitter.part())?;
                Some(LightSample { pdf: light.pdf * choice, ..light })
            });
        }
        (self.len, self.shapes, self.waiting) = (0, [None; LANES], [None; LANES]);
    }
}

impl Emitters {
    /// Computes all requested samples. `adaptive` is sampled by requests that have a cell.
    pub fn sample_batch(
        &self,
        scene: &Scene,
        adaptive: Option<&AdaptiveEnvironment>,
        batch: &mut LightBatch,
    ) {
        let LightBatch { requests, samples, environment_requests, environment_u, scratch, .. } = batch;
        let (adaptive_requests, adaptive_u) = (&mut batch.adaptive_requests, &mut batch.adaptive_u);
        samples.clear();
        samples.resize(requests.len(), None);
        if self.is_empty() || requests.is_empty() {
            return;
        }
        let mut rectangles: Queue<'_, RectangleEmitter> = Queue::new();
        let mut spheres: Queue<'_, SphereEmitter> = Queue::new();
        // With several environments, only the first is sampled in a batch.
        let mut environment = None;
        environment_requests.clear();
        environment_u.clear();
        adaptive_requests.clear();
        adaptive_u.clear();
        let (mut root, mut remaining) = (None, 0);
        for (index, (at, u)) in requests.iter().enumerate() {
            if remaining == 0 {
                root = None;
            }
            remaining = if remaining == 0 { at.extra_candidates } else { remaining - 1 };
            let Some(mut chosen) = self.choose(at, u[2], &mut root) else { continue };
            chosen.choice *= at.candidates();
            let (p, emitter, choice) = (at.p, chosen.emitter, chosen.choice);
            if at.cell != NO_CELL
                && let Emitter::Light(i) = emitter
                && adaptive.is_some_and(|adaptive| adaptive.light() == *i)
            {
                adaptive_requests.push((index as u32, choice));
                adaptive_u.push((at.cell, [u[0], u[1]]));
            } else if let Emitter::Light(i) = emitter
                && matches!(scene.lights.get(*i as usize), Some(Light::Environment(_)))
                && *environment.get_or_insert(*i) == *i
            {
                environment_requests.push((index as u32, choice));
                environment_u.push([u[0], u[1]]);
            } else if let Emitter::Shape(shape) = emitter
                && let Some(form) = shape.block_shape()
            {
                let waiting = Waiting { index, emitter: shape, choice };
                match form {
                    BlockShape::Rectangle(form) => {
                        if rectangles.push(form, waiting, p, [u[0], u[1]]) {
                            rectangles.flush(scene, RectangleEmitter::sample_block, samples);
                        }
                    }
                    BlockShape::Sphere(form) => {
                        if spheres.push(form, waiting, p, [u[0], u[1]]) {
                            spheres.flush(scene, SphereEmitter::sample_block, samples);
                        }
                    }
                }
            } else {
                samples[index] = chosen.sample(scene, at, [u[0], u[1]]);
            }
        }
        rectangles.flush(scene, RectangleEmitter::sample_block, samples);
        spheres.flush(scene, SphereEmitter::sample_block, samples);
        if let Some(i) = environment
            && let Some(Light::Environment(light)) = scene.lights.get(i as usize)
        {
            let source = i;
            light.sample_batch(scene.instruction_set, environment_u, scratch, |i, sample| {
                let (index, choice) = environment_requests[i];
                samples[index as usize] =
                    sample.map(|s| LightSample::of_environment(s, source).chosen(choice));
            });
        }
        if let Some(adaptive) = adaptive {
            let source = adaptive.light();
            adaptive.sample_batch(scene.instruction_set, adaptive_u, scratch, |i, sample| {
                let (index, choice) = adaptive_requests[i];
                samples[index as usize] =
                    sample.map(|s| LightSample::of_environment(s, source).chosen(choice));
            });
        }
    }

    /// Evaluates the infinite lights in all directions. With `adaptive`, the densities of that light hold for the cells
    /// of the rays.
    pub fn escaped_batch(
        &self,
        scene: &Scene,
        adaptive: Option<&AdaptiveEnvironment>,
        batch: &mut EscapedRays,
    ) {
        let EscapedRays { directions, cells, found, lights, scratch } = batch;
        *lights = self.infinite_ids().len();
        found.clear();
        found.resize(directions.len() * *lights, None);
        for (at, &id) in self.infinite_ids().iter().enumerate() {
            match scene.lights.get(id as usize) {
                Some(Light::Environment(light)) => {
                    let choice = self.choice_of(id);
                    if let Some(adaptive) = adaptive.filter(|adaptive| adaptive.light() == id) {
                        let mut take = |i: usize, (radiance, pdf)| {
                            found[i * *lights + at] = Some((radiance, choice * pdf));
                        };
                        adaptive.found_batch(scene.instruction_set, cells, directions, scratch, &mut take);
                        continue;
                    }
                    light.found_batch(scene.instruction_set, directions, scratch, |i, (radiance, pdf)| {
                        found[i * *lights + at] = Some((radiance, choice * pdf));
                    });
                }
                _ => {
                    for (i, d) in directions.iter().enumerate() {
                        found[i * *lights + at] = self.infinite_one(scene, id, *d);
                    }
                }
            }
        }
    }
}
