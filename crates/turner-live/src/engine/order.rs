//! What a front end asks for.

use std::sync::Arc;

use turner::SceneDesc;
use turner::camera::CameraDesc;
use turner::film::{Aov, Aovs, Denoise};
use turner::integrator::IntegratorDesc;

/// What is shown of a scene: changes of the picture that are not changes of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// Another integrator than the scene's, such as a debug view.
    pub integrator: Option<IntegratorDesc>,
    /// Another camera than the scene's.
    pub camera: Option<CameraDesc>,
    /// Factors of light groups, by name; the other groups have 1. They are applied to the film's channels, so that
    /// nothing is rendered again.
    pub mix: Vec<(String, f32)>,
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
        let same = |a: &Look, b: &Look| a.integrator == b.integrator && a.camera == b.camera;
        Arc::ptr_eq(&self.desc, &other.desc)
            && same(&self.look, &other.look)
            && self.look.mix.is_empty() == other.look.mix.is_empty()
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
        if !self.look.mix.is_empty() {
            let aovs: Vec<Aov> = desc.film.aovs.iter().chain([Aov::LightGroups]).collect();
            desc.film.aovs = Aovs::new(&aovs);
        }
        desc
    }
}
