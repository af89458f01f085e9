//! Normals as colours, for looking at geometry.

use super::{CameraSamples, Integrator, Radiance, RayStats, Tracer};
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
    fn tracer<'a>(&'a self, scene: &'a Scene) -> Box<dyn Tracer + 'a> {
        Box::new(Normals { normal: self.normal, scene })
    }
}

struct Normals<'a> {
    normal: NormalKind,
    scene: &'a Scene,
}

impl Tracer for Normals<'_> {
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let scene = self.scene;
        stats.camera += samples.ids.len() as u64;
        out.clear();
        let rays = (0..samples.ids.len()).filter_map(|i| samples.rays.get(i));
        out.extend(rays.map(|ray| match scene.intersect(&ray) {
            None if scene.background.transparent => Radiance { color: Spectrum::BLACK, alpha: 0.0 },
            None => Radiance { color: scene.surroundings(ray.direction), alpha: 1.0 },
            Some(hit) => {
                let surface = scene.surface(&ray, &hit);
                let n = match self.normal {
                    NormalKind::Geometric => surface.ng,
                    NormalKind::Shading if surface.ng.dot(ray.direction) > 0.0 => -surface.ns,
                    NormalKind::Shading => surface.ns,
                };
                let c = (0.5 * n + 0.5).to_array().map(|v| v as f32);
                Radiance { color: Spectrum::from(c), alpha: 1.0 }
            }
        }));
    }
}
