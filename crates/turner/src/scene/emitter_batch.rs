//! Light samples for a batch of points. Each result equals that of [`Emitters::sample`] bit by bit, but rectangles,
//! spheres and triangles are sampled eight points at a time, and environment look-ups of all points run in one loop, where
//! cache misses overlap.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::LANES;

use crate::color::Spectrum;
use crate::light::emission::{EmitterBlock, EmitterSample, RectangleEmitter, SphereEmitter, TriangleBlock};
use crate::light::{AdaptiveEnvironment, BY_COSINE, ChosenLight, EnvironmentBatch, Light, NO_CELL, Receiver};
use crate::math::DVec3;
use crate::sampler::OwenSobol;
use crate::scene::Scene;
use crate::scene::emitters::{Chosen, Emitter, Emitters, FirstChoice};
use crate::scene::light_sample::LightSample;
use crate::scene::shape_emitters::{BlockShape, OneTriangle, ShapeEmitter};

/// Requests for light samples, and the results.
#[derive(Default)]
pub struct LightBatch {
    requests: Vec<(Receiver, [f64; 3])>,
    samples: Vec<Option<LightSample>>,
    /// Requests whose random numbers are not drawn yet, with their samples of a pixel and sets; and those numbers.
    undrawn: Vec<u32>,
    numbers_of: Vec<(OwenSobol, u32)>,
    numbers: Vec<[f64; 3]>,
    in_tree: Vec<InTree>,
    found: Vec<Option<ChosenLight>>,
    /// Requests for one environment: index of the request, and probability of the choice.
    environment_requests: Vec<(u32, f64)>,
    environment_u: Vec<[f64; 2]>,
    /// The same for requests in cells of an adaptive environment, with the cell.
    adaptive_requests: Vec<(u32, f64)>,
    adaptive_u: Vec<(u32, [f64; 2])>,
    scratch: EnvironmentBatch,
}

/// A request that the light tree chooses for.
#[derive(Clone, Copy)]
struct InTree {
    request: u32,
    /// Whether the receiver is that of the request before.
    again: bool,
    /// The probability of the tree, and the random number of its choice.
    choice: f64,
    left: f64,
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
    /// Whether nobody asks for the pdfs.
    radiance_alone: bool,
    scratch: EnvironmentBatch,
}

impl EscapedRays {
    /// Removes all directions. With `radiance_alone`, [`EscapedRays::get`] gives the radiance of the next ones, and a pdf
    /// that must not be used.
    pub fn clear(&mut self, radiance_alone: bool) {
        self.radiance_alone = radiance_alone;
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

    /// Requests a light sample at a point, with `u` as in [`Emitters::sample`]. Returns its index.
    #[inline]
    pub fn ask(&mut self, at: Receiver, u: [f64; 3]) -> usize {
        self.requests.push((at, u));
        self.requests.len() - 1
    }

    /// Requests a light sample for each candidate, and returns the index of the first. Their random numbers are drawn later,
    /// with those of all requests: for each candidate a part of the sample `sampler` in dimension set `set`.
    #[inline]
    pub fn ask_for_candidates(&mut self, at: Receiver, sampler: &OwenSobol, set: u32) -> usize {
        let first = self.requests.len();
        for candidate in 0..=at.extra_candidates {
            self.undrawn.push(self.requests.len() as u32);
            self.numbers_of.push((sampler.part(candidate, at.extra_candidates + 1), set));
            self.requests.push((at, [0.0; 3]));
        }
        first
    }

    /// Draws the random numbers of candidates.
    fn draw_numbers(&mut self, set: InstructionSet) {
        if self.undrawn.is_empty() {
            return;
        }
        OwenSobol::first_three(set, &self.numbers_of, &mut self.numbers);
        for (request, u) in self.undrawn.iter().zip(&self.numbers) {
            self.requests[*request as usize].1 = *u;
        }
        self.undrawn.clear();
        self.numbers_of.clear();
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
    part: u32,
    /// The probability of the part once the emitter is chosen, and that of the emitter.
    part_choice: f64,
    choice: f64,
}

impl Waiting<'_> {
    #[inline]
    fn finish(&self, scene: &Scene, block: &EmitterBlock, lane: usize) -> Option<LightSample> {
        let s = block.get(lane)?;
        let s = EmitterSample { pdf: s.pdf * self.part_choice, ..s };
        let light = self.emitter.emit(scene, block.lit(lane), s, self.part)?;
        Some(light.chosen(self.choice))
    }
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
            let Some(waiting) = waiting else { continue };
            samples[waiting.index] = waiting.finish(scene, &self.block, lane);
        }
        (self.len, self.shapes, self.waiting) = (0, [None; LANES], [None; LANES]);
    }
}

