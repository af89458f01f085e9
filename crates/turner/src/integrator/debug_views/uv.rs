//! Surface coordinates.

use super::{DebugView, FirstHit, numbers, shown};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::schema::params;

params! {
    /// Shows (u, v) at the first hit as red and green. EXR files hold the numbers, with alpha 0 where nothing is hit; PNG shows what is behind
    /// their decimal points, so that pictures which repeat are seen to.
    pub struct UvDesc as "uv" {
    }
    example r#"[integrator]
type = "uv"
"#
}

impl DebugView for UvDesc {
    fn word(&self) -> &'static str {
        UvDesc::DOC.name
    }

    fn shown(&self, picture: &mut Picture) {
        shown::uv(picture);
    }

    fn at(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let uv = hit.scene.texture_point(&hit.surface).uv;
        numbers([uv.x, uv.y, 0.0])
    }
}
