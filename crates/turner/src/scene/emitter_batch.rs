//! Light at many points at once: what it comes to is that of [`Emitters::sample`], point by point, but rectangles and spheres are
//! sampled eight points at a time, and what is read of an environment is read together.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::LANES;

use crate::color::Spectrum;
use crate::light::emission::{EmitterBlock, RectangleEmitter, SphereEmitter};
use crate::light::{EnvironmentBatch, Light, Receiver};
use crate::math::DVec3;
use crate::scene::Scene;
use crate::scene::emitters::{Emitter, Emitters, LightSample};
use crate::scene::shape_emitters::{Blocked, ShapeEmitter};

/// Points that ask for light, and what they get.
#[derive(Default)]
pub struct LightBatch {
    asked: Vec<(Receiver, [f64; 3])>,
    lit: Vec<Option<LightSample>>,
    /// Of one environment: who asked, and by which numbers.
    around: Vec<(u32, f64)>,
    places: Vec<[f64; 2]>,
    room: EnvironmentBatch,
}

/// Directions in which rays leave the scene, and what is found there.
#[derive(Default)]
pub struct EscapedRays {
    directions: Vec<DVec3>,
    found: Vec<Option<(Spectrum, f64)>>,
    /// How many lights are there.
    lights: usize,
    room: EnvironmentBatch,
}

impl EscapedRays {
    /// Takes all directions out.
    pub fn clear(&mut self) {
        self.directions.clear();
        self.found.clear();
    }

    /// Adds a unit direction. The first has number 0.
    #[inline]
    pub fn push(&mut self, direction: DVec3) {
        self.directions.push(direction);
    }

    /// Of each light around the scene that is in the direction of this number its place among them, the radiance and the density with which sampling gives
    /// the direction.
    #[inline]
    pub fn get(&self, number: usize) -> impl Iterator<Item = (usize, Spectrum, f64)> {
        let found = self.found.get(number * self.lights..(number + 1) * self.lights);
        let found = found.unwrap_or_default().iter().enumerate();
        found.filter_map(|(place, found)| found.map(|(radiance, pdf)| (place, radiance, pdf)))
    }
}

impl LightBatch {
    /// Takes all points out.
    pub fn clear(&mut self) {
        self.asked.clear();
        self.lit.clear();
    }

    /// Asks for light at a point, by `u` as [`Emitters::sample`] takes it: for as many as are looked at there, each by its own. Gives the number of
    /// the first of them.
    #[inline]
    pub fn ask(&mut self, at: impl Into<Receiver>, u: impl Fn(u32) -> [f64; 3]) -> usize {
        let (at, first) = (at.into(), self.asked.len());
        for number in 0..=at.extra_candidates {
            self.asked.push((at, u(number)));
        }
        first
    }

    /// How many lights were asked for.
    pub fn len(&self) -> usize {
        self.asked.len()
    }

    /// Whether none has.
    pub fn is_empty(&self) -> bool {
        self.asked.is_empty()
    }

    /// What those got who asked under this number; the densities count all of them.
    #[inline]
    pub fn get(&self, number: usize) -> &[Option<LightSample>] {
        let Some((at, _)) = self.asked.get(number) else { return &[] };
        self.lit.get(number..number + at.extra_candidates as usize + 1).unwrap_or_default()
    }
}

/// Points that wait until there are eight for emitters of one form.
struct Queue<'a, E> {
    len: usize,
    forms: [Option<&'a E>; LANES],
    waiting: [Option<Waiting<'a>>; LANES],
    block: EmitterBlock,
}

#[derive(Clone, Copy)]
struct Waiting<'a> {
    number: usize,
    emitter: &'a ShapeEmitter,
    choice: f64,
}

