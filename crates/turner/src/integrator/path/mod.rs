//! Unidirectional path tracing (Kajiya 1986, "The rendering equation").
//!
//! ```text
//!  camera          light
//!     o              *
//!      \            /        beta  = product over vertices of f·|cos| / pdf (throughput)
//!       \          / shadow
//!        \        /  ray     L    += beta · emission at each hit            (weight w_bsdf)
//!        x1 ---> x2 ---> x3  L    += beta · f·|cos| · Le / pdf_light at x2  (weight w_light)
//! ```
//!
//! At each vertex one light is sampled (next-event estimation, NEE) and one direction is sampled from the BSDF. An
//! emitter that both can find is counted by both, with the weights of the power heuristic, exponent 2 (Veach & Guibas
//! 1995), so that the sum stays unbiased. Random numbers are Owen-scrambled Sobol points. The paths of a tile advance
//! together, one bounce at a time (`path_batch`), so that rays are traced in batches; the result of a path does not
//! depend on the others in its batch.
//!
//! Extensions: light paths for caustics (`caustics`), paths shared between pixels (`shared_paths`), adaptive sampling of
//! environments (`learn_environment`), participating media (`volume`), random-walk subsurface scattering (`subsurface`),
//! dispersion, resampling of lights (`light_resampling`) and a SIMD path for simple vertices (`simd_shading`).

mod caustics;
#[cfg(test)]
mod closed_form_tests;
mod dispersion;
mod emission;
mod group_split;
mod guides;
mod learn_environment;
mod light_resampling;
mod light_samples;
mod light_split;
mod lobe_split;
mod media;
mod notes;
mod pane;
mod path_batch;
mod pilot_run;
mod ray_queue;
mod record;
mod replay;
mod roulette;
mod settings;
mod shade;
mod shadow_catcher;
mod shadow_rays;
mod shared_paths;
mod simd_shading;
mod subsurface;
#[cfg(test)]
mod tests;
mod volume;
mod volume_light;

pub use record::{
    DonorPart, DonorRecord, EmissionRecord, End, EscapeRecord, InfiniteLightRecord, LightRecord,
    MediumSegmentRecord, Passage, PathRecord, PhotonsRecord, RandomWalkRecord, Roulette, ScatterRecord,
    SharedRecord, VertexRecord,
};
pub use replay::{replay, replay_at};
pub(crate) use shared_paths::{CELL, cluster};

pub use caustics::{Caustics, CausticsStrategy, Gathered, Photon, PhotonMap};

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use learn_environment::{Learned, Sky};
use settings::Settings;
use shared_paths::Sharing;

use crate::integrator::{Capabilities, Integrator, LightTracer, PreparedIntegrator, Tracer};
use crate::light::AdaptiveEnvironment;
use crate::scene::Scene;
use crate::schema::{Range, SceneError, choice, params};
use crate::view::View;

choice! {
    /// How direct light is estimated. The settings differ in noise only, except for lights that a ray cannot hit.
    pub enum LightSampling {
        /// By sampling lights and by BSDF-sampled rays that hit them, combined by the power heuristic.
        Both = "both",
        /// By BSDF-sampled rays alone: point and directional lights have no effect.
        Bsdf = "bsdf",
        /// By sampling lights alone, for every light that can be sampled.
        Light = "light",
    }
}

choice! {
    /// Whether neighbouring pixels share their paths.
    pub enum SharedPathsMode {
        /// Where a short test finds a gain, which is typical of rooms. The mean is the same; the
        /// noise of indirect light is that of many times as many samples.
        Auto = "auto",
        /// Wherever possible. Not possible with motion blur, participating media, light paths, `clamp_indirect`,
        /// Russian roulette from the first bounce on, or adaptive anti-aliasing.
        Always = "always",
        /// Each path contributes to its own pixel only.
        Off = "off",
    }
}

