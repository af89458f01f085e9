//! The view: prepared camera and film settings, and the camera rays of samples.
//!
//! The only thing that a view knows about a scene is whether anything moves, since camera rays then have times. A camera
//! that moves is its prepared form in a space that moves: the ray of a sample is made as if it stood still, and then moved
//! to where the camera is at the time of the ray.
//! It is cheap to create.

mod motion;
mod sample;

pub use sample::{CameraSamples, camera_ray};
pub(crate) use sample::{
    PlaceBuffer, camera_point, check_pixel, place, place_of, places, sample_id, take_centers, take_points,
};

use turner_bvh::InstructionSet;

use crate::camera::{Camera, CameraDesc, PixelCone};
use crate::film::{Antialias, Denoise, Film, FilmDesc, KEPT_PIXELS};
use crate::math::DVec2;
use crate::schema::{SceneError, Warning, WarningKind};
use motion::CameraMotion;

/// A prepared camera and film settings.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The description of the camera, also of one that Turner added.
    pub camera_desc: CameraDesc,
    /// The ray cones of camera rays, if textures are filtered.
    pub pixel_cone: Option<PixelCone>,
    /// Size and sampling of the picture.
    pub film: FilmDesc,
    /// Whether samples use Sobol points.
    pub sobol: bool,
    /// Whether anything moves, the scene or the camera.
    pub moves: bool,
    /// What moves the camera while the shutter is open.
    pub(crate) motion: Option<CameraMotion>,
    /// Whether samples have the weights of the camera ([`Camera::weight`]): the camera has them, and pixels are light.
    pub weighted: bool,
    /// Whether pixels hold labels: then each has one sample, through the centre of the lens.
    pub labels: bool,
    /// Instruction set for the generation of camera rays.
    pub instruction_set: InstructionSet,
}

impl View {
    /// Makes the film hold what the denoiser needs, if it is on. `splits_light`: the integrator tells kinds of light
    /// apart. Returns a warning if the denoiser has no effect.
    pub(crate) fn prepare_denoiser(&mut self, splits_light: bool) -> Option<Warning> {
        if self.film.denoise == Denoise::Off {
            return None;
        }
        let film = &mut self.film;
        let (area, samples) = (film.region().area(), film.samples);
        let why = match () {
            _ if !splits_light || !self.sobol => "it needs the integrator \"path\" or \"direct\"",
            _ if film.antialias != Antialias::MonteCarlo => "it needs `antialias = \"monte-carlo\"`",
            _ if samples < 2 => "it needs two samples per pixel",
            _ if area > KEPT_PIXELS => "the picture has more than 16 million pixels",
            _ => {
                film.aovs.hold_guides();
                return None;
            }
        };
        Some(Warning::new(WarningKind::Ignored, format!("`denoise` has no effect: {why}")))
    }

    /// A view through a camera. With `filtered`, texture lookups are filtered over the footprint of a pixel. With
    /// `labels`, the film has no anti-aliasing, whatever it asks for.
    ///
    /// Errors: an invalid camera.
    pub fn new(camera: CameraDesc, mut film: FilmDesc, sampling: ViewSampling) -> Result<View, SceneError> {
        let ViewSampling { sobol, filtered, moves, weighted, labels, instruction_set } = sampling;
        let mut prepared = camera.prepare(film.aspect())?;
        let mut motion = CameraMotion::new(&camera, &prepared.frame())?;
        if let Some(own) = motion.take_if(|own| !sobol || labels || own.is_instant(film.shutter)) {
            // The camera as it is when the shutter opens.
            prepared = own.placed(&camera, film.shutter[0]).prepare(film.aspect())?;
        }
        let moves = moves || motion.is_some();
        let weighted = weighted && prepared.has_weights();
        if labels {
            film.antialias = Antialias::None;
        }
        let pixel_cone = filtered.then(|| PixelCone::new(&prepared, &film));
        let camera_desc = camera;
        Ok(View {
            camera: prepared,
            camera_desc,
            pixel_cone,
            film,
            sobol,
            moves,
            motion,
            weighted,
            labels,
            instruction_set,
        })
    }

    /// The factor of the light of a sample at a place in pixels from the picture's top left corner.
    #[inline]
    pub fn weight(&self, place: DVec2) -> f32 {
        if self.weighted { self.camera.weight(self.film.on_screen(place)) } else { 1.0 }
    }

    /// Size in bytes of the film's sums; 0 for an invalid film.
    pub fn film_bytes(&self) -> u64 {
        Film::check(&self.film).unwrap_or(0)
    }
}

/// The properties of integrator and scene that determine a view's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewSampling {
    /// Samples use Sobol points.
    pub sobol: bool,
    /// Texture lookups are filtered over the footprint.
    pub filtered: bool,
    /// Something in the scene moves.
    pub moves: bool,
    /// Pixels are light, not a property of the first hit: see
    /// [`Capabilities::debug`](crate::integrator::Capabilities::debug).
    pub weighted: bool,
    /// Pixels hold labels: see [`Capabilities::labels`](crate::integrator::Capabilities::labels).
    pub labels: bool,
    /// Instruction set for the generation of camera rays.
    pub instruction_set: InstructionSet,
}
