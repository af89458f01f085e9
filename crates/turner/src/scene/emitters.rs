//! All that shines in a scene, ready to be chosen from: lights, and shapes with an emissive material.
//!
//! How shapes are sampled stands in `shape_emitters`; those that are not are only hit by chance, which
//! is right all the same, but noisier. A light is chosen with a probability half in proportion to
//! what it brings to the scene, half the same for all.

use super::scene::{Hit, Scene, SurfaceInteraction};
use super::shape_emitters::{ShapeEmitter, shape_emitters};
use crate::color::Spectrum;
use crate::light::{EnvironmentSample, Light};
use crate::math::DVec3;
use crate::sampler::AliasTable;
use crate::shape::Shape;

/// No emitter stands for a primitive.
pub(super) const NONE: u32 = u32::MAX;

/// Light from one direction at a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Towards the light; for one with a place, as far as the light, so that a shadow ray ends at t = 1.
    pub to_light: DVec3,
    /// Whether the light has a place.
    pub finite: bool,
    /// Radiance; of lights that are a point or a direction, what arrives at a surface that faces them.
    pub radiance: Spectrum,
    /// Density per solid angle, the choice of the light included; of a point or a direction the probability of its choice.
    pub pdf: f64,
    /// Whether rays cannot hit the light by chance.
    pub is_delta: bool,
}

impl LightSample {
    /// Of an environment that was chosen.
    #[inline]
    pub(super) fn of_environment(s: EnvironmentSample) -> LightSample {
        LightSample {
            to_light: s.direction,
            finite: false,
            radiance: s.radiance,
            pdf: s.pdf,
            is_delta: false,
        }
    }
}

/// The lights of a scene.
#[derive(Debug, Default)]
pub struct Emitters {
    lights: Vec<Emitter>,
    choice: AliasTable,
    /// For each primitive its first emitter; empty if no shape shines.
    of_primitive: Vec<u32>,
    /// The numbers of the scene's lights that rays find which leave it: environments, and directional lights with an extent.
    around: Vec<u32>,
    /// Whether there is an environment.
    surrounded: bool,
}

/// One of them.
#[derive(Debug)]
pub(super) enum Emitter {
    /// One of the scene's lights.
    Light(u32),
    /// A shape that shines.
    Shape(ShapeEmitter),
}

impl Emitter {
    /// Light from it at `p`, where it was chosen with the probability `choice`.
    #[inline]
    pub(super) fn sample(&self, scene: &Scene, p: DVec3, u: [f64; 3], choice: f64) -> Option<LightSample> {
        let lit = match self {
            Emitter::Light(i) => scene.lights[*i as usize].sample(p, [u[0], u[1]])?,
            Emitter::Shape(emitter) => emitter.sample(scene, p, u)?,
        };
        Some(LightSample { pdf: lit.pdf * choice, ..lit })
    }
}

