//! The state of one light path, with its densities for MIS.
//!
//! ```text
//!  light y0 -----> y1 (target) -----> y2 --- ... ---> y_n        camera o
//!         emission density            BSDF densities      \______/ joined to the camera at each y_i, i >= 2
//! ```
//!
//! MIS needs the density with which path tracing makes the same path from the other end. Between two vertices a and b a
//! density per solid angle becomes one per area by the factor |cos at b| / |b − a|². The state holds the running
//! product of the ratios
//!
//! ```text
//!  p(y_j found from the camera side) / p(y_j found from the light side)
//! ```
//!
//! over all vertices but the last, per area, once for a path that ends by hitting the light and once for one that
//! samples it.

use super::strategy::CausticsStrategy;
use crate::color::Spectrum;
use crate::integrator::path::group_split::NO_GROUP;
use crate::integrator::path::media::Media;
use crate::integrator::path::settings::Bounces;
use crate::light::AdaptiveEnvironment;
use crate::math::{DVec3, Ray};
use crate::sampler::OwenSobol;
use crate::scene::caustic_targets::{Source, Start};
use crate::scene::{Scene, SurfaceInteraction};

/// The state of a light path.
#[derive(Clone)]
pub(super) struct LightPath {
    pub(super) numbers: OwenSobol,
    pub(super) time: f32,
    pub(super) start: Start,
    /// The light group of the light, as an index; [`NO_GROUP`] for none.
    pub(super) light_group: u32,
    /// Power carried.
    pub(super) beta: Spectrum,
    pub(super) vertex: u32,
    pub(super) bounces: Bounces,
    pub(super) transparent: u32,
    pub(super) media: Media,
    pub(super) band: Option<u8>,
    /// Whether the first surface scattered it by a delta lobe, or is near-specular: it may then be found by photons.
    pub(super) specular_first: bool,
    /// Whether that lobe was a delta lobe.
    pub(super) by_delta: bool,
    /// Whether it has scattered at a rough surface after that, where photons count it.
    pub(super) has_photon: bool,
    /// Number of surfaces that have scattered it.
    pub(super) scatterings: u32,
    /// Origin of the current ray: the last vertex, or the point on the light; and the cosine there.
    pub(super) p: DVec3,
    pub(super) cos: f64,
    /// Whether the light is infinite: its rays are parallel.
    pub(super) parallel: bool,
    /// Density of the ray's direction per solid angle; of parallel rays, per area perpendicular to them.
    pub(super) direction_pdf: f64,
    /// Density per area with which the last vertex was found.
    pub(super) vertex_pdf: f64,
    /// Ratio of densities, camera path over light path, over all vertices but the last: by hitting the light, and by
    /// sampling it. Before the first scattering `hit_ratio` holds the density of the start.
    pub(super) hit_ratio: f64,
    pub(super) nee_ratio: f64,
}

impl LightPath {
    /// Density per area with which the path finds a surface.
    pub(super) fn area_pdf(&self, surface: &SurfaceInteraction) -> f64 {
        let offset = surface.p - self.p;
        let d2 = offset.length_squared();
        if self.parallel {
            return self.direction_pdf * self.start.ray.direction.dot(surface.ng).abs();
        }
        self.direction_pdf * offset.dot(surface.ng).abs() / (d2 * d2.sqrt())
    }

    /// Ratio of densities at the last vertex: from `surface`, with density `reverse_pdf` per solid angle, over that of
    /// this path.
    pub(super) fn reverse_ratio(&self, surface: &SurfaceInteraction, reverse_pdf: f64) -> f64 {
        let d2 = (surface.p - self.p).length_squared();
        reverse_pdf * self.cos / (d2 * self.vertex_pdf)
    }

