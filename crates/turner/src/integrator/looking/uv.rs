//! Surface coordinates.

use super::{Look, Sight, numbers, shown};
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

impl Look for UvDesc {
    fn word(&self) -> &'static str {
        UvDesc::DOC.name
    }

    fn shown(&self, picture: &mut Picture) {
        shown::uv(picture);
    }

    fn at(&self, sight: &Sight<'_>, _: &mut RayStats) -> Radiance {
        let uv = sight.scene.texture_point(&sight.surface).uv;
        numbers([uv.x, uv.y, 0.0])
    }
}
