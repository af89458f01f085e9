//! The choice of a light for next-event estimation, among lights and emissive shapes.
//!
//! At each vertex of a path one emitter is chosen with a known probability, and a direction to it is sampled. The pdf
//! of the direction is the product of both probabilities:
//!
//! ```text
//!   without a light tree                     with a light tree
//!   alias table over all emitters            alias table over infinite lights, lights without
//!   P = ½ · power / Σ power + ½ · 1/n         inverse-square falloff, and the tree as one entry
//!          |                                        |                       |
//!       emitter                                  emitter         light tree (by position, normal
//!                                                                and lobe of the receiver) → emitter
//!   pdf(ω) = P(emitter) · pdf(ω | emitter)
//! ```
//!
//! The uniform half keeps every P above 0, so the estimator is unbiased even where the estimate of the power is wrong.
//! For MIS, [`Emitters::pdf_hit`] gives the pdf with which light sampling finds a BSDF-sampled hit. It must use the
//! same [`Receiver`] as the light sample; a path keeps the receiver of its last vertex. `shape_emitters` samples
//! shapes, `placed_emitters` has the tree. Shapes that cannot be sampled (unbounded or moving) are found by BSDF
//! sampling only, which is unbiased but noisier.
//!
//! Not kept: a choice among suns, skies and the tree by the irradiance of each on the receiver's side (for skies in
//! spherical harmonics). The variance is the same in S4 and 3 % lower in a room with a window and lights, for 6 to 30 %
//! more time.

use crate::color::Spectrum;
use crate::light::{AdaptiveEnvironment, ChosenLight, Light, NO_CELL, Receiver};
use crate::material::{Gloss, Material};
use crate::math::DVec3;
use crate::sampler::AliasTable;
use crate::scene::light_sample::{LightSample, NO_LIGHT};
use crate::scene::placed_emitters::{LightChoice, PlacedEmitters};
use crate::scene::shape_emitters::{ShapeEmitter, shape_emitters};
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::shape::Shape;

/// Marks a primitive without an emitter.
pub(crate) const NONE: u32 = u32::MAX;

/// The emitters of a scene.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    lights: Vec<Emitter>,
    /// Choice among all emitters; with a tree, among those outside it, with the tree as last entry.
    choice: AliasTable,
    placed: Option<PlacedEmitters>,
    /// With a tree, the indices of the emitters outside it, ascending.
    outside_tree: Vec<u32>,
    /// For each primitive its first emitter; empty if no shape is emissive.
    of_primitive: Vec<u32>,
    /// Indices of the infinite lights that rays can hit: environments, and directional lights with an extent.
    infinite_lights: Vec<u32>,
    /// Whether there is an environment light.
    has_environment: bool,
}

/// One emitter.
#[derive(Clone, Debug)]
pub(crate) enum Emitter {
    /// A light of the scene, by index.
    Light(u32),
    /// An emissive shape.
    Shape(ShapeEmitter),
}

/// A choice among the emitters outside the light tree and the tree.
pub(crate) enum FirstChoice<'a> {
    Emitter(Chosen<'a>),
    /// The light tree, the probability of choosing it, and the random number, rescaled to 0..1 for the choice of a light.
    Tree {
        placed: &'a PlacedEmitters,
        choice: f64,
        left: f64,
    },
}

/// A chosen emitter.
#[derive(Clone, Copy)]
pub(crate) struct Chosen<'a> {
    pub(crate) emitter: &'a Emitter,
    /// The triangle or point, if it was chosen together with the emitter; else [`NONE`].
    pub(crate) part: u32,
    /// The probability of the choice.
    pub(crate) choice: f64,
    /// The random number of the choice, rescaled to 0..1 for further use.
    pub(crate) left: f64,
}

impl Chosen<'_> {
    /// Samples the light that arrives at a point; `u` chooses the point on the emitter.
    #[inline]
    pub(crate) fn sample(&self, scene: &Scene, at: &Receiver, u: [f64; 2]) -> Option<LightSample> {
        let sample = match self.emitter {
            Emitter::Light(i) => match (scene.lights.get(*i as usize)?, at.cosine_normal()) {
                (Light::Environment(light), Some(n)) => {
                    LightSample::of_environment(light.sample_by_cosine(n, u)?, *i)
                }
                _ => scene.sample_light(*i, at.p, at.time, u)?,
            },
            Emitter::Shape(emitter) => emitter.sample(scene, at.p, [u[0], u[1], self.left], self.part)?,
        };
        Some(LightSample { pdf: sample.pdf * self.choice, ..sample })
    }
}

