//! Base colour of the material, without light.

use super::{DebugView, FirstHit, background_radiance, opaque};
use crate::integrator::{Radiance, RayStats};
use crate::math::Ray;
use crate::scene::Scene;
use crate::schema::params;

params! {
    /// Shows the base colour of the material at the first hit, with textures and without light, as an input for a
    /// denoiser. The colours of mixed materials are averaged by their weights. The result is a colour and follows
    /// the film's settings.
    pub struct AlbedoDesc as "albedo" {
    }
    example r#"[integrator]
type = "albedo"
"#
}

impl DebugView for AlbedoDesc {
    fn type_name(&self) -> &'static str {
        AlbedoDesc::DOC.name
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let outside = hit.surface.ng.dot(hit.ray.direction) <= 0.0;
        opaque(hit.scene.material_at(&hit.hit).base_color(hit.scene, &hit.surface, outside))
    }

    fn at_miss(&self, scene: &Scene, ray: &Ray) -> Radiance {
        background_radiance(scene, ray)
    }
}
