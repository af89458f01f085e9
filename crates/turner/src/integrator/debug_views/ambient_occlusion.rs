//! How open the surroundings of a surface are.

use super::{DebugView, FirstHit, background_radiance, numbers, opaque};
use crate::color::Spectrum;
use crate::integrator::{Radiance, RayStats};
use crate::math::{DVec2, Ray};
use crate::sampler::{OwenSobol, SampleId, concentric_disk};
use crate::scene::Scene;
use crate::schema::{Range, params};

/// Random numbers of directions: apart from those of the place in the pixel and on the lens.
const SET: u32 = 0x00a0;

params! {
    /// Ambient occlusion: the share of the hemisphere over the first hit that is open, weighted by the cosine; 1 is wholly open. What casts
    /// a shadow closes it, tinted or not. A surface under an even sky is lit by just this share of it.
    pub struct AmbientOcclusionDesc as "ambient-occlusion" {
        /// How far away things still count, in the scene's units; 0 is any distance.
        distance: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Directions for each sample of a pixel, by scrambled Sobol points.
        samples: u32 = 16, in Range::closed(1.0, 65536.0);
    }
    example r#"[integrator]
type = "ambient-occlusion"
distance = 2
samples = 64
"#
}

impl DebugView for AmbientOcclusionDesc {
    fn word(&self) -> &'static str {
        AmbientOcclusionDesc::DOC.name
    }

    fn at(&self, hit: &FirstHit<'_>, stats: &mut RayStats) -> Radiance {
        let n = hit.normal();
        let (x, y) = n.any_orthonormal_pair();
        // The side that is seen, whatever the shading normal says.
        let side = if hit.surface.ng.dot(hit.ray.direction) > 0.0 { -1.0 } else { 1.0 };
        let mut open = 0u32;
        for i in 0..self.samples {
            let index = hit.id.index.wrapping_mul(self.samples).wrapping_add(i);
            let u = DVec2::from(OwenSobol::new(&SampleId { index, ..hit.id }).two(SET));
            let disk = concentric_disk(u);
            let up = (1.0 - disk.length_squared()).max(0.0).sqrt();
            let direction = disk.x * x + disk.y * y + up * n;
            if side * direction.dot(hit.surface.ng) <= 0.0 {
                // Into the surface.
                continue;
            }
            let t_max = if self.distance > 0.0 { self.distance } else { f64::INFINITY };
            let ray = Ray { t_max, time: hit.ray.time, ..Ray::new(hit.surface.leave(direction), direction) };
            stats.shadow += 1;
            open += u32::from(!hit.scene.occluded(&ray));
        }
        numbers([f64::from(open) / f64::from(self.samples); 3])
    }

    fn beyond(&self, scene: &Scene, ray: &Ray) -> Radiance {
        if scene.background.transparent { background_radiance(scene, ray) } else { opaque(Spectrum::WHITE) }
    }
}
