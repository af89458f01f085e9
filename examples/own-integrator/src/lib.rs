//! A custom integrator that uses only the public interface of `turner`: every surface is diffuse and lit by the sky.
//!
//! A surface of albedo ρ under a sky of radiance L(ω) reflects ρ/π ∫ L(ω) V(ω) cos θ dω, where the visibility V is 1
//! for directions ω that are not occluded. Each camera sample takes one direction with density cos θ / π, so its
//! estimate is ρ L(ω) V(ω): the cosine and π cancel.
//!
//! [`SkyLight`] holds the settings, [`PreparedSkyLight`] is prepared for a scene, and `SkyTracer` is the state of a
//! thread.

use std::sync::Arc;

use turner::SceneError;
use turner::color::Spectrum;
use turner::integrator::{
    CameraSamples, Capabilities, Integrator, PreparedIntegrator, Radiance, RayStats, Tracer,
};
use turner::math::{DVec2, DVec3, Frame, Ray};
use turner::sampler::{OwenSobol, SampleId, concentric_disk};
use turner::scene::{Hit, RayBatch, Scene};
use turner::view::View;

/// Identifies the random numbers that choose the direction; distinct from those of the pixel and lens positions.
const DIRECTION_SET: u32 = 0x5c1;

/// Diffuse surfaces under the light of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyLight {
    /// Occluders farther away than this are ignored, in scene units; greater than 0.
    pub distance: f64,
}

impl Default for SkyLight {
    /// No limit on the distance of occluders.
    fn default() -> SkyLight {
        SkyLight { distance: f64::INFINITY }
    }
}

impl Integrator for SkyLight {
    fn name(&self) -> &str {
        "sky-light"
    }

    fn capabilities(&self) -> Capabilities {
        // Only uses the base colour of materials, and no lights.
        Capabilities::default()
    }

    fn prepare(&self, _: &Scene, _: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        // An integrator with tables (a photon map, a guide) would build them here, once for all threads.
        Ok(Arc::new(PreparedSkyLight(*self)))
    }
}

/// The prepared integrator: just the settings.
#[derive(Debug)]
pub struct PreparedSkyLight(SkyLight);

impl PreparedIntegrator for PreparedSkyLight {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn capabilities(&self) -> Capabilities {
        self.0.capabilities()
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, _: &'a View) -> Box<dyn Tracer + 'a> {
        Box::new(SkyTracer {
            settings: self.0,
            scene,
            rays: RayBatch::default(),
            sky_rays: RayBatch::default(),
            hits: Vec::new(),
            lit: Vec::new(),
        })
    }
}

/// The state of one thread. Its lists keep their memory between batches, so that nothing is allocated per ray.
struct SkyTracer<'a> {
    settings: SkyLight,
    scene: &'a Scene,
    rays: RayBatch,
    sky_rays: RayBatch,
    hits: Vec<Option<Hit>>,
    /// For each sky ray: the sample, the direction, and the albedo of the surface that it leaves.
    lit: Vec<(usize, DVec3, Spectrum)>,
}

impl SkyTracer<'_> {
    /// A direction around the unit normal `n` with density cos θ / π.
    fn direction(id: &SampleId, n: DVec3) -> DVec3 {
        // A point on the disk, projected up to the hemisphere (Malley's method).
        let disk = concentric_disk(DVec2::from(OwenSobol::new(id).two(DIRECTION_SET)));
        let up = (1.0 - disk.length_squared()).max(0.0).sqrt();
        Frame::from_z(n).to_world(disk.extend(up))
    }

    /// The radiance of a camera ray that hits a surface, before the sky ray: black. Adds the sky ray to the batch.
    fn shade(&mut self, sample: usize, id: &SampleId, ray: &Ray, hit: &Hit) -> Radiance {
        let scene = self.scene;
        let surface = scene.surface(ray, hit);
        // Normals point out of the shape; the camera may be inside.
        let outside = surface.ng.dot(ray.direction) <= 0.0;
        let side = if outside { 1.0 } else { -1.0 };
        let direction = SkyTracer::direction(id, side * surface.ns);
        // A shading normal may lead into the surface: no sky is visible there.
        if side * direction.dot(surface.ng) > 0.0 {
            let albedo = scene.material_at(hit).base_color(scene, &surface, outside);
            let t_max = self.settings.distance;
            let sky_ray = Ray { t_max, ..Ray::new(surface.leave(direction), direction) };
            self.sky_rays.push_from(&sky_ray, &surface);
            self.sky_rays.set_time(self.sky_rays.len() - 1, ray.time);
            self.lit.push((sample, direction, albedo));
        }
        Radiance { color: Spectrum::BLACK, alpha: 1.0 }
    }
}

impl Tracer for SkyTracer<'_> {
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let scene = self.scene;
        out.clear();
        self.sky_rays.clear();
        self.lit.clear();

        // All camera rays together, then all sky rays: batches are faster than single rays, with the same hits.
        self.rays.copy(&samples.rays);
        scene.intersect_batch(&mut self.rays, &mut self.hits);
        stats.camera += samples.ids.len() as u64;
        for (i, id) in samples.ids.iter().enumerate() {
            let radiance = match (samples.rays.get(i), self.hits[i]) {
                (Some(ray), Some(hit)) => self.shade(i, id, &ray, &hit),
                (Some(_), None) if scene.background.transparent => Radiance::default(),
                (Some(ray), None) => Radiance { color: scene.background_radiance(ray.direction), alpha: 1.0 },
                (None, _) => Radiance::default(),
            };
            out.push(radiance);
        }

        scene.intersect_batch(&mut self.sky_rays, &mut self.hits);
        stats.shadow += self.lit.len() as u64;
        for ((sample, direction, albedo), hit) in self.lit.iter().zip(&self.hits) {
            if hit.is_none() {
                out[*sample].color = *albedo * scene.background_radiance(*direction);
            }
        }
    }
}
