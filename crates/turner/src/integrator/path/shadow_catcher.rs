//! Shadow catchers: the camera sees nothing of them but the shadow that other objects cast on them.
//!
//! Where a camera ray first hits a shadow catcher, the direct light there is estimated twice from the same light samples,
//! for a white diffuse surface that faces the camera:
//!
//! ```text
//!  S = ∫ L(ω) V(ω) cos dω     with all objects in the way
//!  U = ∫ L(ω) C(ω) cos dω     with shadow catchers alone in the way
//! ```
//!
//! The ray then continues straight, as through a hole. The film sums S and U, and the shadow of a pixel is 1 − ΣS / ΣU. It is a
//! ratio of sums: a mean of ratios would weigh lights by the probability of their choice instead of by their
//! irradiance.
//!
//! S and U have two samples each. One is of the light that next-event estimation chooses. The other follows the cosine to
//! infinite lights, the background and ambient light, weighted against the first by MIS, because light sampling may leave
//! the darker parts of an environment to it. Light from other surfaces is not part of S and U. Emitters that cannot be
//! sampled cast no shadow here.

use turner_bvh::lanes::LANES;

use super::path_batch::{PathBatch, VertexInput};
use super::record::{End, Passage, Record};
use crate::bsdf::sample_cosine;
use crate::color::Spectrum;
use crate::integrator::{CaughtLight, RayStats};
use crate::light::Receiver;
use crate::math::{DVec2, DVec3, Frame, Ray};
use crate::scene::{RayBatch, Scene, SpectrumBlock, SurfaceInteraction};

/// The most surfaces that are looked through for a shadow catcher.
const MAX_CROSSINGS: u32 = 4096;

/// The light that arrives at shadow catchers in a batch.
pub(super) struct ShadowCatcher {
    /// Whether the scene has any.
    on: bool,
    caught: Vec<CaughtLight>,
    rays: RayBatch,
    /// The sample of each ray, and what it brings if nothing is in the way.
    light: Vec<(u32, Spectrum)>,
    through: Vec<SpectrumBlock>,
}

impl ShadowCatcher {
    pub(super) fn new(scene: &Scene) -> ShadowCatcher {
        ShadowCatcher {
            on: !scene.shadow_catchers.is_empty(),
            caught: Vec::new(),
            rays: RayBatch::default(),
            light: Vec::new(),
            through: Vec::new(),
        }
    }

    /// For each sample of the last batch what a shadow catcher received.
    pub(super) fn caught(&self) -> &[CaughtLight] {
        &self.caught
    }

    /// Begins a batch.
    pub(super) fn begin(&mut self, samples: usize) {
        if self.on {
            self.caught.clear();
            self.caught.resize(samples, CaughtLight::default());
        }
    }

    /// Adds a shadow ray from a surface: towards a point relative to it, or in a direction.
    fn push(&mut self, sample: u32, surface: &SurfaceInteraction, towards: (DVec3, bool), light: Spectrum) {
        let (to, finite) = towards;
        let origin = surface.leave(to);
        let ray = if finite {
            Ray { t_max: 1.0, ..Ray::new(origin, surface.p + to - origin) }
        } else {
            Ray::new(origin, to)
        };
        self.rays.push_from(&ray, surface);
        self.light.push((sample, light));
    }
}