/// The same for triangles of meshes.
struct TriangleQueue<'a> {
    len: usize,
    waiting: [Option<Waiting<'a>>; LANES],
    block: TriangleBlock,
}

impl<'a> TriangleQueue<'a> {
    fn new() -> TriangleQueue<'a> {
        TriangleQueue { len: 0, waiting: [None; LANES], block: TriangleBlock::default() }
    }

    /// Adds a request; true when there are eight.
    #[inline]
    fn push(&mut self, one: &OneTriangle, waiting: Waiting<'a>, p: DVec3, u: [f64; 2]) -> bool {
        let lane = self.len % LANES;
        let waiting = Waiting { part: one.part, part_choice: one.probability, ..waiting };
        self.waiting[lane] = Some(waiting);
        self.block.ask(lane, one.corners, one.side, p, u);
        self.len += 1;
        self.len == LANES
    }

    /// Computes the waiting samples.
    fn flush(&mut self, scene: &Scene, samples: &mut [Option<LightSample>]) {
        if self.len == 0 {
            return;
        }
        self.block.sample(scene.instruction_set);
        for (lane, waiting) in self.waiting.iter().enumerate() {
            let Some(waiting) = waiting else { continue };
            samples[waiting.index] = waiting.finish(scene, self.block.block(), lane);
        }
        (self.len, self.waiting) = (0, [None; LANES]);
    }
}

/// Requests whose emitter is chosen, by type of emitter.
struct Sorted<'a> {
    scene: &'a Scene,
    adaptive: Option<&'a AdaptiveEnvironment>,
    samples: &'a mut [Option<LightSample>],
    rectangles: Queue<'a, RectangleEmitter>,
    spheres: Queue<'a, SphereEmitter>,
    triangles: TriangleQueue<'a>,
    /// With several environments, only the first is sampled in a batch.
    environment: Option<u32>,
    environment_requests: &'a mut Vec<(u32, f64)>,
    environment_u: &'a mut Vec<[f64; 2]>,
    adaptive_requests: &'a mut Vec<(u32, f64)>,
    adaptive_u: &'a mut Vec<(u32, [f64; 2])>,
}

impl<'a> Sorted<'a> {
    /// Adds a request, or computes its sample.
    #[inline]
    fn add(&mut self, index: usize, (at, u): &(Receiver, [f64; 3]), chosen: Chosen<'a>) {
        let chosen = Chosen { choice: chosen.choice * at.candidates(), ..chosen };
        let Chosen { emitter, choice, part, left } = chosen;
        let (p, u) = (at.p, [u[0], u[1]]);
        match emitter {
            Emitter::Light(i)
                if at.cell != NO_CELL && self.adaptive.is_some_and(|adaptive| adaptive.light() == *i) =>
            {
                self.adaptive_requests.push((index as u32, choice));
                self.adaptive_u.push((at.cell, u));
            }
            Emitter::Light(i)
                if at.cell != BY_COSINE
                    && matches!(self.scene.lights.get(*i as usize), Some(Light::Environment(_)))
                    && *self.environment.get_or_insert(*i) == *i =>
            {
                self.environment_requests.push((index as u32, choice));
                self.environment_u.push(u);
            }
            Emitter::Shape(shape) => {
                let waiting = Waiting { index, emitter: shape, part: shape.part(), part_choice: 1.0, choice };
                match shape.block_shape(self.scene, part, left) {
                    Some(BlockShape::Rectangle(form)) => {
                        if self.rectangles.push(form, waiting, p, u) {
                            self.flush_rectangles();
                        }
                    }
                    Some(BlockShape::Sphere(form)) => {
                        if self.spheres.push(form, waiting, p, u) {
                            self.flush_spheres();
                        }
                    }
                    Some(BlockShape::Triangle(one)) => {
                        if self.triangles.push(&one, waiting, p, u) {
                            self.triangles.flush(self.scene, self.samples);
                        }
                    }
                    None => self.samples[index] = chosen.sample(self.scene, at, u),
                }
            }
            Emitter::Light(_) => self.samples[index] = chosen.sample(self.scene, at, u),
        }
    }

