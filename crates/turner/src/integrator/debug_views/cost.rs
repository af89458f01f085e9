//! The cost of finding the first hit.

use super::{DebugView, FirstHit, display, values};
use crate::color::ColorScale;
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::math::Ray;
use crate::scene::Scene;
use crate::schema::params;

params! {
    /// Shows the traversal cost of the camera ray as a heat map: the BVH boxes that the ray enters before its
    /// first hit, and the primitive tests in them. This is the minimum for a front-to-back traversal. It is
    /// counted separately from rendering and is the same for every instruction set. EXR files hold the sum in
    /// red, boxes in green, and in blue tests of shapes and of blocks of eight triangles. PNG files range from
    /// black (none) to pale yellow (the maximum in the picture).
    pub struct CostDesc as "cost" {
    }
    example r#"[integrator]
type = "cost"
"#
}

impl DebugView for CostDesc {
    fn type_name(&self) -> &'static str {
        CostDesc::DOC.name
    }

    fn set_display(&self, picture: &mut Picture) {
        display::heat_from_0(picture);
    }

    fn scale(&self, picture: &Picture) -> Option<ColorScale> {
        Some(display::scale_from_0(picture, "boxes and tests"))
    }

    fn shows_search(&self) -> bool {
        true
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        of(hit.scene, &Ray { t_max: hit.hit.shape.t, ..hit.ray })
    }

    fn at_miss(&self, scene: &Scene, ray: &Ray) -> Radiance {
        of(scene, ray)
    }
}

fn of(scene: &Scene, ray: &Ray) -> Radiance {
    let cost = scene.search_cost(ray);
    values([(cost.boxes + cost.tests) as f64, cost.boxes as f64, cost.tests as f64])
}
