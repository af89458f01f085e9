//! Normals as colours, for looking at geometry.

use super::{CameraSample, Integrator, Radiance, RayStats};
use crate::color::Spectrum;
use crate::scene::Scene;
use crate::scene::schema::{choice, params};

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

impl Integrator for NormalsDesc {
    fn radiance(
        &self,
        scene: &Scene,
        samples: &[CameraSample],
        out: &mut Vec<Radiance>,
        stats: &mut RayStats,
    ) {
        for sample in samples {
            stats.camera += 1;
            out.push(match scene.intersect(&sample.ray) {
                None if scene.background.transparent => Radiance { color: Spectrum::BLACK, alpha: 0.0 },
                None => Radiance { color: scene.background.color(sample.ray.direction), alpha: 1.0 },
                Some(hit) => {
                    let surface = scene.surface(&sample.ray, &hit);
                    let n = match self.normal {
                        NormalKind::Geometric => surface.ng,
                        NormalKind::Shading if surface.ng.dot(sample.ray.direction) > 0.0 => -surface.ns,
                        NormalKind::Shading => surface.ns,
                    };
                    let c = (0.5 * n + 0.5).to_array().map(|v| v as f32);
                    Radiance { color: Spectrum::from(c), alpha: 1.0 }
                }
            });
        }
    }
}