    fn flush_rectangles(&mut self) {
        self.rectangles.flush(self.scene, RectangleEmitter::sample_block, self.samples);
    }

    fn flush_spheres(&mut self) {
        self.spheres.flush(self.scene, SphereEmitter::sample_block, self.samples);
    }

    /// Computes the samples of all requests that wait, except those of environments.
    fn flush(&mut self) {
        self.flush_rectangles();
        self.flush_spheres();
        self.triangles.flush(self.scene, self.samples);
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
        batch.draw_numbers(scene.instruction_set);
        let LightBatch { requests, samples, environment_requests, environment_u, scratch, .. } = batch;
        let (adaptive_requests, adaptive_u) = (&mut batch.adaptive_requests, &mut batch.adaptive_u);
        samples.clear();
        samples.resize(requests.len(), None);
        if self.is_empty() || requests.is_empty() {
            return;
        }
        environment_requests.clear();
        environment_u.clear();
        adaptive_requests.clear();
        adaptive_u.clear();
        let mut sorted = Sorted {
            scene,
            adaptive,
            samples,
            rectangles: Queue::new(),
            spheres: Queue::new(),
            triangles: TriangleQueue::new(),
            environment: None,
            environment_requests,
            environment_u,
            adaptive_requests,
            adaptive_u,
        };
        let (in_tree, found) = (&mut batch.in_tree, &mut batch.found);
        in_tree.clear();
        found.clear();
        let (mut tree, mut of_receiver, mut remaining) = (None, 0, 0);
        for (index, request) in requests.iter().enumerate() {
            if remaining == 0 {
                (of_receiver, remaining) = (index as u32, request.0.extra_candidates);
            } else {
                remaining -= 1;
            }
            match self.first_choice(request.1[2]) {
                FirstChoice::Emitter(chosen) => sorted.add(index, request, chosen),
                FirstChoice::Tree { placed, choice, left } => {
                    tree = Some(placed);
                    let again = in_tree.last().is_some_and(|last: &InTree| last.request >= of_receiver);
                    in_tree.push(InTree { request: index as u32, again, choice, left });
                }
            }
        }
        if let Some(placed) = tree {
            let asked = in_tree.iter().map(|r| (&requests[r.request as usize].0, r.again, r.left));
            placed.tree().sample_batch(scene.instruction_set, asked, |chosen| found.push(chosen));
            for (asked, chosen) in in_tree.iter().zip(found.iter()) {
                if let Some(chosen) = self.chosen_in_tree(placed, asked.choice, *chosen) {
                    let index = asked.request as usize;
                    sorted.add(index, &requests[index], chosen);
                }
            }
        }
        sorted.flush();
        let environment = sorted.environment;
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
        let EscapedRays { directions, cells, found, lights, radiance_alone, scratch } = batch;
        *lights = self.infinite_ids().len();
        found.clear();
        found.resize(directions.len() * *lights, None);
        for (at, &id) in self.infinite_ids().iter().enumerate() {
            match scene.lights.get(id as usize) {
                Some(Light::Environment(light)) => {
                    let choice = self.choice_of(id);
                    if let Some(radiance) = light.uniform().filter(|_| *radiance_alone) {
                        (0..directions.len()).for_each(|i| found[i * *lights + at] = Some((radiance, 0.0)));
                        continue;
                    }
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
