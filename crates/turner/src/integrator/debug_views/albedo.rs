//! Colours without light.

use super::{DebugView, FirstHit, background_radiance, opaque};
use crate::integrator::{Radiance, RayStats};
use crate::math::Ray;
use crate::scene::Scene;
use crate::schema::params;

params! {
    /// Shows the base colour of the material at the first hit, textures included, without light: what a denoiser wants beside the
    /// picture. Materials of a mix by their shares. It is a colour, and is shown as the film says.
    pub struct AlbedoDesc as "albedo" {
    }
    example r#"[integrator]
type = "albedo"
"#
}

impl DebugView for AlbedoDesc {
    fn word(&self) -> &'static str {
        AlbedoDesc::DOC.name
    }

    fn at(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let outside = hit.surface.ng.dot(hit.ray.direction) <= 0.0;
        opaque(hit.scene.material_at(&hit.hit).base_color(hit.scene, &hit.surface, outside))
    }

    fn beyond(&self, scene: &Scene, ray: &Ray) -> Radiance {
        background_radiance(scene, ray)
    }
}
