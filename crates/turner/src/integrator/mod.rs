//! Integrators: how much light comes along a camera ray. One file each; [`IntegratorDesc`] is the table of their
//! names in a scene.

pub mod classic;
mod looking;
pub mod path;

pub use classic::{AtDepth, ClassicDesc, Combine, Facing, Highlight, Miss};
pub use looking::shown::show;
pub use looking::{
    AlbedoDesc, AmbientOcclusionDesc, CostDesc, DepthDesc, DepthMeasure, IdsDesc, NormalKind, NormalsDesc,
    PositionDesc, UvDesc, WireframeDesc,
};
pub use path::{DirectDesc, LightSampling, PathDesc};

use turner_bvh::lanes::Block;

use crate::color::Spectrum;
use crate::sampler::SampleId;
use crate::scene::schema::family;
use crate::scene::{RayBatch, Scene};

family! {
    /// Integrators: `[integrator]`. The `type` is "classic" unless given.
    pub enum IntegratorDesc as "integrator", "integrators" {
        Classic(ClassicDesc),
        Path(PathDesc),
        Direct(DirectDesc),
        Normals(NormalsDesc),
        Depth(DepthDesc),
        Position(PositionDesc),
        Uv(UvDesc),
        Albedo(AlbedoDesc),
        Ids(IdsDesc),
        Wireframe(WireframeDesc),
        AmbientOcclusion(AmbientOcclusionDesc),
        Cost(CostDesc),
    }
}

/// Points of the picture to be coloured.
#[derive(Default)]
pub struct CameraSamples {
    /// What their random numbers depend on.
    pub ids: Vec<SampleId>,
    /// The camera rays, of unit direction.
    pub rays: RayBatch,
    /// The lengths of the directions as the camera formed them, from the eye to the screen: the classic documents
    /// measure t in them.
    pub lengths: Vec<Block>,
}

impl CameraSamples {
    /// Takes all out.
    pub fn clear(&mut self) {
        self.ids.clear();
        self.rays.clear();
        self.lengths.clear();
    }
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

/// How much light comes along camera rays.
pub trait Integrator: Sync {
    /// What a thread needs for its work on a scene.
    fn tracer<'a>(&'a self, scene: &'a Scene) -> Box<dyn Tracer + 'a>;
}

/// An integrator at work in one thread; keeps its memory from batch to batch, and nothing else.
pub trait Tracer {
    /// Replaces what is in `out` by one result per sample. A sample's result depends on nothing but itself.
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats);
}

impl IntegratorDesc {
    /// As the integrator it describes.
    pub fn integrator(&self) -> &dyn Integrator {
        match self {
            IntegratorDesc::Classic(i) => i,
            IntegratorDesc::Path(i) => i,
            IntegratorDesc::Direct(i) => i,
            IntegratorDesc::Normals(i) => i,
            IntegratorDesc::Depth(i) => i,
            IntegratorDesc::Position(i) => i,
            IntegratorDesc::Uv(i) => i,
            IntegratorDesc::Albedo(i) => i,
            IntegratorDesc::Ids(i) => i,
            IntegratorDesc::Wireframe(i) => i,
            IntegratorDesc::AmbientOcclusion(i) => i,
            IntegratorDesc::Cost(i) => i,
        }
    }

    /// Whether what is dimmer than the mean of an environment may be left to rays that hit it by chance.
    pub fn compensates(&self) -> bool {
        match self {
            IntegratorDesc::Path(i) => i.light_sampling == LightSampling::Both,
            IntegratorDesc::Direct(i) => i.light_sampling == LightSampling::Both,
            _ => false,
        }
    }

    /// Whether it shows things rather than light: lights are then not missed.
    pub fn is_for_looking(&self) -> bool {
        !matches!(self, IntegratorDesc::Classic(_) | IntegratorDesc::Path(_) | IntegratorDesc::Direct(_))
    }

    /// Whether it follows light: such integrators take all materials as physical ones and choose among all that shines, and their
    /// samples are placed by Sobol points.
    pub fn is_physical(&self) -> bool {
        matches!(self, IntegratorDesc::Path(_) | IntegratorDesc::Direct(_))
    }
}