impl Emitters {
    /// The emitters of a scene whose other parts are prepared.
    pub(crate) fn new(scene: &Scene, how: LightChoice) -> Emitters {
        let mut emitters = Emitters::default();
        let (mut weights, mut powers) = (Vec::new(), Vec::new());
        let bounds = scene.stats.bounds;
        let center = bounds.map_or(DVec3::ZERO, |b| b.center());
        let radius = bounds.map_or(1.0, |b| 0.5 * b.size().length()).max(1e-30);
        for (i, light) in scene.lights.iter().enumerate() {
            emitters.lights.push(Emitter::Light(i as u32));
            weights.push(light.reach(center, radius));
            powers.push(0.0);
            let is_environment = matches!(light, Light::Environment(_));
            emitters.has_environment |= is_environment;
            if !light.is_finite() && !light.is_delta() {
                emitters.infinite_lights.push(i as u32);
            }
        }
        for (i, primitive) in scene.primitives.iter().enumerate() {
            for (emitter, power) in shape_emitters(scene, i as u32, primitive) {
                if emitters.of_primitive.is_empty() {
                    emitters.of_primitive.resize(scene.primitives.len(), NONE);
                }
                let first = &mut emitters.of_primitive[i];
                if *first == NONE {
                    *first = emitters.lights.len() as u32;
                }
                emitters.lights.push(Emitter::Shape(emitter));
                // `power` is already divided by π, so that it is comparable with the intensities of lights.
                weights.push(0.25 * power);
                powers.push(power);
            }
        }
        if let Some(placed) = PlacedEmitters::new(scene, &mut emitters.lights, &powers, how) {
            emitters.outside_tree = (0..weights.len() as u32).filter(|i| !placed.holds(*i)).collect();
            let held = (0..).zip(&weights).filter(|(i, w)| placed.holds(*i) && w.is_finite());
            let held: f64 = held.map(|(_, w)| w).sum();
            weights = emitters.outside_tree.iter().map(|i| weights[*i as usize]).collect();
            weights.push(held);
            emitters.placed = Some(placed);
        }
        let sum: f64 = weights.iter().filter(|w| w.is_finite()).sum();
        let uniform = 1.0 / weights.len().max(1) as f64;
        for w in &mut weights {
            *w = uniform + if sum > 0.0 && w.is_finite() { *w / sum } else { 0.0 };
        }
        if let Some(choice) = AliasTable::new(&weights) {
            emitters.choice = choice;
        } else {
            emitters.lights.clear();
            emitters.of_primitive.clear();
            emitters.placed = None;
        }
        emitters
    }

    /// Memory of the light tree in bytes; 0 without a tree.
    pub fn tree_bytes(&self) -> usize {
        self.placed.as_ref().map_or(0, PlacedEmitters::bytes)
    }

    /// All emitters.
    pub(crate) fn all(&self) -> &[Emitter] {
        &self.lights
    }

    /// The number of emitters.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is no emitter.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// Whether the choice depends on the normal and lobe of the receiver, not only on its position.
    pub fn use_surface_sides(&self) -> bool {
        self.placed.is_some()
    }

    /// Samples light at a point: `u[0]` and `u[1]` choose the point on the light, `u[2]` the light. This is one sample
    /// with its own pdf, independent of the receiver's number of candidates; [`LightBatch`](super::LightBatch) samples
    /// all candidates.
    pub fn sample(&self, scene: &Scene, at: impl Into<Receiver>, u: [f64; 3]) -> Option<LightSample> {
        if self.lights.is_empty() {
            return None;
        }
        let at = at.into();
        self.choose(&at, u[2])?.sample(scene, &at, [u[0], u[1]])
    }

    /// The same where requests that have a cell sample `adaptive`.
    pub fn sample_adaptive(
        &self,
        scene: &Scene,
        adaptive: Option<&AdaptiveEnvironment>,
        at: Receiver,
        u: [f64; 3],
    ) -> Option<LightSample> {
        let adaptive = adaptive.filter(|_| at.cell != NO_CELL && !self.lights.is_empty());
        let Some(adaptive) = adaptive else { return self.sample(scene, at, u) };
        let chosen = self.choose(&at, u[2])?;
        match chosen.emitter {
            Emitter::Light(i) if *i == adaptive.light() => {
                let sample = adaptive.sample(at.cell, [u[0], u[1]])?;
                Some(LightSample::of_environment(sample, *i).chosen(chosen.choice))
            }
            _ => chosen.sample(scene, &at, [u[0], u[1]]),
        }
    }

    /// The pdf with which [`Emitters::sample_adaptive`] gives a unit direction to an infinite light.
    pub(crate) fn infinite_pdf(
        &self,
        scene: &Scene,
        adaptive: Option<&AdaptiveEnvironment>,
        at: &Receiver,
        light: u32,
        direction: DVec3,
    ) -> f64 {
        match adaptive.filter(|adaptive| at.cell != NO_CELL && adaptive.light() == light) {
            Some(adaptive) => self.choice_of(light) * adaptive.found(at.cell, direction).1,
            None => self.infinite_one(scene, light, direction).map_or(0.0, |(_, pdf)| pdf),
        }
    }

