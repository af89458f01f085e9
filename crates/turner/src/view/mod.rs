//! Who looks: a camera and a film's settings that are ready, and the camera rays of samples.
//!
//! A view knows nothing of what is in a scene but whether anything moves: then camera rays have moments. It is cheap to make anew.

mod sample;

pub use sample::{CameraSamples, camera_ray};
pub(crate) use sample::{camera_point, check_pixel, place, place_of, sample_id, take_points};

use turner_bvh::InstructionSet;

use crate::camera::{Camera, CameraDesc, PixelCone};
use crate::film::{Antialias, Film, FilmDesc};
use crate::schema::SceneError;

/// A camera and a film's settings that are ready.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// What it was made from, also where the scene did not name one.
    pub camera_desc: CameraDesc,
    /// The cones of camera rays, where textures are filtered by them.
    pub pixel_cone: Option<PixelCone>,
    /// Size and sampling of the picture.
    pub film: FilmDesc,
    /// Whether samples are placed by Sobol points.
    pub sobol: bool,
    /// Whether anything in the scene moves.
    pub moves: bool,
    /// Whether pixels hold labels: then each has one sample, through the centre of the lens.
    pub labels: bool,
    /// What camera rays are made with.
    pub instruction_set: InstructionSet,
}

impl View {
    /// A view through a camera. With `filtered`, texture look-ups are filtered over the pixel's footprint. With `labels`, the film has no anti-aliasing, whatever it asks for.
    ///
    /// Errors: a camera that sees nothing.
    pub fn new(camera: CameraDesc, mut film: FilmDesc, sampling: ViewSampling) -> Result<View, SceneError> {
        let prepared = camera.prepare(film.aspect())?;
        let ViewSampling { sobol, filtered, moves, labels, instruction_set } = sampling;
        if labels {
            film.antialias = Antialias::None;
        }
        let pixel_cone = filtered.then(|| PixelCone::new(&prepared, &film));
        let camera_desc = camera;
        Ok(View { camera: prepared, camera_desc, pixel_cone, film, sobol, moves, labels, instruction_set })
    }

    /// Bytes of the film's sums; 0 for a film that there cannot be.
    pub fn film_bytes(&self) -> u64 {
        Film::check(&self.film).unwrap_or(0)
    }
}

/// What the integrator and the scene make of a view's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewSampling {
    /// Samples are placed by Sobol points.
    pub sobol: bool,
    /// Textures are averaged over what a ray stands for.
    pub filtered: bool,
    /// Something in the scene moves.
    pub moves: bool,
    /// Pixels hold labels: see [`Capabilities::labels`](crate::integrator::Capabilities::labels).
    pub labels: bool,
    /// What camera rays are made with.
    pub instruction_set: InstructionSet,
}
