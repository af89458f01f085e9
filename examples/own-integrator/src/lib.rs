//! An integrator of one's own, by the public interface of `turner` alone: every surface is diffuse, and lit by the sky it sees.
//!
//! A surface of albedo ρ under a sky of radiance L(ω) reflects ρ/π ∫ L(ω) V(ω) cos θ dω, where V is 1 for the directions ω in which nothing hides the sky.
//! Each camera sample takes one direction of density cos θ / π, so that its estimate is ρ L(ω) V(ω): the cosine and π cancel.
//!
//! [`SkyLight`] is the settings, [`PreparedSkyLight`] what is made of them for a scene, `SkyTracer` what a thread works with.

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

/// Which of a sample's random numbers choose the direction: a number of our own, apart from those of the place in the pixel and on the lens.
const DIRECTION_SET: u32 = 0x5c1;

/// Diffuse surfaces under the light of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyLight {
    /// What is farther away than this hides no sky, in units of the scene; greater than 0.
    pub distance: f64,
}

impl Default for SkyLight {
    /// Everything hides the sky, however far away.
    fn default() -> SkyLight {
        SkyLight { distance: f64::INFINITY }
    }
}

impl Integrator for SkyLight {
    fn name(&self) -> &str {
        "sky-light"
    }

    fn capabilities(&self) -> Capabilities {
        // It asks materials for their base colour alone, and lights for nothing.
        Capabilities::default()
    }

    fn prepare(&self, _: &Scene, _: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        // An integrator with tables (a photon map, a guide) makes them here, once for all threads.
        Ok(Arc::new(PreparedSkyLight(*self)))
    }
}

/// The integrator, ready. There is nothing to get ready: it is the settings.
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

/// One thread's work. Its lists keep their memory from batch to batch, so that nothing is allocated per ray.
struct SkyTracer<'a> {
    settings: SkyLight,
    scene: &'a Scene,
    rays: RayBatch,
    sky_rays: RayBatch,
    hits: Vec<Option<Hit>>,
    /// For each sky ray its sample, its direction, and the albedo of the surface that it leaves.
    lit: Vec<(usize, DVec3, Spectrum)>,
}

impl SkyTracer<'_> {
    /// The direction in which a sample looks for the sky from a surface of unit normal `n`: density cos θ / π.
    fn direction(id: &SampleId, n: DVec3) -> DVec3 {
        // A point of the disk, moved up to the hemisphere (Malley's method).
        let disk = concentric_disk(DVec2::from(OwenSobol::new(id).two(DIRECTION_SET)));
        let up = (1.0 - disk.length_squared()).max(0.0).sqrt();
        Frame::from_z(n).to_world(disk.extend(up))
    }

    /// What a camera ray shows that met a surface, but for the light of the sky: black. The sky ray joins the batch.
    fn shade(&mut self, sample: usize, id: &SampleId, ray: &Ray, hit: &Hit) -> Radiance {
        let scene = self.scene;
        let surface = scene.surface(ray, hit);
        // Normals point out of the shape; the camera may be inside.
        let outside = surface.ng.dot(ray.direction) <= 0.0;
        let side = if outside { 1.0 } else { -1.0 };
        let direction = SkyTracer::direction(id, side * surface.ns);
        // A shading normal may lead a ray into the surface: there is no sky.
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

        // All camera rays together, then all sky rays: eight at a time are faster than one by one, and the same hits.
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
