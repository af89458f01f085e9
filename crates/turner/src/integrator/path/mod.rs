//! Path tracing: light transport as it is (Kajiya 1986, "The rendering equation"), estimated path by path.
//!
//! At each surface a light is sampled and a direction is sampled; where both can find the same light, the power heuristic
//! weighs them (Veach & Guibas 1995). Numbers come from scrambled Sobol points. The paths of a tile advance together, a
//! bounce at a time, so that their rays can be searched for in batches; a path's result does not depend on the others.

mod caustics;
#[cfg(test)]
mod closed_form_tests;
mod dispersion;
mod light_resampling;
mod media;
mod notes;
mod pane;
mod path_batch;
mod probing;
mod record;
mod replay;
mod settings;
mod shade;
mod shared_paths;
mod simd_shading;
mod subsurface;
#[cfg(test)]
mod tests;
mod volume;
mod volume_light;

pub use record::{
    DonorRecord, EmissionRecord, End, EscapeRecord, InfiniteLightRecord, LightRecord, MediumSegmentRecord,
    Passage, PathRecord, PhotonsRecord, RandomWalkRecord, Roulette, ScatterRecord, SharedRecord,
    VertexRecord,
};
pub use replay::{replay, replay_at};
pub(crate) use shared_paths::{CELL, group};

pub use caustics::{Caustics, CausticsStrategy, Gathered, Photon, PhotonMap};

use std::sync::{Arc, OnceLock};

use settings::Settings;

use crate::integrator::{Capabilities, Integrator, LightTracer, PreparedIntegrator, Tracer};
use crate::scene::Scene;
use crate::schema::{Range, SceneError, choice, params};
use crate::view::View;

choice! {
    /// Which ways of finding lights are used; both give the same picture in the limit.
    pub enum LightSampling {
        /// Both, weighted by the power heuristic.
        Both = "both",
        /// Lights are only found by chance: those that are a point or a direction are never seen.
        Bsdf = "bsdf",
        /// Lights that can be sampled are only found by sampling them.
        Light = "light",
    }
}

choice! {
    /// Whether neighbouring pixels use one another's paths.
    pub enum SharedPathsMode {
        /// Where a short test finds that it pays: in rooms of diffuse surfaces. The mean is the same, the noise of indirect light that of many times as many samples.
        Auto = "auto",
        /// Where it can: not with motion, media, light paths, a clamp, Russian roulette from the first bounce on, or adaptive anti-aliasing.
        Always = "always",
        /// Each path counts for its own pixel alone.
        Off = "off",
    }
}

