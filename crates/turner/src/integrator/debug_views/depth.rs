//! How far away things are.

use super::{DebugView, FirstHit, numbers, shown};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::math::DVec2;
use crate::schema::{choice, params};

choice! {
    /// What counts as depth.
    pub enum DepthMeasure {
        /// The length of the camera ray.
        Distance = "distance",
        /// Its part along the middle of the view: the same all over a plane that faces the camera.
        Axis = "axis",
    }
}

params! {
    /// Shows how far away the first hit is, in the scene's units, from where the camera ray begins. EXR and HDR files hold the number in all three
    /// channels, with alpha 0 where nothing is hit. PNG shows the reciprocal in colours: the nearest pale yellow, the farthest black.
    pub struct DepthDesc as "depth" {
        /// What counts as depth.
        measure: DepthMeasure = DepthMeasure::Distance;
    }
    example r#"[integrator]
type = "depth"
measure = "axis"
"#
}

impl DebugView for DepthDesc {
    fn word(&self) -> &'static str {
        DepthDesc::DOC.name
    }

    fn shown(&self, picture: &mut Picture) {
        shown::depth(picture);
    }

    fn at(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let way = hit.surface.p - hit.ray.origin;
        let depth = match self.measure {
            DepthMeasure::Distance => way.length(),
            DepthMeasure::Axis => {
                let middle = hit.view.camera.ray(DVec2::ZERO, DVec2::splat(0.5));
                way.dot(middle.direction.normalize())
            }
        };
        numbers([depth; 3])
    }
}
