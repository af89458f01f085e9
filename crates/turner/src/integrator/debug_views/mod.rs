//! Debug views: integrators that show a property of the first hit of each camera ray instead of light. One file
//! each.
//!
//! The film holds the values. EXR files contain them unchanged, with alpha 0 where a ray hits nothing and the
//! view has no value. [`display`] turns values that are not colours into the colours of PNG and JPEG files.

mod albedo;
mod ambient_occlusion;
mod bounces;
mod cost;
mod depth;
pub(super) mod display;
mod ids;
mod normals;
mod position;
#[cfg(test)]
mod tests;
mod uv;
mod wireframe;

pub use albedo::AlbedoDesc;
pub use ambient_occlusion::AmbientOcclusionDesc;
pub use bounces::BouncesDesc;
pub use cost::CostDesc;
pub use depth::{DepthDesc, DepthMeasure};
pub use ids::IdsDesc;
pub use normals::{NormalKind, NormalsDesc};
pub use position::PositionDesc;
pub use uv::UvDesc;
pub use wireframe::WireframeDesc;

use std::sync::Arc;

use crate::color::{ColorScale, Spectrum};
use crate::film::Picture;
use crate::integrator::{
    CameraSamples, Capabilities, Integrator, PreparedIntegrator, Radiance, RayStats, Tracer,
};
use crate::math::Ray;
use crate::sampler::SampleId;
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::schema::SceneError;
use crate::view::View;

/// A camera ray and its first hit.
pub(super) struct FirstHit<'a> {
    scene: &'a Scene,
    view: &'a View,
    id: SampleId,
    ray: Ray,
    hit: Hit,
    surface: SurfaceInteraction,
}

impl FirstHit<'_> {
    /// The shading normal, flipped towards the viewer.
    fn normal(&self) -> crate::math::DVec3 {
        if self.surface.ng.dot(self.ray.direction) > 0.0 { -self.surface.ns } else { self.surface.ns }
    }
}

/// A property of the first hit.
pub(super) trait DebugView: Clone + Send + Sync + 'static {
    /// Its name in a scene file.
    fn type_name(&self) -> &'static str;

    /// Replaces the display values of a picture whose values are not colours.
    fn set_display(&self, _: &mut Picture) {}

    /// The scale of its display colours, if they stand for numbers.
    fn scale(&self, _: &Picture) -> Option<ColorScale> {
        None
    }

    /// Whether it shows the cost of traversal.
    fn shows_search(&self) -> bool {
        false
    }

    /// Whether its values are labels, which have no mean.
    fn has_labels(&self) -> bool {
        false
    }

    /// The value at a hit. Adds the rays that it traces to `stats`.
    fn at_hit(&self, hit: &FirstHit<'_>, stats: &mut RayStats) -> Radiance;

    /// The value where a ray hits nothing; transparent unless overridden.
    fn at_miss(&self, scene: &Scene, ray: &Ray) -> Radiance {
        let _ = (scene, ray);
        TRANSPARENT
    }
}

/// No value.
const TRANSPARENT: Radiance = Radiance { color: Spectrum::BLACK, alpha: 0.0 };

/// A colour with alpha 1.
fn opaque(color: Spectrum) -> Radiance {
    Radiance { color, alpha: 1.0 }
}

/// Three values, rounded to single precision.
fn values(values: [f64; 3]) -> Radiance {
    opaque(Spectrum::from(values.map(|v| v as f32)))
}

/// The background, as in a rendered image.
fn background_radiance(scene: &Scene, ray: &Ray) -> Radiance {
    if scene.background.transparent { TRANSPARENT } else { opaque(scene.background_radiance(ray.direction)) }
}

impl<D: DebugView> Integrator for D {
    fn name(&self) -> &str {
        self.type_name()
    }

    fn capabilities(&self) -> Capabilities {
        let (labels, shows_search) = (self.has_labels(), self.shows_search());
        Capabilities { debug: true, labels, shows_search, ..Capabilities::default() }
    }

    fn prepare(&self, _: &Scene, _: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        Ok(Arc::new(DebugViewIntegrator(self.clone())))
    }
}

/// The prepared form of every debug view.
struct DebugViewIntegrator<D>(D);

impl<D: DebugView> PreparedIntegrator for DebugViewIntegrator<D> {
    fn name(&self) -> &str {
        self.0.type_name()
    }

    fn capabilities(&self) -> Capabilities {
        self.0.capabilities()
    }

    fn show(&self, picture: &mut Picture) {
        self.0.set_display(picture);
    }

    fn scale(&self, picture: &Picture) -> Option<ColorScale> {
        self.0.scale(picture)
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Box<dyn Tracer + 'a> {
        Box::new(DebugViewTracer { debug_view: &self.0, scene, view })
    }
}

struct DebugViewTracer<'a, D> {
    debug_view: &'a D,
    scene: &'a Scene,
    view: &'a View,
}

impl<D: DebugView> Tracer for DebugViewTracer<'_, D> {
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats) {
        let (scene, view) = (self.scene, self.view);
        stats.camera += samples.ids.len() as u64;
        out.clear();
        let rays = samples.ids.iter().enumerate().filter_map(|(i, id)| Some((*id, samples.rays.get(i)?)));
        out.extend(rays.map(|(id, ray)| match scene.intersect_from_camera(&ray) {
            None => self.debug_view.at_miss(scene, &ray),
            Some(hit) => {
                let surface = scene.surface(&ray, &hit);
                self.debug_view.at_hit(&FirstHit { scene, view, id, ray, hit, surface }, stats)
            }
        }));
    }
}