impl<R: Record> PathBatch<'_, R> {
    /// Estimates the direct light at a shadow catcher that a camera ray hits, and lets the ray pass.
    pub(super) fn catch_shadow(&mut self, at: &VertexInput<'_>) {
        let &VertexInput { sample, ref ray, surface, .. } = at;
        self.record.note(|r| r.at(|v| v.passage = Passage::Hole));
        let path = &mut self.paths[sample as usize];
        path.transparent += 1;
        if path.transparent <= self.settings.max_transparent {
            self.next.push(sample, surface, ray.direction);
        } else {
            self.record.note(|r| r.end = End::Transparency);
        }
        let Some(caught) = self.catcher.caught.get_mut(sample as usize) else { return };
        if caught.is_caught {
            return;
        }
        caught.is_caught = true;
        if self.guides.are_alone() {
            return;
        }
        let side = if surface.ng.dot(ray.direction) > 0.0 { -1.0 } else { 1.0 };
        self.sample_caught_light(sample, surface, surface.ns * side);
        self.sample_caught_sky(sample, surface, surface.ns * side);
    }

    /// The light that next-event estimation chooses.
    fn sample_caught_light(&mut self, sample: u32, surface: &SurfaceInteraction, n: DVec3) {
        let scene = self.scene;
        let [u0, u1, u2, _] = self.paths[sample as usize].numbers.first();
        let receiver = match scene.emitters.use_surface_sides() {
            true => Receiver::facing(surface.p, n),
            false => Receiver::from(surface.p),
        };
        let Some(lit) = scene.emitters.sample(scene, receiver, [u0, u1, u2]) else { return };
        let pdf = lit.pdf;
        let cos = lit.to_light.normalize().dot(n);
        let is_sky = scene.emitters.infinite_ids().contains(&lit.light);
        let other = if is_sky && !lit.is_delta { cos * std::f64::consts::FRAC_1_PI } else { 0.0 };
        let weight = pdf * pdf / (pdf * pdf + other * other);
        let light = lit.radiance * (cos * weight * std::f64::consts::FRAC_1_PI / pdf) as f32;
        if cos > 0.0 && light.is_finite() && !light.is_black() {
            self.catcher.push(sample, surface, (lit.to_light, lit.finite), light);
        }
    }

    /// Infinite lights, the background and ambient light in a direction that follows the cosine.
    fn sample_caught_sky(&mut self, sample: u32, surface: &SurfaceInteraction, n: DVec3) {
        let (scene, emitters) = (self.scene, &self.scene.emitters);
        let [u0, u1, ..] = self.paths[sample as usize].numbers.second();
        let local = sample_cosine(DVec2::new(u0, u1).into());
        let direction = Frame::from_z(n).to_world(local);
        let pdf = local.z * std::f64::consts::FRAC_1_PI;
        let mut light = scene.ambient;
        for &id in emitters.infinite_ids() {
            if let Some((radiance, other)) = emitters.infinite_one(scene, id, direction) {
                light += radiance * (pdf * pdf / (pdf * pdf + other * other)) as f32;
            }
        }
        if !emitters.has_infinite_lights() {
            light += scene.background.color(direction);
        }
        if pdf > 0.0 && light.is_finite() && !light.is_black() {
            self.catcher.push(sample, surface, (direction, false), light);
        }
    }

    /// Traces the rays of a round from shadow catchers to light.
    pub(super) fn trace_catcher_rays(&mut self, stats: &mut RayStats) {
        let catcher = &mut self.catcher;
        if catcher.light.is_empty() {
            return;
        }
        stats.shadow += catcher.light.len() as u64;
        if self.scene.moves {
            for (i, &(sample, _)) in catcher.light.iter().enumerate() {
                catcher.rays.set_time(i, self.paths[sample as usize].time);
            }
        }
        self.scene.transmittance_batch(&mut catcher.rays, &mut catcher.through);
        for (i, &(sample, light)) in catcher.light.iter().enumerate() {
            self.counts.add(sample);
            let through = catcher.through[i / LANES].get(i % LANES);
            let ray = catcher.rays.get(i);
            if through.is_black() && ray.is_some_and(|ray| self.scene.meets_shadow_catcher(&ray)) {
                continue;
            }
            let caught = &mut catcher.caught[sample as usize];
            caught.unshadowed += light.luminance();
            caught.shadowed += (light * through).luminance();
        }
        catcher.rays.clear();
        catcher.light.clear();
    }
}

impl Scene {
    /// Whether a shadow catcher is in the way of a shadow ray, whatever else is.
    fn meets_shadow_catcher(&self, ray: &Ray) -> bool {
        let mut ray = *ray;
        for _ in 0..MAX_CROSSINGS {
            let Some(hit) = self.intersect(&ray) else { return false };
            if self.is_shadow_catcher(&hit) {
                return true;
            }
            ray.t_min = self.beyond(&ray, &hit, &self.surface(&ray, &hit));
        }
        false
    }
}
