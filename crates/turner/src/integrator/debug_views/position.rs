//! Positions of the first hits.

use super::{DebugView, FirstHit, display, values};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::schema::params;

params! {
    /// Shows the world-space position of the first hit: x, y and z as red, green and blue, in scene units. EXR
    /// files hold the values, with alpha 0 where nothing is hit. PNG files scale each axis from its smallest to
    /// its largest value in the picture.
    pub struct PositionDesc as "position" {
    }
    example r#"[integrator]
type = "position"
"#
}

impl DebugView for PositionDesc {
    fn type_name(&self) -> &'static str {
        PositionDesc::DOC.name
    }

    fn set_display(&self, picture: &mut Picture) {
        display::position(picture);
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        values(hit.surface.p.to_array())
    }
}
