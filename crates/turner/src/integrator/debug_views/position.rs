//! Where things are.

use super::{DebugView, FirstHit, numbers, shown};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::schema::params;

params! {
    /// Shows the first hit's place in the world: x, y and z as red, green and blue. EXR files hold the numbers, with alpha 0 where
    /// nothing is hit. PNG shows each axis from the least to the largest value in the picture.
    pub struct PositionDesc as "position" {
    }
    example r#"[integrator]
type = "position"
"#
}

impl DebugView for PositionDesc {
    fn word(&self) -> &'static str {
        PositionDesc::DOC.name
    }

    fn shown(&self, picture: &mut Picture) {
        shown::position(picture);
    }

    fn at(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        numbers(hit.surface.p.to_array())
    }
}
