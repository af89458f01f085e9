//! Integrators: how much light comes along a camera ray. One file each; [`IntegratorDesc`] is the table of their
//! names in a scene.

mod classic;
mod normals;

pub use classic::{AtDepth, ClassicDesc, Combine, Facing, Highlight, Miss};
pub use normals::{NormalKind, NormalsDesc};

use crate::color::Spectrum;
use crate::math::Ray;
use crate::sampler::SampleId;
use crate::scene::Scene;
use crate::scene::schema::family;

family! {
    /// Integrators: `[integrator]`. The `type` is "classic" unless given.
    pub enum IntegratorDesc as "integrator", "integrators" {
        Classic(ClassicDesc),
        Normals(NormalsDesc),
    }
}

/// A point of the picture to be coloured.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// What its random numbers depend on.
    pub id: SampleId,
    /// The camera ray, of unit direction.
    pub ray: Ray,
    /// The length of the direction as the camera formed it, from the eye to the screen: the classic documents
    /// measure t in it.
    pub length: f64,
}

/// What came along a camera ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radiance {
    /// Colour times coverage.
    pub color: Spectrum,
    /// Coverage: 0 where a transparent background was seen.
    pub alpha: f32,
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayStats {
    /// From the camera.
    pub camera: u64,
    /// Towards lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflected: u64,
    /// Refracted.
    pub refracted: u64,
    /// Samples whose tree of rays was cut at the limit.
    pub dropped: u64,
}

impl RayStats {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflected + self.refracted
    }

    /// Adds those of another part.
    pub fn merge(&mut self, o: &RayStats) {
        self.camera += o.camera;
        self.shadow += o.shadow;
        self.reflected += o.reflected;
        self.refracted += o.refracted;
        self.dropped += o.dropped;
    }
}

/// How much light comes along camera rays. Called once per batch; a sample's result depends on nothing but itself.
pub trait Integrator: Sync {
    /// Appends one result per sample to `out`.
    fn radiance(
        &self,
        scene: &Scene,
        samples: &[CameraSample],
        out: &mut Vec<Radiance>,
        stats: &mut RayStats,
    );
}

impl IntegratorDesc {
    /// As the integrator it describes.
    pub fn integrator(&self) -> &dyn Integrator {
        match self {
            IntegratorDesc::Classic(i) => i,
            IntegratorDesc::Normals(i) => i,
        }
    }
}
