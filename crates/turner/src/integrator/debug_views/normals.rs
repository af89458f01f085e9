//! Normals as colours.

use super::{DebugView, FirstHit, background_radiance, values};
use crate::integrator::{Radiance, RayStats};
use crate::math::Ray;
use crate::scene::Scene;
use crate::schema::{choice, params};

choice! {
    /// Which normal is shown.
    pub enum NormalKind {
        /// The shading normal, flipped towards the viewer.
        Shading = "shading",
        /// The geometric normal, which points out of the shape.
        Geometric = "geometric",
    }
}

params! {
    /// Shows the world-space normal at the first hit as a colour: 0.5 + 0.5·(x, y, z).
    pub struct NormalsDesc as "normals" {
        /// Which normal is shown.
        normal: NormalKind = NormalKind::Shading;
    }
    example r#"[integrator]
type = "normals"
"#
}

impl DebugView for NormalsDesc {
    fn type_name(&self) -> &'static str {
        NormalsDesc::DOC.name
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let n = match self.normal {
            NormalKind::Geometric => hit.surface.ng,
            NormalKind::Shading => hit.normal(),
        };
        values((0.5 * n + 0.5).to_array())
    }

    fn at_miss(&self, scene: &Scene, ray: &Ray) -> Radiance {
        background_radiance(scene, ray)
    }
}
