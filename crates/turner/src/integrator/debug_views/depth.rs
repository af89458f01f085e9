//! Depth of the first hit.

use super::{DebugView, FirstHit, display, values};
use crate::color::ColorScale;
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::math::DVec2;
use crate::schema::{choice, params};

choice! {
    /// How depth is measured.
    pub enum DepthMeasure {
        /// Along the camera ray.
        Distance = "distance",
        /// Along the viewing direction of the camera: constant over a plane that faces the camera.
        Axis = "axis",
    }
}

params! {
    /// Shows the distance from the origin of the camera ray to the first hit, in scene units. EXR and HDR files
    /// hold it in all three channels; EXR alpha is 0 where nothing is hit. PNG files show its reciprocal as a
    /// heat map: the nearest point pale yellow, the farthest black.
    pub struct DepthDesc as "depth" {
        /// How depth is measured.
        measure: DepthMeasure = DepthMeasure::Distance;
    }
    example r#"[integrator]
type = "depth"
measure = "axis"
"#
}

impl DebugView for DepthDesc {
    fn type_name(&self) -> &'static str {
        DepthDesc::DOC.name
    }

    fn set_display(&self, picture: &mut Picture) {
        display::depth(picture);
    }

    fn scale(&self, picture: &Picture) -> Option<ColorScale> {
        display::scale_of_depth(picture)
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let to_hit = hit.surface.p - hit.ray.origin;
        let depth = match self.measure {
            DepthMeasure::Distance => to_hit.length(),
            DepthMeasure::Axis => {
                let central_ray = hit.view.camera.ray(DVec2::ZERO, DVec2::splat(0.5));
                to_hit.dot(central_ray.direction.normalize())
            }
        };
        values([depth; 3])
    }
}