impl Emitters {
    /// Those of a scene that is otherwise ready.
    pub(super) fn new(scene: &Scene) -> Emitters {
        let mut emitters = Emitters::default();
        let mut weights = Vec::new();
        let bounds = scene.stats.bounds;
        let center = bounds.map_or(DVec3::ZERO, |b| b.center());
        let radius = bounds.map_or(1.0, |b| 0.5 * b.size().length()).max(1e-30);
        for (i, light) in scene.lights.iter().enumerate() {
            emitters.lights.push(Emitter::Light(i as u32));
            weights.push(light.reach(center, radius));
            let surrounds = matches!(light, Light::Environment(_));
            emitters.surrounded |= surrounds;
            if surrounds || matches!(light, Light::Directional(l) if l.is_disc()) {
                emitters.around.push(i as u32);
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
                // Per π of intensity, as that of the lights.
                weights.push(0.25 * power);
            }
        }
        let sum: f64 = weights.iter().filter(|w| w.is_finite()).sum();
        let even = 1.0 / weights.len().max(1) as f64;
        for w in &mut weights {
            *w = even + if sum > 0.0 && w.is_finite() { *w / sum } else { 0.0 };
        }
        if let Some(choice) = AliasTable::new(&weights) {
            emitters.choice = choice;
        } else {
            emitters.lights.clear();
            emitters.of_primitive.clear();
        }
        emitters
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// Light that arrives at `p`, by `u`: two numbers for the place on the light and one for the choice of the light.
    pub fn sample(&self, scene: &Scene, p: DVec3, u: [f64; 3]) -> Option<LightSample> {
        if self.lights.is_empty() {
            return None;
        }
        let (emitter, choice, left) = self.choose(u[2]);
        emitter.sample(scene, p, [u[0], u[1], left], choice)
    }

    /// The emitter that `u` chooses, the probability of that, and what is left of `u`.
    #[inline]
    pub(super) fn choose(&self, u: f64) -> (&Emitter, f64, f64) {
        let (chosen, choice, left) = self.choice.sample(u);
        (&self.lights[chosen as usize], choice, left)
    }

    /// The density with which `sample` at `p` gives the direction to a hit of a shape that shines; 0 if it never does.
    pub fn pdf_hit(&self, scene: &Scene, p: DVec3, surface: &SurfaceInteraction) -> f64 {
        let Hit { shape, primitive } = &surface.hit;
        let first = self.of_primitive.get(*primitive as usize).copied().unwrap_or(NONE);
        if first == NONE {
            return 0.0;
        }
        let face =
            if matches!(scene.primitives[*primitive as usize].shape, Shape::Box(_)) { shape.part } else { 0 };
        let index = first + face;
        let Some(Emitter::Shape(emitter)) = self.lights.get(index as usize) else { return 0.0 };
        self.choice.probability(index) * emitter.pdf(scene, p, surface)
    }

    /// Whether an environment stands in the background's place.
    pub fn surrounded(&self) -> bool {
        self.surrounded
    }

    /// The numbers of the lights that rays find which leave the scene.
    pub(super) fn around_ids(&self) -> &[u32] {
        &self.around
    }

    /// The probability with which a light is chosen; those of the scene have its numbers.
    pub(super) fn choice_of(&self, light: u32) -> f64 {
        self.choice.probability(light)
    }

    /// What a ray finds of one of them that leaves the scene in a unit direction: its radiance and the density with which
    /// `sample` gives the direction.
    pub(super) fn around_one(&self, scene: &Scene, light: u32, direction: DVec3) -> Option<(Spectrum, f64)> {
        let (radiance, pdf) = match scene.lights.get(light as usize)? {
            Light::Environment(l) => l.found(direction),
            Light::Directional(l) => l.found(direction)?,
            _ => return None,
        };
        Some((radiance, self.choice_of(light) * pdf))
    }
}

impl Light {
    /// Light that arrives at `p`; the place on it by `u`. The density is 1 for lights that rays cannot hit.
    fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<LightSample> {
        if let Light::Environment(l) = self {
            return l.sample(u).map(LightSample::of_environment);
        }
        if let Light::Directional(l) = self
            && let Some((to_light, radiance, pdf)) = l.sample(u)
        {
            return Some(LightSample { to_light, finite: false, radiance, pdf, is_delta: false });
        }
        let lit = self.illuminate_at(p, u)?;
        let to_light = if lit.finite { lit.to_light } else { lit.to_light.normalize() };
        Some(LightSample { to_light, finite: lit.finite, radiance: lit.intensity, pdf: 1.0, is_delta: true })
    }

    /// What it brings to a scene, to choose by.
    fn reach(&self, center: DVec3, radius: f64) -> f64 {
        const DIRECTIONS: [DVec3; 7] =
            [DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        if let Light::Environment(l) = self {
            // On a surface that faces all of it a quarter arrives.
            return 0.25 * f64::from(l.power().luminance()) * std::f64::consts::PI * radius * radius;
        }
        let arrives = |d: DVec3| {
            let lit = self.illuminate_at(center + 0.7 * radius * d, [0.5, 0.5]);
            lit.map_or(0.0, |l| f64::from(l.intensity.luminance()))
        };
        let mut values = DIRECTIONS.map(arrives);
        // One place may be next to the light.
        values.sort_by(f64::total_cmp);
        let trimmed: f64 = values[..6].iter().sum();
        trimmed / 6.0 * std::f64::consts::PI * radius * radius
    }
}
