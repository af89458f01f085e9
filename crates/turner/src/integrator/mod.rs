//! Integrators: they compute the radiance that arrives along camera rays.
//!
//! The trait is open: other crates add integrators by implementing it. Three traits follow one another.
//!
//! ```text
//! Integrator           plain settings, for example `PathDesc`
//!   │ prepare(scene, view)        once per scene, view and settings
//!   ▼
//! PreparedIntegrator   shared by all threads
//!   │ choose(scene, view)         once, before the first sample: short measured tests
//!   │ tracer(scene, view)         once per worker and pass
//!   ▼
//! Tracer               one per worker, with its buffers
//!     radiance(samples, …)        for each batch of camera samples: one `Radiance` per sample
//! ```
//!
//! [`Preparer`](crate::prepare::Preparer) calls `prepare`. [`Renderer`](crate::Renderer) calls `choose` when the
//! first pass begins, makes a tracer in each worker, and calls `radiance` for the samples of one tile at a time. It adds the
//! results to the film. An integrator that traces light paths also hands out [`LightTracer`]s, one per worker; their
//! contributions are splatted. With photons, the light paths of a sample index come first, then its camera samples.
//!
//! [`IntegratorDesc`] lists the built-in integrators by their names in scene files; each has a file or folder of
//! its own.

pub mod aovs;
pub mod classic;
mod debug_views;
mod first_hits;
mod footprint;
pub mod path;
mod probing;
mod ray_counts;
mod tasks;

pub use crate::view::CameraSamples;
pub use classic::{AtDepth, ClassicDesc, Combine, Facing, Highlight, Miss};
pub use debug_views::{
    AlbedoDesc, AmbientOcclusionDesc, BouncesDesc, CostDesc, DepthDesc, DepthMeasure, IdsDesc, NormalKind,
    NormalsDesc, PositionDesc, UvDesc, WireframeDesc,
};
pub use path::{
    Caustics, DirectDesc, LightSampling, PathDesc, PathIntegrator, Photon, PhotonMap, SharedPathsMode,
};

use std::ops::Range;
use std::sync::Arc;

use crate::camera::CameraDesc;
use crate::color::{ColorScale, Spectrum};
use crate::film::{Antialias, Picture, Splat};
use crate::scene::{Hit, Scene};
use crate::schema::{SceneError, Warning, family};
use crate::view::{View, ViewSampling};

family! {
    /// Integrators: `[integrator]`. The default `type` is "classic".
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
        Bounces(BouncesDesc),
    }
}

/// The radiance along one camera ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radiance {
    /// Radiance times coverage.
    pub color: Spectrum,
    /// Coverage, 0..=1: 0 where the ray reached a transparent background.
    pub alpha: f32,
}

/// Parts of the radiance along a camera ray, times coverage. What remains is indirect light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightParts {
    /// From emitters and background that the ray reaches itself.
    pub emission: Spectrum,
    /// Scattered once on its way.
    pub direct: Spectrum,
}

/// Parts of the radiance along a camera ray, times coverage, by the lobe of the first surface that scatters it on its way
/// to the camera. What remains besides [`LightParts::emission`] is indirect light that is reflected diffusely.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LobeParts {
    /// Scattered once, by a diffuse reflection.
    pub direct_diffuse: Spectrum,
    /// Scattered once, by any other reflection: specular, coat, fuzz.
    pub direct_specular: Spectrum,
    /// Scattered more than once, at last by a reflection that is not diffuse.
    pub indirect_specular: Spectrum,
    /// Transmitted by the first surface.
    pub transmission: Spectrum,
    /// Scattered by a participating medium before any surface.
    pub volume: Spectrum,
}

/// Details of samples that a [`Tracer`] may be asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AskedDetails {
    /// [`SampleDetails::parts`].
    pub parts: bool,
    /// [`SampleDetails::groups`].
    pub groups: bool,
    /// [`SampleDetails::rays`].
    pub rays: bool,
    /// [`SampleDetails::bounces`].
    pub bounces: bool,
    /// [`SampleDetails::lobes`].
    pub lobes: bool,
    /// [`SampleDetails::hits`].
    pub hits: bool,
    /// [`SampleDetails::denoising`].
    pub denoising: bool,
}