impl<'a, E> Queue<'a, E> {
    fn new() -> Queue<'a, E> {
        Queue { len: 0, forms: [None; LANES], waiting: [None; LANES], block: EmitterBlock::default() }
    }

    /// Adds a point; says whether there are eight.
    #[inline]
    fn push(&mut self, form: &'a E, waiting: Waiting<'a>, p: DVec3, u: [f64; 2]) -> bool {
        let lane = self.len % LANES;
        self.forms[lane] = Some(form);
        self.waiting[lane] = Some(waiting);
        self.block.ask(lane, p, u);
        self.len += 1;
        self.len == LANES
    }

    /// Answers those that wait.
    fn flush(
        &mut self,
        scene: &Scene,
        sample: impl Fn(InstructionSet, [&E; LANES], &mut EmitterBlock),
        lit: &mut [Option<LightSample>],
    ) {
        let [Some(first), ..] = self.forms else { return };
        sample(scene.instruction_set, self.forms.map(|form| form.unwrap_or(first)), &mut self.block);
        for (lane, waiting) in self.waiting.iter().enumerate() {
            let Some(Waiting { number, emitter, choice }) = waiting else { continue };
            lit[*number] = self.block.get(lane).and_then(|s| {
                let lit = emitter.shine(scene, self.block.lit(lane), s, emitter.part())?;
                Some(LightSample { pdf: lit.pdf * choice, ..lit })
            });
        }
        (self.len, self.forms, self.waiting) = (0, [None; LANES], [None; LANES]);
    }
}

impl Emitters {
    /// Answers all that have asked.
    pub fn sample_batch(&self, scene: &Scene, batch: &mut LightBatch) {
        let LightBatch { asked, lit, around, places, room } = batch;
        lit.clear();
        lit.resize(asked.len(), None);
        if self.is_empty() || asked.is_empty() {
            return;
        }
        let mut rectangles: Queue<'_, RectangleEmitter> = Queue::new();
        let mut spheres: Queue<'_, SphereEmitter> = Queue::new();
        // Of several environments all but the first are sampled one by one.
        let mut environment = None;
        around.clear();
        places.clear();
        let (mut root, mut again) = (None, 0);
        for (number, (at, u)) in asked.iter().enumerate() {
            if again == 0 {
                root = None;
            }
            again = if again == 0 { at.extra_candidates } else { again - 1 };
            let Some(mut chosen) = self.choose(at, u[2], &mut root) else { continue };
            chosen.choice *= at.candidates();
            let (p, emitter, choice) = (at.p, chosen.emitter, chosen.choice);
            if let Emitter::Light(i) = emitter
                && matches!(scene.lights.get(*i as usize), Some(Light::Environment(_)))
                && *environment.get_or_insert(*i) == *i
            {
                around.push((number as u32, choice));
                places.push([u[0], u[1]]);
            } else if let Emitter::Shape(shape) = emitter
                && let Some(form) = shape.blocked()
            {
                let waiting = Waiting { number, emitter: shape, choice };
                match form {
                    Blocked::Rectangle(form) => {
                        if rectangles.push(form, waiting, p, [u[0], u[1]]) {
                            rectangles.flush(scene, RectangleEmitter::sample_block, lit);
                        }
                    }
                    Blocked::Sphere(form) => {
                        if spheres.push(form, waiting, p, [u[0], u[1]]) {
                            spheres.flush(scene, SphereEmitter::sample_block, lit);
                        }
                    }
                }
            } else {
                lit[number] = chosen.sample(scene, p, [u[0], u[1]]);
            }
        }
        rectangles.flush(scene, RectangleEmitter::sample_block, lit);
        spheres.flush(scene, SphereEmitter::sample_block, lit);
        if let Some(i) = environment
            && let Some(Light::Environment(light)) = scene.lights.get(i as usize)
        {
            let source = i;
            light.sample_batch(scene.instruction_set, places, room, |i, sample| {
                let (number, choice) = around[i];
                lit[number as usize] = sample.map(|s| {
                    let lit = LightSample::of_environment(s, source);
                    LightSample { pdf: lit.pdf * choice, ..lit }
                });
            });
        }
    }

    /// Looks up what is around the scene in all directions: as for one direction.
    pub fn escaped_batch(&self, scene: &Scene, batch: &mut EscapedRays) {
        let EscapedRays { directions, found, lights, room } = batch;
        *lights = self.around_ids().len();
        found.clear();
        found.resize(directions.len() * *lights, None);
        for (at, &id) in self.around_ids().iter().enumerate() {
            match scene.lights.get(id as usize) {
                Some(Light::Environment(light)) => {
                    let choice = self.choice_of(id);
                    light.found_batch(scene.instruction_set, directions, room, |i, (radiance, pdf)| {
                        found[i * *lights + at] = Some((radiance, choice * pdf));
                    });
                }
                _ => {
                    for (i, d) in directions.iter().enumerate() {
                        found[i * *lights + at] = self.around_one(scene, id, *d);
                    }
                }
            }
        }
    }
}
