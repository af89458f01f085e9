//! Integrators for looking at things: what is at the first hit of each camera ray, instead of light. One file each.
//!
//! The film holds numbers: EXR files have them as they are, with what was hit as alpha where a ray that hits nothing has no number
//! to give. [`shown`] makes a picture of those that are no colours.

mod albedo;
mod ambient_occlusion;
mod cost;
mod depth;
mod ids;
mod normals;
mod position;
pub(super) mod shown;
#[cfg(test)]
mod tests;
mod uv;
mod wireframe;

pub use albedo::AlbedoDesc;
pub use ambient_occlusion::AmbientOcclusionDesc;
pub use cost::CostDesc;
pub use depth::{DepthDesc, DepthMeasure};
pub use ids::IdsDesc;
pub use normals::{NormalKind, NormalsDesc};
pub use position::PositionDesc;
pub use uv::UvDesc;
pub use wireframe::WireframeDesc;

use std::sync::Arc;

use crate::color::Spectrum;
use crate::film::Picture;
use crate::integrator::{
    CameraSamples, Capabilities, Integrator, PreparedIntegrator, Radiance, RayStats, Tracer,
};
use crate::math::Ray;
use crate::sampler::SampleId;
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::schema::SceneError;
use crate::view::View;

/// A camera ray and what it met.
pub(super) struct FirstHit<'a> {
    scene: &'a Scene,
    view: &'a View,
    id: SampleId,
    ray: Ray,
    hit: Hit,
    surface: SurfaceInteraction,
}

impl FirstHit<'_> {
    /// The shading normal on the viewer's side.
    fn normal(&self) -> crate::math::DVec3 {
        if self.surface.ng.dot(self.ray.direction) > 0.0 { -self.surface.ns } else { self.surface.ns }
    }
}

/// What is shown of a hit, and where there is none.
pub(super) trait DebugView: Clone + Send + Sync + 'static {
    /// Its name in a scene.
    fn word(&self) -> &'static str;

    /// Replaces the display values of a picture whose numbers are no colours.
    fn shown(&self, _: &mut Picture) {}

    /// Whether it shows what searches go through.
    fn shows_search(&self) -> bool {
        false
    }

    /// Whether its numbers are labels, which have no mean.
    fn has_labels(&self) -> bool {
        false
    }

    /// At a hit; counts the rays that it takes.
    fn at(&self, hit: &FirstHit<'_>, stats: &mut RayStats) -> Radiance;

    /// Where a ray leaves the scene: without a word, nothing, which is transparent.
    fn beyond(&self, scene: &Scene, ray: &Ray) -> Radiance {
        let _ = (scene, ray);
        NOTHING
    }
}

/// No number.
const NOTHING: Radiance = Radiance { color: Spectrum::BLACK, alpha: 0.0 };

/// A colour that covers.
fn opaque(color: Spectrum) -> Radiance {
    Radiance { color, alpha: 1.0 }
}

/// Three numbers, in single precision.
fn numbers(values: [f64; 3]) -> Radiance {
    opaque(Spectrum::from(values.map(|v| v as f32)))
}

/// What a picture of light has there.
fn background_radiance(scene: &Scene, ray: &Ray) -> Radiance {
    if scene.background.transparent { NOTHING } else { opaque(scene.background_radiance(ray.direction)) }
}

impl<L: DebugView> Integrator for L {
    fn name(&self) -> &str {
        self.word()
    }

    fn capabilities(&self) -> Capabilities {
        let (labels, shows_search) = (self.has_labels(), self.shows_search());
        Capabilities { debug: true, labels, shows_search, ..Capabilities::default() }
    }

    fn prepare(&self, _: &Scene, _: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        Ok(Arc::new(DebugViewIntegrator(self.clone())))
    }
}

/// Shows the first hits of camera rays.
struct DebugViewIntegrator<L>(L);

impl<L: DebugView> PreparedIntegrator for DebugViewIntegrator<L> {
    fn name(&self) -> &str {
        self.0.word()
    }

    fn capabilities(&self) -> Capabilities {
        self.0.capabilities()
    }

    fn show(&self, picture: &mut Picture) {
        self.0.shown(picture);
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Box<dyn Tracer + 'a> {
        Box::new(DebugViewTracer { shown: &self.0, scene, view })
    }
}

struct DebugViewTracer<'a, L> {
    shown: &'a L,
    scene: &'a Scene,
    view: &'a View,
}

impl<L: DebugView> Tracer for DebugViewTracer<'_, L> {
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let (scene, view) = (self.scene, self.view);
        stats.camera += samples.ids.len() as u64;
        out.clear();
        let rays = samples.ids.iter().enumerate().filter_map(|(i, id)| Some((*id, samples.rays.get(i)?)));
        out.extend(rays.map(|(id, ray)| match scene.intersect(&ray) {
            None => self.shown.beyond(scene, &ray),
            Some(hit) => {
                let surface = scene.surface(&ray, &hit);
                self.shown.at(&FirstHit { scene, view, id, ray, hit, surface }, stats)
            }
        }));
    }
}