/// Details of the samples of a batch. Each list is empty if the integrator does not know it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleDetails<'a> {
    /// Parts of the radiance, one entry for each sample.
    pub parts: &'a [LightParts],
    /// The radiance that comes from each light group, times coverage: for each sample one value for each of
    /// [`LightGroups::names`](crate::scene::LightGroups::names). What remains comes from no group.
    pub groups: &'a [Spectrum],
    /// For each sample the number of its rays: the camera ray, those that continue its path, and shadow rays.
    pub rays: &'a [u32],
    /// For each sample the number of bounces of its path.
    pub bounces: &'a [u32],
    /// Parts of the radiance by the first surface that scatters it, one entry for each sample.
    pub lobes: &'a [LobeParts],
    /// For each sample what a shadow catcher received; empty without shadow catchers.
    pub caught: &'a [CaughtLight],
    /// For each sample what its camera ray hits first, whatever its opacity.
    pub hits: &'a [Option<Hit>],
    /// For each sample the surface that the denoiser is guided by.
    pub denoising: &'a [DenoisingSample],
}

/// The first surface of a path that is not polished, as the camera sees it by way of glass and mirrors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DenoisingSample {
    /// Throughput up to the surface times its base colour; throughput alone where the path leaves the scene.
    pub albedo: Spectrum,
    /// Shading normal, towards the viewer; 0 without a surface.
    pub normal: [f32; 3],
    /// Binary logarithm of the length of the path to the surface, in scene units; 0 without a surface.
    pub log_distance: f32,
    /// Whether there is a surface.
    pub is_hit: bool,
    /// Light that is seen directly or by way of glass and mirrors: emitters, background.
    pub emission: Spectrum,
}

impl DenoisingSample {
    /// The values of the channels of [`Aov::Denoising`](crate::film::Aov::Denoising), for a sample of this radiance. `by`
    /// is a factor of its light.
    pub(crate) fn values(&self, color: Spectrum, by: f32) -> [f32; 15] {
        let [r, g, b] = self.albedo.to_array();
        let [x, y, z] = self.normal;
        let emission = self.emission * by;
        let [er, eg, eb] = emission.to_array();
        let [e2, l2] = [emission, color - emission].map(|light| light.luminance() * light.luminance());
        let hit = f32::from(u8::from(self.is_hit));
        let distance = self.log_distance;
        let albedo = r * r + g * g + b * b;
        [r, g, b, x, y, z, distance, hit, er, eg, eb, e2, l2, albedo, distance * distance]
    }
}

/// The direct light that a shadow catcher receives at a sample, as luminance of the irradiance over π.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CaughtLight {
    /// Whether the camera sees a shadow catcher there.
    pub is_caught: bool,
    /// With the objects of the scene in the way.
    pub shadowed: f32,
    /// With nothing in the way but shadow catchers.
    pub unshadowed: f32,
}

/// Counts of rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayStats {
    /// Camera rays.
    pub camera: u64,
    /// Shadow rays.
    pub shadow: u64,
    /// Reflected rays.
    pub reflected: u64,
    /// Refracted rays.
    pub refracted: u64,
    /// Rays of light paths, including those that connect to the camera.
    pub light: u64,
    /// Samples whose ray tree was cut at the limit.
    pub dropped: u64,
}

impl RayStats {
    /// The number of all rays.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflected + self.refracted + self.light
    }

    /// Adds the counts of `o`.
    pub fn merge(&mut self, o: &RayStats) {
        self.camera += o.camera;
        self.shadow += o.shadow;
        self.reflected += o.reflected;
        self.refracted += o.refracted;
        self.light += o.light;
        self.dropped += o.dropped;
    }
}

/// What an integrator needs from a scene, and what it shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// It simulates physically based light transport: every material is prepared as an OpenPBR BSDF, lights and
    /// media are prepared for sampling, and samples use Sobol points.
    pub physical: bool,
    /// It allows MIS compensation (Karlík et al. 2019, "MIS Compensation"): light sampling may leave the parts of
    /// an environment below its mean radiance to BSDF-sampled rays.
    pub compensates: bool,
    /// It shows a property of the first hit instead of light, so a scene without lights is no reason for a
    /// warning.
    pub debug: bool,
    /// Pixels hold labels, such as the index of an object, which have no mean: each pixel then gets one sample through
    /// its centre, whatever the film asks for.
    pub labels: bool,
    /// It tells the kinds of light apart and counts the rays of each sample: [`Tracer::details`].
    pub splits_light: bool,
    /// It shows the cost of BVH traversal. After an edit, all BVHs are built as in a fresh preparation, however
    /// long that takes.
    pub shows_search: bool,
}

