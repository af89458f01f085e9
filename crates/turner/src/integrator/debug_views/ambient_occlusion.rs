//! Ambient occlusion: the cosine-weighted unoccluded fraction of the hemisphere.
//!
//! The estimator is the fraction of unoccluded rays among `samples` cosine-distributed directions.

use super::{DebugView, FirstHit, background_radiance, opaque, values};
use crate::color::Spectrum;
use crate::integrator::{Radiance, RayStats};
use crate::math::{DVec2, Ray};
use crate::sampler::{OwenSobol, SampleId, concentric_disk};
use crate::scene::Scene;
use crate::schema::{Range, params};

/// Sobol set of the directions, different from those of the pixel and the lens.
const SET: u32 = 0x00a0;

params! {
    /// Ambient occlusion: the fraction of the hemisphere above the first hit that is unoccluded, weighted by the
    /// cosine; 1 is fully open. Every object that casts shadows occludes, tinted shadows included. A uniform sky
    /// lights a surface with exactly this fraction of its light.
    pub struct AmbientOcclusionDesc as "ambient-occlusion" {
        /// Objects beyond this distance do not occlude, in scene units; 0 means no limit.
        distance: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Directions per pixel sample, from scrambled Sobol points.
        samples: u32 = 16, in Range::closed(1.0, 65536.0);
    }
    example r#"[integrator]
type = "ambient-occlusion"
distance = 2
samples = 64
"#
}

impl DebugView for AmbientOcclusionDesc {
    fn type_name(&self) -> &'static str {
        AmbientOcclusionDesc::DOC.name
    }

    fn at_hit(&self, hit: &FirstHit<'_>, stats: &mut RayStats) -> Radiance {
        let n = hit.normal();
        let (x, y) = n.any_orthonormal_pair();
        // The visible side of the surface by its geometric normal, whatever the shading normal is.
        let side = if hit.surface.ng.dot(hit.ray.direction) > 0.0 { -1.0 } else { 1.0 };
        let mut open = 0u32;
        for i in 0..self.samples {
            let index = hit.id.index.wrapping_mul(self.samples).wrapping_add(i);
            let u = DVec2::from(OwenSobol::new(&SampleId { index, ..hit.id }).two(SET));
            let disk = concentric_disk(u);
            let up = (1.0 - disk.length_squared()).max(0.0).sqrt();
            let direction = disk.x * x + disk.y * y + up * n;
            if side * direction.dot(hit.surface.ng) <= 0.0 {
                // Below the surface.
                continue;
            }
            let t_max = if self.distance > 0.0 { self.distance } else { f64::INFINITY };
            let ray = Ray { t_max, time: hit.ray.time, ..Ray::new(hit.surface.leave(direction), direction) };
            stats.shadow += 1;
            open += u32::from(!hit.scene.occluded(&ray));
        }
        values([f64::from(open) / f64::from(self.samples); 3])
    }

    fn at_miss(&self, scene: &Scene, ray: &Ray) -> Radiance {
        if scene.background.transparent { background_radiance(scene, ray) } else { opaque(Spectrum::WHITE) }
    }
}
