//! One sample by itself.

use super::tile::{TileBuffers, place, take_points};
use crate::film::Antialias;
use crate::integrator::path::group;
use crate::integrator::{CameraSamples, Radiance};
use crate::math::Ray;
use crate::sampler::SampleId;
use crate::scene::Scene;
use crate::scene::error::{ErrorCode, SceneError};

/// What sample `index` (from 0) of the pixel in column `x`, row `y` (from 0, top left) gives to its pixel: as in the picture, to the last bit, before the film's
/// `max_sample` cuts it.
///
/// Errors ([`ErrorCode::OutOfRange`]): a pixel outside the picture, a sample beyond those of a pixel, adaptive anti-aliasing, whose samples have no
/// numbers.
pub fn sample(scene: &Scene, x: u32, y: u32, index: u32) -> Result<Radiance, SceneError> {
    let id = sample_id(scene, x, y, index)?;
    let mut buffers = TileBuffers::new(scene);
    if scene.shares_paths() {
        let points = group(scene, id).map(|id| (id, place_of(scene, &id).into()));
        take_points(scene, &mut buffers.samples, points);
    } else {
        camera_point(scene, id, place_of(scene, &id), &mut buffers.samples);
    }
    buffers.prepare(id.index);
    buffers.trace();
    let own = buffers.samples.ids.iter().position(|other| *other == id);
    let radiance = own.and_then(|own| buffers.radiance.get(own).copied());
    radiance.ok_or_else(|| SceneError::new(ErrorCode::Internal, "a sample gave no radiance"))
}

/// Whether the picture has such a pixel.
pub(super) fn check_pixel(scene: &Scene, x: u32, y: u32) -> Result<(), SceneError> {
    let film = &scene.film;
    if x < film.width && y < film.height {
        return Ok(());
    }
    let message =
        format!("there is no pixel in column {x}, row {y}: the picture has {}x{}", film.width, film.height);
    let help = "columns and rows are counted from 0 at the top left";
    Err(SceneError::new(ErrorCode::OutOfRange, message).help(help))
}

/// What a sample's numbers depend on, if the picture has it.
pub(crate) fn sample_id(scene: &Scene, x: u32, y: u32, index: u32) -> Result<SampleId, SceneError> {
    let film = &scene.film;
    let error = |message: String, help: String| SceneError::new(ErrorCode::OutOfRange, message).help(help);
    check_pixel(scene, x, y)?;
    if film.antialias == Antialias::Adaptive {
        return Err(error(
            "with antialias = \"adaptive\" pixels share their samples, which have no numbers".to_owned(),
            "choose another: `--antialias monte-carlo`".to_owned(),
        ));
    }
    let count = film.samples_per_pixel();
    if index >= count {
        let last = match count {
            1 => "pixels of this picture have one sample, number 0".to_owned(),
            n => format!("samples of a pixel are numbered 0 to {}", n - 1),
        };
        let message = format!("there is no sample {index}: {last}");
        return Err(error(message, "`--samples N --antialias monte-carlo` takes more".to_owned()));
    }
    Ok(SampleId { x, y, index, seed: u64::from(film.seed) })
}

/// Where in the picture a sample lies, in pixels from its top left corner; not for adaptive anti-aliasing.
pub(crate) fn place_of(scene: &Scene, id: &SampleId) -> [f64; 2] {
    place(scene, &scene.film.filter(), id).into()
}

/// Puts in the camera sample of one place of the picture.
pub(crate) fn camera_point(scene: &Scene, id: SampleId, place: [f64; 2], samples: &mut CameraSamples) {
    samples.clear();
    take_points(scene, samples, std::iter::once((id, place.into())));
}

/// The camera's ray through a sample's place, of unit direction; `None` where the camera shows nothing.
pub fn camera_ray(scene: &Scene, id: SampleId, place: [f64; 2]) -> Option<Ray> {
    let mut samples = CameraSamples::default();
    camera_point(scene, id, place, &mut samples);
    samples.rays.get(0).filter(|ray| ray.t_max >= 0.0)
}