/// An algorithm that computes an image. Other crates implement this trait in the same way as this one;
/// `examples/own-integrator` in the sources is a complete example with a program and tests.
/// [`SceneDesc::prepare_with`](crate::SceneDesc::prepare_with) prepares a scene for an integrator, and a
/// [`Renderer`](crate::Renderer) renders it.
///
/// An integrator is plain settings. [`Integrator::prepare`] computes what depends on the scene and the view,
/// once. Its result creates a [`Tracer`] for each thread.
pub trait Integrator: Send + Sync {
    /// Its name in a scene file, for messages.
    fn name(&self) -> &str;

    /// What it needs from a scene.
    fn capabilities(&self) -> Capabilities;

    /// Prepares it for a scene and a view.
    ///
    /// Errors: those of the integrator. The built-in integrators return none.
    fn prepare(&self, scene: &Scene, view: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError>;
}

/// An integrator prepared for a scene and a view. All its functions receive the same scene and view that it was
/// prepared for.
pub trait PreparedIntegrator: std::any::Any + Send + Sync {
    /// The integrator's name, for messages.
    fn name(&self) -> &str;

    /// What it needs from a scene.
    fn capabilities(&self) -> Capabilities;

    /// Replaces the display values of a picture whose values are not colours, such as depths. By default the
    /// film's values stay.
    fn show(&self, _: &mut Picture) {}

    /// The scale of the colours of [`PreparedIntegrator::show`], if they stand for numbers.
    fn scale(&self, _: &Picture) -> Option<ColorScale> {
        None
    }

    /// Decides, by tracing some rays, what is efficient in this scene and view: whether pixels share paths, how many light
    /// paths are traced, how many lights are sampled. It is called before the first sample is traced. The choice does not
    /// depend on the number of threads (0: all available). Later calls return at once.
    fn choose(&self, _: &Scene, _: &View, _threads: usize) {}

    /// Whether all choices have been made.
    fn has_chosen(&self) -> bool {
        true
    }

    /// Whether samples are those of before the choices.
    fn keeps_samples(&self) -> bool {
        true
    }

    /// Creates the tracer of one thread.
    fn tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Box<dyn Tracer + 'a>;

    /// Creates a tracer that finds nothing but [`SampleDetails::denoising`] and the shadow catchers of
    /// [`SampleDetails::caught`], without their light: paths end where these are known. `None` if the integrator does not
    /// know them.
    fn guide_tracer<'a>(&'a self, _: &'a Scene, _: &'a View) -> Option<Box<dyn Tracer + 'a>> {
        None
    }

    /// The number of pixels whose samples use one another's paths: 4, 8 or 16 in a cell of 8 x 8; 1 if samples are
    /// independent.
    fn cluster(&self) -> u32 {
        1
    }

    /// Whether samples also use the paths of neighbouring pixels.
    fn shares_paths(&self) -> bool {
        self.cluster() > 1
    }

    /// The number of light paths per sample index of the image.
    fn light_paths(&self) -> u64 {
        0
    }

    /// Whether camera samples merge with photons: those of the light paths with the same sample index.
    fn finds_photons(&self) -> bool {
        false
    }

    /// The photons of a sample index, traced in this thread for a sample on its own; `None` without photons. Those of the
    /// last such sample are kept.
    fn photons(&self, _: &Scene, _: &View, _: u32) -> Option<Arc<PhotonMap>> {
        None
    }

    /// Builds the photon map of a sample index from the photons of its light paths; `None` without photons.
    fn photon_map(&self, _: u32, _: Vec<Photon>) -> Option<PhotonMap> {
        None
    }

    /// Creates the light tracer of one thread; `None` without light paths.
    fn light_tracer<'a>(&'a self, _: &'a Scene, _: &'a View) -> Option<Box<dyn LightTracer + 'a>> {
        None
    }
}

/// A scene, a view and an integrator, prepared for each other: everything a renderer needs. Copies share their
/// data.
#[derive(Clone)]
pub struct Prepared {
    /// Geometry, materials and lights.
    pub scene: Arc<Scene>,
    /// Camera and film settings.
    pub view: View,
    /// The light transport algorithm.
    pub integrator: Arc<dyn PreparedIntegrator>,
    /// What was ignored or is doubtful in the scene.
    pub warnings: Vec<Warning>,
}