params! {
    /// Path tracing: physically based light transport between all surfaces, materials and lights. Noise falls with the
    /// number of samples per pixel: set `samples` in `[film]`.
    ///
    /// Units: the emission of a surface is radiance. The `intensity` of a light is the irradiance at a surface that
    /// faces it, after attenuation (with "inverse-square" it is radiant intensity). A Lambertian surface of albedo C
    /// reflects C/π of it: 1/π of what the classic integrator returns. The lights "rectangle", "disk" and "sphere"
    /// consist of points that emit equally in all directions, and are invisible, as in the classic integrator; for a
    /// visible area light give an object a material with emission. A ray that hits nothing sees the environment map, or
    /// else the background, which lights the scene as well. An ambient light is constant over all directions and
    /// invisible.
    pub struct PathDesc as "path" {
        /// Maximum number of bounces of a path. 0 shows emission only, 1 adds direct light.
        max_depth: u32 = 16, in Range::closed(0.0, 100000.0);
        /// Maximum number of diffuse reflections. Default: `max_depth`.
        max_diffuse: Option<u32> = None;
        /// Maximum number of glossy and mirror reflections. Default: `max_depth`.
        max_glossy: Option<u32> = None;
        /// Maximum number of transmissions. Default: `max_depth`.
        max_transmission: Option<u32> = None;
        /// Maximum number of surfaces that a ray may pass straight through, such as alpha-tested holes and thin clear
        /// panes. These do not count as bounces.
        max_transparent: u32 = 256, in Range::closed(0.0, 100000.0);
        /// Number of bounces after which Russian roulette starts. Default: 3, or 5 under an open sky, where most paths
        /// leave the scene. A path whose throughput has fallen far since its first
        /// bounce then ends at random; the paths that survive are weighted up, so the mean stays the same.
        rr_start: Option<u32> = None;
        /// Whether emitters are hidden from the camera, as in Mitsuba: its rays pass emissive surfaces and see black instead
        /// of the environment or the background. They are still seen in mirrors and through glass.
        hide_emitters: bool = false;
        /// Largest radiance that one path may contribute as indirect light, in any colour channel; 0 is no limit. A
        /// limit removes fireflies and also light: the image gets darker.
        clamp_indirect: f64 = 0.0, in Range::NON_NEGATIVE;
        /// How caustics are found: light focused by mirrors and glass.
        caustics: Caustics = Caustics::Auto;
        /// Radius within which photons count for the first sample of a pixel, in scene units. Used with `caustics =
        /// "full"`. Default: a few pixels.
        photon_radius: Option<f64> = None, in Range::POSITIVE;
        /// Whether neighbouring pixels share their paths.
        shared_paths: SharedPathsMode = SharedPathsMode::Auto;
        /// Number of lights that are sampled at the first surface of a path that is not a mirror or clear glass, each with a
        /// shadow ray. Default: 1 to 8, as a short test finds the least noise for the time.
        light_samples: Option<u32> = None, in Range::closed(1.0, 256.0);
        /// How direct light is estimated, for comparisons.
        light_sampling: LightSampling = LightSampling::Both;
    }
    example r#"[integrator]
type = "path"
max_depth = 8

[film]
antialias = "monte-carlo"
samples = 64
"#
}

params! {
    /// Direct light only: light that reaches a surface from lights, emissive surfaces and the environment without
    /// another bounce. The surface may be seen by way of mirrors and clear glass. Units are those of "path".
    pub struct DirectDesc as "direct" {
        /// Maximum number of mirrors and glass surfaces between the camera and the surface.
        max_depth: u32 = 16, in Range::closed(0.0, 100000.0);
        /// Maximum number of surfaces that a ray may pass straight through, such as alpha-tested holes.
        max_transparent: u32 = 256, in Range::closed(0.0, 100000.0);
        /// Number of lights that are sampled at the first surface of a path that is not a mirror or clear glass, each with a
        /// shadow ray. Default: 1 to 8, as a short test finds the least noise for the time.
        light_samples: Option<u32> = None, in Range::closed(1.0, 256.0);
        /// How direct light is estimated, for comparisons.
        light_sampling: LightSampling = LightSampling::Both;
    }
    example r#"[integrator]
type = "direct"
"#
}

impl Integrator for PathDesc {
    fn name(&self) -> &str {
        PathDesc::DOC.name
    }

    fn capabilities(&self) -> Capabilities {
        capabilities(self.light_sampling)
    }

