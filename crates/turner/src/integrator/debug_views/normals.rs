//! Normals as colours, for looking at geometry.

use super::{DebugView, FirstHit, background_radiance, numbers};
use crate::integrator::{Radiance, RayStats};
use crate::math::Ray;
use crate::scene::Scene;
use crate::schema::{choice, params};

choice! {
    /// Which normal is shown.
    pub enum NormalKind {
        /// The shading normal, turned towards the viewer.
        Shading = "shading",
        /// The geometric normal, as it points out of the shape.
        Geometric = "geometric",
    }
}

params! {
    /// Shows the normal at the first hit as a colour: 0.5 + 0.5·(x, y, z).
    pub struct NormalsDesc as "normals" {
        /// Which normal.
        normal: NormalKind = NormalKind::Shading;
    }
    example r#"[integrator]
type = "normals"
"#
}

impl DebugView for NormalsDesc {
    fn word(&self) -> &'static str {
        NormalsDesc::DOC.name
    }

    fn at(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let n = match self.normal {
            NormalKind::Geometric => hit.surface.ng,
            NormalKind::Shading => hit.normal(),
        };
        numbers((0.5 * n + 0.5).to_array())
    }

    fn beyond(&self, scene: &Scene, ray: &Ray) -> Radiance {
        background_radiance(scene, ray)
    }
}
