//! How much there is to do for a ray.

use super::{DebugView, FirstHit, numbers, shown};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::math::Ray;
use crate::scene::Scene;
use crate::schema::params;

params! {
    /// Shows what the search for the first hit goes through: the boxes of the trees that the ray enters before its hit, and what has to be tested in
    /// them, as a heat map. It is the least that a search has to look at which finds nearer things first; counted apart from the searches that
    /// render, it is the same for every set of instructions. EXR files hold the sum in red, boxes in green, shapes and blocks of
    /// eight triangles in blue. PNG goes from black (nothing) to pale yellow (the most in the picture).
    pub struct CostDesc as "cost" {
    }
    example r#"[integrator]
type = "cost"
"#
}

impl DebugView for CostDesc {
    fn word(&self) -> &'static str {
        CostDesc::DOC.name
    }

    fn shown(&self, picture: &mut Picture) {
        shown::cost(picture);
    }

    fn shows_search(&self) -> bool {
        true
    }

    fn at(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        of(hit.scene, &Ray { t_max: hit.hit.shape.t, ..hit.ray })
    }

    fn beyond(&self, scene: &Scene, ray: &Ray) -> Radiance {
        of(scene, ray)
    }
}

fn of(scene: &Scene, ray: &Ray) -> Radiance {
    let cost = scene.search_cost(ray);
    numbers([(cost.boxes + cost.tests) as f64, cost.boxes as f64, cost.tests as f64])
}