    fn prepare(&self, _: &Scene, _: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        Ok(Arc::new(PathIntegrator::new(Settings::path(self), Some(self.clone()), self.light_samples)))
    }
}

impl Integrator for DirectDesc {
    fn name(&self) -> &str {
        DirectDesc::DOC.name
    }

    fn capabilities(&self) -> Capabilities {
        capabilities(self.light_sampling)
    }

    fn prepare(&self, _: &Scene, _: &View) -> Result<Arc<dyn PreparedIntegrator>, SceneError> {
        Ok(Arc::new(PathIntegrator::new(Settings::direct(self), None, self.light_samples)))
    }
}

/// What a path tracer requires of a scene.
fn capabilities(light_sampling: LightSampling) -> Capabilities {
    Capabilities {
        physical: true,
        compensates: light_sampling == LightSampling::Both,
        splits_light: true,
        ..Capabilities::default()
    }
}

/// A path tracer prepared for a scene and a view: its settings, and the strategies chosen for them.
#[derive(Clone, Debug)]
pub struct PathIntegrator {
    settings: Settings,
    /// Settings that choose the strategies; `None` for the integrator "direct", which has no choice.
    desc: Option<PathDesc>,
    /// Number of lights sampled at a first surface, if it is not chosen.
    light_samples: Option<u32>,
    choice: OnceLock<Choice>,
    /// The photons of the last sample that was traced on its own, such as one that is explained.
    photons: Arc<Mutex<Option<Arc<PhotonMap>>>>,
}

/// The strategies for a scene and a view.
#[derive(Clone, Debug)]
struct Choice {
    /// The light paths that complement camera paths, if they reduce noise.
    strategy: Option<CausticsStrategy>,
    /// Number of neighbouring pixels that share paths; 1 if they do not.
    cluster: u32,
    /// The environment that is sampled by what each part of the scene sees of it, if that reduces noise.
    adaptive: Option<AdaptiveEnvironment>,
    /// How much of the environment's light arrives: see [`Settings::under`].
    sky: Sky,
    /// Number of lights that are sampled at a first surface; 0 only under a uniform sky.
    light_samples: u32,
}

impl Choice {
    /// One path a pixel, without a choice.
    fn plain(settings: &Settings) -> Choice {
        let light_samples = settings.light_samples;
        Choice { strategy: None, cluster: 1, adaptive: None, sky: Sky::Closed, light_samples }
    }
}

impl PathIntegrator {
    fn new(settings: Settings, desc: Option<PathDesc>, light_samples: Option<u32>) -> PathIntegrator {
        PathIntegrator { settings, desc, light_samples, choice: OnceLock::new(), photons: Arc::default() }
    }

    /// The light paths that complement camera paths; `None` without, and before [`PreparedIntegrator::choose`].
    pub fn caustics(&self) -> Option<&CausticsStrategy> {
        self.choice.get()?.strategy.as_ref()
    }

    /// Number of lights that are sampled at the first surface of a path that is not specular, as chosen; 0 if BSDF sampling
    /// alone finds them.
    pub fn light_samples(&self) -> u32 {
        self.choice.get().map_or(self.settings.light_samples, |choice| choice.light_samples)
    }

    /// Makes this number of pixels share paths, in place of all choices.
    #[cfg(test)]
    pub(crate) fn share_among(&self, cluster: u32) {
        let _ = self.choice.set(Choice { cluster, ..Choice::plain(&self.settings) });
    }

    fn context<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Context<'a> {
        let mut settings = self.settings;
        if let Some(choice) = self.choice.get() {
            settings = settings.under(choice.sky, choice.light_samples);
        }
        Context {
            scene,
            view,
            settings,
            strategy: self.caustics(),
            cluster: self.cluster(),
            adaptive: self.choice.get().and_then(|choice| choice.adaptive.as_ref()),
            threads: 1,
        }
    }
}

/// The scene, view and settings that paths are traced with.
#[derive(Clone, Copy)]
struct Context<'a> {
    scene: &'a Scene,
    view: &'a View,
    settings: Settings,
    /// The light paths that the MIS weights of camera paths take into account.
    strategy: Option<&'a CausticsStrategy>,
    /// Number of neighbouring pixels that share paths; 1 if they do not.
    cluster: u32,
    /// The environment that is sampled adaptively, if any.
    adaptive: Option<&'a AdaptiveEnvironment>,
    /// Number of threads of pilot runs.
    threads: usize,
}

