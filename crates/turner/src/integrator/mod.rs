//! Integrators: how much light comes along a camera ray. One file each; [`IntegratorDesc`] is the table of their
//! names in a scene.

pub mod classic;
mod footprint;
mod looking;
pub mod path;

pub use classic::{AtDepth, ClassicDesc, Combine, Facing, Highlight, Miss};
pub use looking::shown::show;
pub use looking::{
    AlbedoDesc, AmbientOcclusionDesc, CostDesc, DepthDesc, DepthMeasure, IdsDesc, NormalKind, NormalsDesc,
    PositionDesc, UvDesc, WireframeDesc,
};
pub use path::{Caustics, DirectDesc, LightSampling, PathDesc, PathReuse, Photon, PhotonMap};

use std::sync::Arc;

use turner_bvh::lanes::Block;

use crate::color::Spectrum;
use crate::film::Splat;
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
    /// Of light paths, those to the camera included.
    pub light: u64,
    /// Samples whose tree of rays was cut at the limit.
    pub dropped: u64,
}

impl RayStats {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflected + self.refracted + self.light
    }

    /// Adds those of another part.
    pub fn merge(&mut self, o: &RayStats) {
        self.camera += o.camera;
        self.shadow += o.shadow;
        self.reflected += o.reflected;
        self.refracted += o.refracted;
        self.light += o.light;
        self.dropped += o.dropped;
    }
}

/// How much light comes along camera rays.
pub trait Integrator: Sync {
    /// What a thread needs for its work on a scene.
    fn tracer<'a>(&'a self, scene: &'a Scene) -> Box<dyn Tracer + 'a>;

    /// Whether samples are made of what their neighbours' paths found as well: those of [`path::group`].
    fn shares_paths(&self, _: &Scene) -> bool {
        false
    }

    /// How many light paths there are to each sample of all pixels.
    fn light_paths(&self, _: &Scene) -> u64 {
        0
    }

    /// Whether samples find photons: those of the light paths of their number.
    fn finds_photons(&self, _: &Scene) -> bool {
        false
    }

    /// The photons of a sample's number, traced in this thread; `None` where samples find none.
    fn photons(&self, _: &Scene, _: u32) -> Option<PhotonMap> {
        None
    }

    /// What a thread needs for light paths, if there are any.
    fn light_tracer<'a>(&'a self, _: &'a Scene) -> Option<Box<dyn LightTracer + 'a>> {
        None
    }
}

/// Light paths at work in one thread; keeps its memory from batch to batch, and nothing else.
pub trait LightTracer {
    /// Adds what the light paths of the numbers `first..first + count` bring to the picture. What a path brings depends on nothing but its number.
    fn trace(&mut self, first: u64, count: u32, splats: &mut Vec<Splat>, stats: &mut RayStats);

    /// The photons of the last light paths, in the order of the paths where that is one.
    fn photons(&mut self) -> &mut Vec<Photon>;
}

/// An integrator at work in one thread; keeps its memory from batch to batch, and nothing else.
pub trait Tracer {
    /// Replaces what is in `out` by one result per sample. A sample's result depends on nothing but itself.
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats);

    /// From now on samples are of the number for which these photons are, and find them.
    fn find_photons(&mut self, _: Arc<PhotonMap>) {}
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