    /// The emitter that `u` chooses for a point; `None` if no emitter in the tree can contribute.
    pub(crate) fn choose(&self, at: &Receiver, u: f64) -> Option<Chosen<'_>> {
        match self.first_choice(u) {
            FirstChoice::Emitter(chosen) => Some(chosen),
            FirstChoice::Tree { placed, choice, left } => {
                self.chosen_in_tree(placed, choice, placed.tree().sample(at, left))
            }
        }
    }

    /// The choice among the emitters outside the tree and the tree.
    #[inline]
    pub(crate) fn first_choice(&self, u: f64) -> FirstChoice<'_> {
        let (chosen, choice, left) = self.choice.sample(u);
        let index = match &self.placed {
            None => chosen,
            Some(placed) => match self.outside_tree.get(chosen as usize) {
                Some(light) => *light,
                None => return FirstChoice::Tree { placed, choice, left },
            },
        };
        FirstChoice::Emitter(Chosen { emitter: &self.lights[index as usize], part: NONE, choice, left })
    }

    /// The emitter of a leaf of the tree, which was chosen with the probability `choice`.
    #[inline]
    pub(crate) fn chosen_in_tree(
        &self,
        placed: &PlacedEmitters,
        choice: f64,
        found: Option<ChosenLight>,
    ) -> Option<Chosen<'_>> {
        let (leaf, probability, left) = found?;
        let (light, part) = placed.leaf(leaf)?;
        let emitter = self.lights.get(light as usize)?;
        Some(Chosen { emitter, part, choice: choice * probability, left })
    }

    /// The pdf with which `sample` at a point gives the direction to a hit on an emissive shape, times the number of
    /// candidates; 0 if `sample` never gives it.
    pub fn pdf_hit(&self, scene: &Scene, at: impl Into<Receiver>, surface: &SurfaceInteraction) -> f64 {
        let Hit { shape, primitive } = &surface.hit;
        let first = self.of_primitive.get(*primitive as usize).copied().unwrap_or(NONE);
        if first == NONE {
            return 0.0;
        }
        let face =
            if matches!(scene.primitives[*primitive as usize].shape, Shape::Box(_)) { shape.part } else { 0 };
        let index = first + face;
        let Some(Emitter::Shape(emitter)) = self.lights.get(index as usize) else { return 0.0 };
        let at = at.into();
        let Some(placed) = &self.placed else {
            return self.choice.probability(index) * emitter.pdf(scene, at.p, surface) * at.candidates();
        };
        let (probability, of_part) = placed.probability(&at, index, emitter.position(surface));
        if probability <= 0.0 {
            return 0.0;
        }
        let pdf = if of_part {
            emitter.pdf_of_part(scene, at.p, surface)
        } else {
            emitter.pdf(scene, at.p, surface)
        };
        self.choice.probability(self.outside_tree.len() as u32) * probability * pdf * at.candidates()
    }

    /// The probability with which `sample` at a point chooses a light of the scene.
    pub(crate) fn choice_at(&self, at: impl Into<Receiver>, light: u32) -> f64 {
        match &self.placed {
            Some(placed) if placed.holds(light) => {
                let (probability, _) = placed.probability(&at.into(), light, 0);
                self.choice.probability(self.outside_tree.len() as u32) * probability
            }
            _ => self.choice_of(light),
        }
    }

    /// Whether there is an environment light in place of the background.
    pub fn has_infinite_lights(&self) -> bool {
        self.has_environment
    }

    /// The indices of the infinite lights that escaped rays can hit.
    pub(crate) fn infinite_ids(&self) -> &[u32] {
        &self.infinite_lights
    }

    /// The probability with which a light is chosen; the first indices are those of the scene's lights.
    pub(crate) fn choice_of(&self, light: u32) -> f64 {
        if self.placed.is_none() {
            return self.choice.probability(light);
        }
        self.outside_tree
            .binary_search(&light)
            .map_or(0.0, |position| self.choice.probability(position as u32))
    }

    /// Radiance of one infinite light in a unit direction, with the pdf with which `sample` gives the direction;
    /// `None` if the light does not lie in that direction.
    pub(crate) fn infinite_one(
        &self,
        scene: &Scene,
        light: u32,
        direction: DVec3,
    ) -> Option<(Spectrum, f64)> {
        let (radiance, pdf) = match scene.lights.get(light as usize)? {
            Light::Environment(l) => l.found(direction),
            Light::Directional(l) => l.found(direction)?,
            Light::Point(_) | Light::Spot(_) | Light::Area(_) => return None,
        };
        Some((radiance, self.choice_of(light) * pdf))
    }
}

