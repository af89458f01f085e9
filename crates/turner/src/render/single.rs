//! One sample by itself.

use super::tile::{TileBuffers, place, take_points};
use crate::film::Antialias;
use crate::integrator::{CameraSamples, Radiance};
use crate::sampler::SampleId;
use crate::scene::Scene;
use crate::scene::error::{ErrorCode, SceneError};

/// What sample `index` (from 0) of the pixel in column `x`, row `y` (from 0, top left) gives to its pixel: as in the picture, to the last bit.
///
/// Errors ([`ErrorCode::OutOfRange`]): a pixel outside the picture, a sample beyond those of a pixel, adaptive anti-aliasing, whose samples have no
/// numbers.
pub fn sample(scene: &Scene, x: u32, y: u32, index: u32) -> Result<Radiance, SceneError> {
    let id = sample_id(scene, x, y, index)?;
    let mut buffers = TileBuffers::new(scene);
    camera_sample(scene, id, &mut buffers.samples);
    buffers.trace();
    let first = buffers.radiance.first().copied();
    first.ok_or_else(|| SceneError::new(ErrorCode::Internal, "a sample gave no radiance"))
}

/// What a sample's numbers depend on, if the picture has it.
pub(crate) fn sample_id(scene: &Scene, x: u32, y: u32, index: u32) -> Result<SampleId, SceneError> {
    let film = &scene.film;
    let error = |message: String, help: String| SceneError::new(ErrorCode::OutOfRange, message).help(help);
    if x >= film.width || y >= film.height {
        return Err(error(
            format!(
                "there is no pixel in column {x}, row {y}: the picture has {}x{}",
                film.width, film.height
            ),
            "columns and rows are counted from 0 at the top left".to_owned(),
        ));
    }
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

/// Puts one camera sample in; gives its place in the picture, in pixels from the top left corner.
pub(crate) fn camera_sample(scene: &Scene, id: SampleId, samples: &mut CameraSamples) -> [f64; 2] {
    let at = place(scene, &scene.film.filter(), &id);
    samples.clear();
    take_points(scene, samples, std::iter::once((id, at)));
    at.into()
}