impl Prepared {
    /// The same scene and view with another integrator. It must not need more of the scene than the integrator
    /// that the scene was prepared for. For example, physically based materials exist only if
    /// [`Capabilities::physical`] was set.
    ///
    /// Errors: those of the integrator's preparation.
    pub fn with_integrator(&self, integrator: &dyn Integrator) -> Result<Prepared, SceneError> {
        let Capabilities { physical, debug, labels, .. } = integrator.capabilities();
        let weighted = self.view.camera.has_weights() && !debug;
        let mut view = View { sobol: physical, weighted, labels, ..self.view.clone() };
        if labels {
            view.film.antialias = Antialias::None;
        }
        let integrator = integrator.prepare(&self.scene, &view)?;
        integrator.choose(&self.scene, &view, 1);
        Ok(Prepared { integrator, view, ..self.clone() })
    }

    /// The same scene and film with another camera. The integrator repeats its choices for the new view (light
    /// paths, shared paths).
    ///
    /// Errors: an invalid camera; those of the integrator's preparation.
    pub fn with_camera(
        &self,
        camera: CameraDesc,
        integrator: &dyn Integrator,
    ) -> Result<Prepared, SceneError> {
        let View { sobol, labels, .. } = self.view;
        let sampling = ViewSampling {
            sobol,
            filtered: self.view.pixel_cone.is_some(),
            moves: self.scene.moves,
            weighted: !integrator.capabilities().debug,
            labels,
            instruction_set: self.scene.instruction_set,
        };
        let view = View::new(camera, self.view.film.clone(), sampling)?;
        let integrator = integrator.prepare(&self.scene, &view)?;
        integrator.choose(&self.scene, &view, 1);
        Ok(Prepared { integrator, view, ..self.clone() })
    }

    /// Lets the integrator make its choices if it has not: [`PreparedIntegrator::choose`].
    pub fn choose(&self, threads: usize) {
        self.integrator.choose(&self.scene, &self.view, threads);
    }

    /// Creates the tracer of one thread.
    pub fn tracer(&self) -> Box<dyn Tracer + '_> {
        self.integrator.tracer(&self.scene, &self.view)
    }

    /// The integrator, if it is the path tracer.
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

/// Traces light paths in one thread. It reuses its buffers from batch to batch and keeps no other state.
pub trait LightTracer {
    /// Traces the light paths with these indices and appends their contributions to `splats`. A contribution
    /// depends only on the light path's index, the scene and the settings. The function polls `stop` from time to
    /// time and returns early if it is true. Returns whether all paths were traced; if not, the caller must
    /// discard the appended splats.
    fn trace(
        &mut self,
        paths: Range<u64>,
        stop: &dyn Fn() -> bool,
        splats: &mut Vec<Splat>,
        stats: &mut RayStats,
    ) -> bool;

    /// The photons of the last call of `trace`, in the order of the light paths.
    fn photons(&mut self) -> &mut Vec<Photon>;
}

/// Computes radiance in one thread. It reuses its buffers from batch to batch and keeps no other state.
pub trait Tracer {
    /// Replaces the contents of `out` with one result per sample, in order, and adds the number of rays traced to
    /// `stats`.
    ///
    /// A result depends only on the sample's id and ray, the scene and the settings. It does not depend on the
    /// other samples of the batch or on earlier batches, so an image is the same for any number of threads.
    /// Random numbers come from the sample's id ([`SampleId`](crate::sampler::SampleId),
    /// [`OwenSobol`](crate::sampler::OwenSobol)). Where the camera has no ray, for example outside the image
    /// circle of a fisheye, `t_max` is below 0 and the result is ignored.
    fn radiance(&mut self, samples: &CameraSamples, out: &mut Vec<Radiance>, stats: &mut RayStats);

    /// Sets the photon map for the following samples, which have its sample index.
    fn find_photons(&mut self, _: Arc<PhotonMap>) {}

    /// Asks for [details](Tracer::details) of the following samples.
    fn ask(&mut self, _: AskedDetails) {}

    /// Details of the samples of the last batch, as far as they were [asked](Tracer::ask) for and the integrator knows
    /// them.
    fn details(&self) -> SampleDetails<'_> {
        SampleDetails::default()
    }
}

impl IntegratorDesc {
    /// The integrator that this describes.
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
            IntegratorDesc::Bounces(i) => i,
        }
    }

    /// What it needs from a scene.
    pub fn capabilities(&self) -> Capabilities {
        self.integrator().capabilities()
    }
}

#[cfg(test)]
mod tests;