impl Scene {
    /// Changes how physical integrators choose lights, for comparisons.
    pub fn choose_lights(&mut self, how: LightChoice) {
        if self.physical {
            self.emitters = Emitters::new(self, how).into();
        }
    }

    /// The bound of a light, over all times of the shutter.
    pub(crate) fn light_bound(&self, light: u32) -> Option<crate::light::LightBound> {
        let own = self.lights.get(light as usize)?;
        match self.light_motions.get(light as usize) {
            Some(Some(motion)) => own.moved_bound(motion, self.shutter),
            _ => own.bound(),
        }
    }

    /// A sample of one light at a point, at a time of the shutter.
    #[inline]
    pub(crate) fn sample_light(&self, light: u32, p: DVec3, time: f32, u: [f64; 2]) -> Option<LightSample> {
        let own = self.lights.get(light as usize)?;
        match self.light_motions.get(light as usize) {
            Some(Some(motion)) => {
                let placed = motion.at(f64::from(time));
                let sample = own.sample(placed.inverse().transform_point3(p), u, light)?;
                let to_light = placed.transform_vector3(sample.to_light);
                let to_light = if sample.finite { to_light } else { to_light.normalize() };
                Some(LightSample { to_light, ..sample })
            }
            _ => own.sample(p, u, light),
        }
    }

    /// The receiver for a surface hit by a ray of this direction; it has a normal if only light on one side counts.
    #[inline]
    pub(crate) fn receiver(&self, surface: &SurfaceInteraction, direction: DVec3) -> Receiver {
        match self.material_at(&surface.hit) {
            Material::OpenPbr(m) if self.emitters.use_surface_sides() => {
                self.receiver_of(m.side(), surface.p, surface.ng, surface.ns, direction)
            }
            _ => Receiver::from(surface.p),
        }
    }

    /// The same from a point and its geometric and shading normals. `side` is the gloss of a material that only light
    /// on one side reaches.
    #[inline]
    pub(crate) fn receiver_of(
        &self,
        side: Option<Gloss>,
        p: DVec3,
        ng: DVec3,
        ns: DVec3,
        direction: DVec3,
    ) -> Receiver {
        match side {
            Some(gloss) if self.emitters.use_surface_sides() => {
                let facing = Receiver::facing(p, -ng * ng.dot(direction).signum());
                facing.with_lobe(gloss.lobe(direction, ns))
            }
            _ => Receiver::from(p),
        }
    }
}

impl Light {
    /// Samples the light that arrives at `p` from this light, whose index is `light`; `u` chooses the point on it. The
    /// pdf is 1 for delta lights.
    pub(crate) fn sample(&self, p: DVec3, u: [f64; 2], light: u32) -> Option<LightSample> {
        if let Light::Environment(l) = self {
            return l.sample(u).map(|s| LightSample::of_environment(s, light));
        }
        let primitive = NO_LIGHT;
        if let Light::Directional(l) = self
            && let Some((to_light, radiance, pdf)) = l.sample(u)
        {
            return Some(LightSample {
                to_light,
                finite: false,
                radiance,
                pdf,
                is_delta: false,
                light,
                primitive,
                part: 0,
            });
        }
        let lit = self.illuminate_at(p, u)?;
        let to_light = if lit.finite { lit.to_light } else { lit.to_light.normalize() };
        let (finite, radiance) = (lit.finite, lit.intensity);
        Some(LightSample { to_light, finite, radiance, pdf: 1.0, is_delta: true, light, primitive, part: 0 })
    }

    /// Estimate of the power that reaches the scene, for the choice of lights: irradiance times the cross section of a
    /// sphere around the scene.
    fn reach(&self, center: DVec3, radius: f64) -> f64 {
        const DIRECTIONS: [DVec3; 7] =
            [DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        if let Light::Environment(l) = self {
            // The irradiance, averaged over the orientations of a surface, is a quarter of the integrated radiance.
            return 0.25 * f64::from(l.power().luminance()) * std::f64::consts::PI * radius * radius;
        }
        let arrives = |d: DVec3| {
            let lit = self.illuminate_at(center + 0.7 * radius * d, [0.5, 0.5]);
            lit.map_or(0.0, |l| f64::from(l.intensity.luminance()))
        };
        let mut values = DIRECTIONS.map(arrives);
        // One position may be next to the light: the largest value is dropped.
        values.sort_by(f64::total_cmp);
        let trimmed: f64 = values[..6].iter().sum();
        trimmed / 6.0 * std::f64::consts::PI * radius * radius
    }
}
