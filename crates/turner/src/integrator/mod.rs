//! Integrators: how much light comes along a camera ray. One file each; [`IntegratorDesc`] is the table of their
//! names in a scene.

pub mod classic;
mod debug_views;
mod footprint;
pub mod path;

pub use crate::view::CameraSamples;
pub use classic::{AtDepth, ClassicDesc, Combine, Facing, Highlight, Miss};
pub use debug_views::{
    AlbedoDesc, AmbientOcclusionDesc, CostDesc, DepthDesc, DepthMeasure, IdsDesc, NormalKind, NormalsDesc,
    PositionDesc, UvDesc, WireframeDesc,
};
pub use path::{
    Caustics, DirectDesc, LightSampling, PathDesc, PathIntegrator, Photon, PhotonMap, SharedPathsMode,
};

use std::ops::Range;
use std::sync::Arc;

use crate::camera::CameraDesc;
use crate::color::Spectrum;
use crate::film::{Antialias, Picture, Splat};
use crate::scene::Scene;
use crate::schema::{SceneError, Warning, family};
use crate::view::{View, ViewSampling};

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
    /// BsdfFromWo lights.
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

/// What an integrator needs of a scene, and what it shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// It follows light: all materials are taken as physical ones, lights can be chosen among, media are there, and samples are placed by Sobol points.
    pub physical: bool,
    /// What is dimmer than the mean of an environment may be left to rays that hit it (Karlík et al. 2019, "MIS compensation").
    pub compensates: bool,
    /// It shows what is at the first hit rather than light: lights are then not missed.
    pub debug: bool,
    /// Pixels hold labels, such as the index of an object, which have no mean: each pixel then gets one sample through its centre, whatever the film asks for.
    pub labels: bool,
    /// It shows what a search goes through: after an edit all trees are those of a fresh preparation, however long they take to build.
    pub shows_search: bool,
}

/// A way of computing a picture. Integrators of other crates implement it as well as those here: `examples/own-integrator` of the sources is a whole one, with a
/// program that renders by it and tests. [`SceneDesc::prepare_with`](crate::SceneDesc::prepare_with) prepares a scene for it, and a [`Renderer`](crate::Renderer) renders that.
///
/// An integrator is plain settings. What it needs to know of a scene and a view it finds out in [`Integrator::prepare`], once; the result makes a
/// [`Tracer`] for each thread.
pub trait Integrator: Send + Sync {
    /// Its name in a scene, for messages.
    fn name(&self) -> &str;

    /// What it needs of a scene.
    fn capabilities(&self) -> Capabilities;

    /// Makes it ready for a scene and a view.
    ///
    /// Errors: those of its own; the ones here have none.
    fn prepare(&self, scene: &Scene, view: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError>;
}

/// An integrator that is ready for a scene and a view. It is asked again and again with the scene and the view it was made for.
pub trait PreparedIntegrator: std::any::Any + Send + Sync {
    /// The integrator's name, for messages.
    fn name(&self) -> &str;

    /// What it needs of a scene.
    fn capabilities(&self) -> Capabilities;

    /// Replaces the display values of a picture whose numbers are no colours; others stay as the film has made them.
    fn show(&self, _: &mut Picture) {}

    /// Finds out what pays in this scene and view, by tracing some rays: whether pixels share paths, how many light paths there are. Asked once before the first
    /// sample is traced; the choice is the same on every run. Afterwards this returns at once.
    fn choose(&self, _: &Scene, _: &View) {}

    /// Whether there is nothing left to choose.
    fn has_chosen(&self) -> bool {
        true
    }

    /// What a thread needs for its work.
    fn tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Box<dyn Tracer + 'a>;

    /// Whether samples are made of what their neighbours' paths found as well.
    fn shares_paths(&self) -> bool {
        false
    }

    /// How many light paths there are to each sample of all pixels.
    fn light_paths(&self) -> u64 {
        0
    }

    /// Whether samples find photons: those of the light paths of their number.
    fn finds_photons(&self) -> bool {
        false
    }

    /// The photons of a sample's number, traced in this thread; `None` where samples find none.
    fn photons(&self, _: &Scene, _: &View, _: u32) -> Option<PhotonMap> {
        None
    }

    /// The photons of a sample's number that light paths left, ready to be found; `None` where samples find none.
    fn photon_map(&self, _: u32, _: Vec<Photon>) -> Option<PhotonMap> {
        None
    }

    /// What a thread needs for light paths, if there are any.
    fn light_tracer<'a>(&'a self, _: &'a Scene, _: &'a View) -> Option<Box<dyn LightTracer + 'a>> {
        None
    }
}

