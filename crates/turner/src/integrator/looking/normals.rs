//! Normals as colours, for looking at geometry.

use super::{Look, Sight, numbers, surroundings};
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

impl Look for NormalsDesc {
    fn word(&self) -> &'static str {
        NormalsDesc::DOC.name
    }

    fn at(&self, sight: &Sight<'_>, _: &mut RayStats) -> Radiance {
        let n = match self.normal {
            NormalKind::Geometric => sight.surface.ng,
            NormalKind::Shading => sight.normal(),
        };
        numbers((0.5 * n + 0.5).to_array())
    }

    fn beyond(&self, scene: &Scene, ray: &Ray) -> Radiance {
        surroundings(scene, ray)
    }
}