    /// Computes the power at the first surface, where `ray` arrives; returns whether it is positive.
    ///
    /// Leaves the density of the start in `hit_ratio`.
    pub(super) fn emit(
        &mut self,
        scene: &Scene,
        strategy: &CausticsStrategy,
        surface: &SurfaceInteraction,
        ray: &Ray,
    ) -> bool {
        let group = self.start.group;
        let cos = ray.direction.dot(surface.ng).abs();
        let (power, start) = match self.start.from {
            Source::Shape => {
                // The point on the light as a ray from the surface finds it, and its radiance.
                let back = Ray { time: self.time, ..Ray::new(surface.leave(-ray.direction), -ray.direction) };
                let Some((light, radiance)) = scene.first_emitter(&back) else { return false };
                self.light_group = scene.light_group_of(light.hit.primitive).unwrap_or(NO_GROUP);
                self.p = light.p;
                self.cos = ray.direction.dot(light.ng).abs();
                let (start, leave) = strategy.caustic_targets.density_on_shape(scene, group, &light);
                self.direction_pdf = leave;
                (radiance * (self.cos / (start * leave)) as f32, start)
            }
            Source::Infinite(light) => {
                let to_light = -self.start.ray.direction;
                let Some((radiance, _)) = scene.emitters.infinite_one(scene, light, to_light) else {
                    return false;
                };
                let (start, pass) = strategy.caustic_targets.infinite_pdf(scene, group, light, to_light);
                (self.parallel, self.direction_pdf) = (true, pass);
                (radiance * (1.0 / (start * pass)) as f32, start)
            }
            Source::Delta(light, place) => {
                let Some(lit) = scene.lights[light as usize].sample(surface.p, place, light) else {
                    return false;
                };
                let from = lit.finite.then_some(self.start.ray.origin);
                let (start, leave) = strategy.caustic_targets.density_of_delta(group, light, from);
                // Irradiance at a surface that faces the light, over the density per area there.
                let d2 = if lit.finite { lit.to_light.length_squared() } else { 1.0 };
                (self.parallel, self.direction_pdf, self.cos) = (!lit.finite, leave, 0.0);
                (lit.radiance * (d2 / (start * leave)) as f32, start)
            }
        };
        if let Source::Infinite(light) | Source::Delta(light, _) = self.start.from {
            self.light_group = scene.light_groups.of_light(light).unwrap_or(NO_GROUP);
        }
        self.hit_ratio = start;
        // Grazing rays have zero weight.
        self.beta = self.beta * power;
        cos > 0.0 && start > 0.0 && self.beta.is_finite() && !self.beta.is_black()
    }

    /// Ratio of densities: sampling the light from the first surface, over the start of this path. The path leaves that
    /// surface in the direction `to`.
    pub(super) fn nee_ratio_at(
        &self,
        scene: &Scene,
        adaptive: Option<&AdaptiveEnvironment>,
        surface: &SurfaceInteraction,
        to: DVec3,
    ) -> f64 {
        let mut receiver = scene.receiver(surface, -to);
        if let Some(adaptive) = adaptive {
            receiver = receiver.in_cell(adaptive.cell(receiver.p));
        }
        let start = self.hit_ratio;
        match self.start.from {
            Source::Shape => {
                let back = Ray {
                    time: self.time,
                    ..Ray::new(surface.leave(self.p - surface.p), self.p - surface.p)
                };
                let Some((light, _)) = scene.first_emitter(&back) else { return 0.0 };
                let offset = self.p - surface.p;
                let pdf = scene.emitters.pdf_hit(scene, receiver, &light);
                pdf * self.cos / (offset.length_squared() * start)
            }
            Source::Infinite(light) => {
                let to_light = -self.start.ray.direction;
                scene.emitters.infinite_pdf(scene, adaptive, &receiver, light, to_light) / start
            }
            Source::Delta(light, _) => scene.emitters.choice_at(receiver, light) / start,
        }
    }

    /// Keeps one band of the path, chosen by `u` with the band's fraction of the power.
    pub(super) fn choose_band(&mut self, u: f64) {
        let fractions = self.beta.to_array().map(|v| f64::from(v.max(0.0)));
        let sum: f64 = fractions.iter().sum();
        let target = u * sum;
        let band: u8 = match target {
            p if p < fractions[0] => 0,
            p if p < fractions[0] + fractions[1] || fractions[2] == 0.0 => 1,
            _ => 2,
        };
        let mut beta = [0.0; 3];
        beta[usize::from(band)] = sum as f32;
        (self.beta, self.band) = (Spectrum::from(beta), Some(band));
    }
}

impl Scene {
    /// The first emissive surface along a ray, through surfaces that let it pass straight, and its radiance; `None` if
    /// another surface is hit first.
    pub(in crate::integrator) fn first_emitter(&self, ray: &Ray) -> Option<(SurfaceInteraction, Spectrum)> {
        let mut ray = *ray;
        // Maximum number of panes and holes.
        for _ in 0..64 {
            let hit = self.intersect(&ray)?;
            let surface = self.surface(&ray, &hit);
            let outside = ray.direction.dot(surface.ng) < 0.0;
            let radiance = self.material_at(&hit).emitted(self, || self.texture_point(&surface), outside);
            if !radiance.is_black() {
                return Some((surface, radiance));
            }
            ray = Ray { time: ray.time, ..Ray::new(surface.leave(ray.direction), ray.direction) };
        }
        None
    }
}