/// A scene, a view of it and an integrator, ready for each other: all that a picture is made of. Copies share what they have.
#[derive(Clone)]
pub struct Prepared {
    /// What there is.
    pub scene: Arc<Scene>,
    /// Who looks.
    pub view: View,
    /// How light is computed.
    pub integrator: Arc<dyn PreparedIntegrator>,
    /// What was dropped or doubtful while preparing.
    pub warnings: Vec<Warning>,
}

impl Prepared {
    /// The same scene and view with another integrator. It must not ask more of the scene than the one for which that was prepared: physical materials, for
    /// example, are there only if [`Capabilities::physical`] was asked for.
    ///
    /// Errors: those of the integrator's preparation.
    pub fn with_integrator(&self, integrator: &dyn Integrator) -> Result<Prepared, SceneError> {
        let Capabilities { physical, labels, .. } = integrator.capabilities();
        let mut view = View { sobol: physical, labels, ..self.view.clone() };
        if labels {
            view.film.antialias = Antialias::None;
        }
        let integrator = integrator.prepare(&self.scene, &view)?;
        integrator.choose(&self.scene, &view);
        Ok(Prepared { integrator, view, ..self.clone() })
    }

    /// The same scene and film seen by another camera. What the integrator finds out for a view (light paths, shared paths) it finds out again.
    ///
    /// Errors: a camera that sees nothing; those of the integrator's preparation.
    pub fn with_camera(
        &self,
        camera: CameraDesc,
        integrator: &dyn Integrator,
    ) -> Result<Prepared, SceneError> {
        let View { sobol, moves, labels, .. } = self.view;
        let sampling = ViewSampling {
            sobol,
            filtered: self.view.pixel_cone.is_some(),
            moves,
            labels,
            instruction_set: self.scene.instruction_set,
        };
        let view = View::new(camera, self.view.film.clone(), sampling)?;
        let integrator = integrator.prepare(&self.scene, &view)?;
        integrator.choose(&self.scene, &view);
        Ok(Prepared { integrator, view, ..self.clone() })
    }

    /// Lets the integrator find out what pays, if it has not yet: see [`PreparedIntegrator::choose`].
    pub fn choose(&self) {
        self.integrator.choose(&self.scene, &self.view);
    }

    /// What a thread needs to trace camera samples.
    pub fn tracer(&self) -> Box<dyn Tracer + '_> {
        self.integrator.tracer(&self.scene, &self.view)
    }

    /// The integrator, if it is a path tracer.
    pub fn path(&self) -> Option<&PathIntegrator> {
        let any: &dyn std::any::Any = &*self.integrator;
        any.downcast_ref()
    }
}

impl std::fmt::Debug for Prepared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Prepared")
            .field("integrator", &self.integrator.name())
            .field("view", &self.view)
            .finish_non_exhaustive()
    }
}

/// Traces light paths in one thread. Its buffers are reused from batch to batch; it keeps no other state.
pub trait LightTracer {
    /// Traces the light paths of these numbers and appends their contributions to `splats`. A light path's contribution depends on its number,
    /// the scene and the settings alone. `stop` says now and then whether to leave off. Returns whether all were traced; if not, what was appended does not count.
    fn trace(
        &mut self,
        paths: Range<u64>,
        stop: &dyn Fn() -> bool,
        splats: &mut Vec<Splat>,
        stats: &mut RayStats,
    ) -> bool;

    /// The photons of the last light paths, in the order of the paths where that is one.
    fn photons(&mut self) -> &mut Vec<Photon>;
}

/// Computes radiance in one thread. Its buffers are reused from batch to batch; it keeps no other state.
pub trait Tracer {
    /// Replaces the contents of `out` with one result per sample, in order, and adds the number of rays traced to `stats`.
    ///
    /// A result depends only on the sample's number and ray, the scene and the settings: not on the other samples of the batch, nor on earlier batches. This
    /// is why a picture is the same for any number of threads. Random numbers come from the sample's number ([`SampleId`](crate::sampler::SampleId),
    /// [`OwenSobol`](crate::sampler::OwenSobol)). Where the camera sees nothing, the ray's `t_max` is below 0 and its result is ignored.
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

    /// What it needs of a scene.
    pub fn capabilities(&self) -> Capabilities {
        self.integrator().capabilities()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrators_go_by_their_names_in_a_scene() {
        for entry in IntegratorDesc::DOC.entries {
            let desc = IntegratorDesc::of_type(entry.name).unwrap_or_default();
            assert_eq!(desc.integrator().name(), entry.name);
        }
    }
}