impl PreparedIntegrator for PathIntegrator {
    fn name(&self) -> &str {
        if self.settings.direct { DirectDesc::DOC.name } else { PathDesc::DOC.name }
    }

    fn capabilities(&self) -> Capabilities {
        capabilities(self.settings.light_sampling)
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Box<dyn Tracer + 'a> {
        Box::new(path_batch::PathBatch::new(self.context(scene, view), record::Off))
    }

    fn guide_tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Option<Box<dyn Tracer + 'a>> {
        Some(Box::new(path_batch::PathBatch::of_guides(self.context(scene, view), record::Off)))
    }

    fn choose(&self, scene: &Scene, view: &View, threads: usize) {
        self.choice.get_or_init(|| {
            let settings = self.settings;
            let plain =
                Context { scene, view, settings, strategy: None, cluster: 1, adaptive: None, threads };
            let Some(desc) = &self.desc else {
                let light_samples = light_samples::decide(plain, Sharing::NONE, self.light_samples);
                return Choice { light_samples, ..Choice::plain(&settings) };
            };
            let Learned { adaptive, mut sky } = learn_environment::learn(plain);
            let mut desc = desc.clone();
            match sky {
                Sky::Uniform if matches!(desc.caustics, Caustics::Auto | Caustics::Off) => {
                    desc.light_sampling = LightSampling::Bsdf;
                }
                Sky::Uniform => sky = Sky::Open,
                Sky::Open | Sky::Closed => {}
            }
            let without = if sky == Sky::Uniform { 0 } else { settings.light_samples };
            let context =
                Context { adaptive: adaptive.as_ref(), settings: settings.under(sky, without), ..plain };
            let strategy = CausticsStrategy::new(context, &desc);
            let (strategy, sharing) = shared_paths::decide(context, &desc, strategy);
            let context = Context { strategy: strategy.as_ref(), ..context };
            let light_samples = match sky {
                Sky::Uniform => {
                    light_samples::decide_under_uniform_sky(context, settings, sharing, self.light_samples)
                }
                Sky::Open | Sky::Closed => light_samples::decide(context, sharing, self.light_samples),
            };
            Choice { strategy, cluster: sharing.size, adaptive, sky, light_samples }
        });
    }

    fn has_chosen(&self) -> bool {
        self.choice.get().is_some()
    }

    fn keeps_samples(&self) -> bool {
        let Some(choice) = self.choice.get() else { return true };
        let Choice { strategy, cluster, adaptive, sky, light_samples } = choice;
        let is_plain = strategy.is_none() && *cluster == 1 && adaptive.is_none();
        is_plain && self.settings.under(*sky, *light_samples) == self.settings
    }

    fn cluster(&self) -> u32 {
        self.choice.get().map_or(1, |choice| choice.cluster)
    }

    fn light_paths(&self) -> u64 {
        self.caustics().map_or(0, |strategy| strategy.paths)
    }

    fn finds_photons(&self) -> bool {
        self.caustics().is_some_and(|strategy| strategy.merges)
    }

    fn photons(&self, scene: &Scene, view: &View, index: u32) -> Option<Arc<PhotonMap>> {
        let strategy = self.caustics().filter(|strategy| strategy.merges)?;
        let kept = || self.photons.lock().unwrap_or_else(PoisonError::into_inner);
        let found = kept().clone().filter(|photons| photons.index == index);
        found.or_else(|| {
            let photons = Arc::new(PhotonMap::of_sample(self.context(scene, view), strategy, index));
            *kept() = Some(Arc::clone(&photons));
            Some(photons)
        })
    }

    fn photon_map(&self, index: u32, photons: Vec<Photon>) -> Option<PhotonMap> {
        self.caustics().map(|strategy| PhotonMap::new(strategy, index, photons))
    }

    fn light_tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Option<Box<dyn LightTracer + 'a>> {
        let strategy = self.caustics()?;
        Some(Box::new(caustics::LightPathBatch::new(self.context(scene, view), strategy)))
    }
}
