//! What a front end asks for.

use std::sync::Arc;

use turner::SceneDesc;
use turner::camera::CameraDesc;
use turner::film::{Aov, Aovs, Denoise};
use turner::integrator::IntegratorDesc;

/// Which layers of light the film holds apart, so that they can be weighted without rendering again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layers {
    /// None: only the picture.
    #[default]
    None,
    /// One for each light group of the scene: `light.NAME`, and `light.default`.
    Groups,
    /// `emission`, `direct` and `indirect` light, and `caustics`.
    Parts,
    /// `emission`, and light by how the first surface scatters it: `direct_diffuse`, `direct_specular`,
    /// `indirect_diffuse`, `indirect_specular`, `transmission`, `volume`; and `caustics`.
    Lobes,
}

impl Layers {
    /// The AOVs that hold the layers in the film.
    pub fn aovs(self) -> Vec<Aov> {
        match self {
            Layers::None => Vec::new(),
            Layers::Groups => vec![Aov::LightGroups],
            Layers::Parts => vec![Aov::Emission, Aov::Direct, Aov::Indirect],
            Layers::Lobes => [Aov::Emission].into_iter().chain(Aov::LOBES).collect(),
        }
    }
}

/// What the display values of the picture are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Display {
    /// Those of the film's settings.
    #[default]
    Picture,
    /// Luminance as colours, from five stops below middle grey (black) to five above it (pale yellow).
    FalseColor,
    /// The estimated relative error of each pixel as colours, up to 100 %.
    Noise,
}

/// What is shown of a scene: changes of the picture that are not changes of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// Another integrator than the scene's, such as a debug view.
    pub integrator: Option<IntegratorDesc>,
    /// Another camera than the scene's.
    pub camera: Option<CameraDesc>,
    /// Layers of light to keep apart.
    pub layers: Layers,
    /// Factors of layers, by name; the others have 1.
    pub mix: Vec<(String, f32)>,
    /// What the display values are.
    pub display: Display,
}

/// A picture to render.
#[derive(Clone, Debug)]
pub struct Order {
    /// The scene.
    pub desc: Arc<SceneDesc>,
    /// What is shown of it.
    pub look: Look,
    /// The largest size of preview frames in pixels: that of the window's part. The film has the scene's size.
    pub size: [u32; 2],
    /// Whether the user is moving something: then preview frames have the time that keeps them fluent.
    pub moving: bool,
    /// Whether rendering waits; the picture so far stays.
    pub paused: bool,
    /// Threads; 0 uses all.
    pub threads: usize,
}

impl Order {
    /// An order of a scene at the size of its film.
    pub fn new(desc: Arc<SceneDesc>) -> Order {
        let size = [desc.film.width, desc.film.height];
        Order { desc, look: Look::default(), size, moving: false, paused: false, threads: 0 }
    }

    /// Whether the film of `other` is this one's, too.
    pub(crate) fn has_film_of(&self, other: &Order) -> bool {
        let (a, b) = (&self.look, &other.look);
        Arc::ptr_eq(&self.desc, &other.desc)
            && a.integrator == b.integrator
            && a.camera == b.camera
            && a.layers == b.layers
    }

    /// The description that is prepared: with the look, and with what interim pictures need for their denoiser. Colours
    /// of samples are those of the scene's description.
    pub(crate) fn prepared_desc(&self) -> SceneDesc {
        let mut desc = SceneDesc::clone(&self.desc);
        if let Some(integrator) = &self.look.integrator {
            desc.integrator = integrator.clone();
        }
        if let Some(camera) = &self.look.camera {
            desc.camera = Some(camera.clone().into());
        }
        if desc.integrator.capabilities().splits_light && desc.film.denoise == Denoise::Off {
            desc.film.denoise = Denoise::Fast;
        }
        let layers = self.look.layers.aovs();
        if !layers.is_empty() {
            let aovs: Vec<Aov> = desc.film.aovs.iter().chain(layers).collect();
            desc.film.aovs = Aovs::new(&aovs);
        }
        desc
    }
}
