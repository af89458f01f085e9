//! Colours without light.

use super::{Look, Sight, opaque, surroundings};
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

impl Look for AlbedoDesc {
    fn word(&self) -> &'static str {
        AlbedoDesc::DOC.name
    }

    fn at(&self, sight: &Sight<'_>, _: &mut RayStats) -> Radiance {
        let outside = sight.surface.ng.dot(sight.ray.direction) <= 0.0;
        opaque(sight.scene.material_at(&sight.hit).base_color(sight.scene, &sight.surface, outside))
    }

    fn beyond(&self, scene: &Scene, ray: &Ray) -> Radiance {
        surroundings(scene, ray)
    }
}
