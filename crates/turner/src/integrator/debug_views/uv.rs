//! Texture coordinates.

use super::{DebugView, FirstHit, display, values};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::schema::params;

params! {
    /// Shows the texture coordinates (u, v) at the first hit as red and green. EXR files hold the values, with
    /// alpha 0 where nothing is hit. PNG files show their fractional parts, so repeats are visible.
    pub struct UvDesc as "uv" {
    }
    example r#"[integrator]
type = "uv"
"#
}

impl DebugView for UvDesc {
    fn type_name(&self) -> &'static str {
        UvDesc::DOC.name
    }

    fn set_display(&self, picture: &mut Picture) {
        display::uv(picture);
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let uv = hit.scene.texture_point(&hit.surface).uv;
        values([uv.x, uv.y, 0.0])
    }
}