params! {
    /// Path tracing: all ways of light between surfaces, materials and lights, without shortcuts. Noise goes down with the
    /// number of samples per pixel: give `antialias = "monte-carlo"` and `samples` in `[film]`.
    ///
    /// Units: a surface's emission is radiance; what a light's `intensity` brings to a surface that faces it is irradiance, after
    /// its attenuation (with "inverse-square" the intensity is radiant intensity). A Lambertian surface of albedo C returns C/π of it: 1/π
    /// of what the classic integrator returns. The lights "rectangle", "disk" and "sphere" are made of points that shine in all
    /// directions alike and are not seen, as there; for a surface that is seen to shine, give an object a material with emission.
    /// A ray that hits nothing finds the environment, or else the background, which shines on things as well. An ambient light is
    /// the same around everything, and not seen.
    pub struct PathDesc as "path" {
        /// How many times light may be scattered; 0 shows only what shines itself, 1 what is directly lit.
        max_depth: u32 = 16, in Range::closed(0.0, 100000.0);
        /// The same for diffuse reflection alone; as `max_depth` if it is not given.
        max_diffuse: Option<u32> = None;
        /// The same for glossy and mirror reflection.
        max_glossy: Option<u32> = None;
        /// The same for transmission.
        max_transmission: Option<u32> = None;
        /// How many times a ray may pass straight through surfaces that are not wholly there; these do not count as scattering.
        max_transparent: u32 = 256, in Range::closed(0.0, 100000.0);
        /// After so many scatterings a path ends at random, the sooner the less light it carries; the others make up for it.
        rr_start: u32 = 3;
        /// Most radiance that one path may bring by way of another surface, in any colour channel; 0 is no limit. It takes away fireflies
        /// and light: pictures get darker.
        clamp_indirect: f64 = 0.0, in Range::NON_NEGATIVE;
        /// How light is found that mirrors and glass gather.
        caustics: Caustics = Caustics::Auto;
        /// With caustics = "full": how far photons count for a pixel's first sample, in scene units; without it a few pixels.
        photon_radius: Option<f64> = None, in Range::POSITIVE;
        /// Whether pixels use the paths of their neighbours.
        shared_paths: SharedPathsMode = SharedPathsMode::Auto;
        /// How lights are found: to compare.
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
    /// Direct light only: what lights, shining surfaces and the environment bring to a surface without another one between, but for mirrors and
    /// clear glass on the way from the camera. Units are those of "path".
    pub struct DirectDesc as "direct" {
        /// How many mirrors and panes of glass may be between the camera and the surface.
        max_depth: u32 = 16, in Range::closed(0.0, 100000.0);
        /// How many times a ray may pass straight through surfaces that are not wholly there.
        max_transparent: u32 = 256, in Range::closed(0.0, 100000.0);
        /// How lights are found: to compare.
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
        Ok(Arc::new(PathIntegrator::new(Settings::path(self), Some(self.clone()))))
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
        Ok(Arc::new(PathIntegrator::new(Settings::direct(self), None)))
    }
}

/// What a path tracer needs of a scene.
fn capabilities(light_sampling: LightSampling) -> Capabilities {
    Capabilities {
        physical: true,
        compensates: light_sampling == LightSampling::Both,
        ..Capabilities::default()
    }
}

/// A path tracer that is ready for a scene and a view: its settings, and what was chosen for them.
#[derive(Clone, Debug)]
pub struct PathIntegrator {
    settings: Settings,
    /// What there is to choose by; `None` for direct light alone, which has no choice.
    desc: Option<PathDesc>,
    choice: OnceLock<Choice>,
}

/// What pays in a scene and a view.
#[derive(Clone, Debug, Default)]
struct Choice {
    /// The light paths that go with the camera's, if they help.
    strategy: Option<CausticsStrategy>,
    /// Whether pixels use their neighbours' paths.
    shares: bool,
}

impl PathIntegrator {
    fn new(settings: Settings, desc: Option<PathDesc>) -> PathIntegrator {
        let choice = OnceLock::new();
        if desc.is_none() {
            let _ = choice.set(Choice::default());
        }
        PathIntegrator { settings, desc, choice }
    }

    /// The light paths that go with the camera's, if they help; none before that is [chosen](PreparedIntegrator::choose).
    pub fn caustics(&self) -> Option<&CausticsStrategy> {
        self.choice.get()?.strategy.as_ref()
    }

    fn context<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Context<'a> {
        Context {
            scene,
            view,
            settings: self.settings,
            strategy: self.caustics(),
            shares: self.shares_paths(),
        }
    }
}

/// What paths are traced in, and by what settings.
#[derive(Clone, Copy)]
struct Context<'a> {
    scene: &'a Scene,
    view: &'a View,
    settings: Settings,
    /// The light paths beside which camera paths are weighed.
    strategy: Option<&'a CausticsStrategy>,
    /// Whether pixels use their neighbours' paths.
    shares: bool,
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

    fn choose(&self, scene: &Scene, view: &View) {
        if let Some(desc) = &self.desc {
            self.choice.get_or_init(|| {
                let (strategy, shares) =
                    shared_paths::decide(scene, view, desc, CausticsStrategy::new(scene, view, desc));
                Choice { strategy, shares }
            });
        }
    }

    fn has_chosen(&self) -> bool {
        self.choice.get().is_some()
    }

    fn shares_paths(&self) -> bool {
        self.choice.get().is_some_and(|choice| choice.shares)
    }

    fn light_paths(&self) -> u64 {
        self.caustics().map_or(0, |strategy| strategy.paths)
    }

    fn finds_photons(&self) -> bool {
        self.caustics().is_some_and(|strategy| strategy.merges)
    }

    fn photons(&self, scene: &Scene, view: &View, index: u32) -> Option<PhotonMap> {
        let strategy = self.caustics().filter(|strategy| strategy.merges)?;
        Some(PhotonMap::of_sample(self.context(scene, view), strategy, index))
    }

    fn photon_map(&self, index: u32, photons: Vec<Photon>) -> Option<PhotonMap> {
        self.caustics().map(|strategy| PhotonMap::new(strategy, index, photons))
    }

    fn light_tracer<'a>(&'a self, scene: &'a Scene, view: &'a View) -> Option<Box<dyn LightTracer + 'a>> {
        let strategy = self.caustics()?;
        Some(Box::new(caustics::LightPathBatch::new(self.context(scene, view), strategy)))
    }
}
