//! More samples for a film: which samples do not depend on their number.

use super::Renderer;
use crate::camera::PixelCone;
use crate::film::{Antialias, Film};
use crate::integrator::Prepared;
use crate::schema::{ErrorCode, SceneError};

impl Renderer {
    /// A renderer that continues a film with the samples per pixel of `prepared`, of which the film may have fewer.
    /// The finished film equals that of a render with this number from the beginning.
    ///
    /// Errors: those of [`Renderer::resume`]; samples that depend on their number ([`ErrorCode::Conflict`]).
    pub fn extend(prepared: Prepared, mut film: Film) -> Result<Renderer, SceneError> {
        let (old, new) = (film.identity().samples, prepared.view.film.samples_per_pixel());
        if old != new {
            check(&prepared, old)?;
            // First, while a film of one sample per pixel still holds it unchanged.
            if super::estimates_error(&prepared) {
                film.begin_error_estimate()?;
                if super::is_adaptive(&prepared) && !film.identity().adaptive {
                    film.sample_adaptively();
                }
            }
            if prepared.view.film.removes_fireflies() {
                film.begin_brightest();
            }
            film.extend(new)?;
        }
        Renderer::resume(prepared, film)
    }
}

/// An error if the samples of a picture with `old` samples per pixel are not among those of this one.
fn check(prepared: &Prepared, old: u32) -> Result<(), SceneError> {
    let (view, film) = (&prepared.view, &prepared.view.film);
    let refuse = |message: String, help: &str| {
        Err(SceneError::new(ErrorCode::Conflict, message).help(help.to_owned()))
    };
    let again = "render again with this number of samples";
    if film.antialias != Antialias::MonteCarlo {
        let message =
            format!("anti-aliasing \"{}\" places its samples by their number", film.antialias.word());
        return refuse(message, again);
    }
    if !view.sobol {
        let message = format!(
            "the integrator \"{}\" places its samples by their number: more cannot be added",
            prepared.integrator.name()
        );
        return refuse(message, "render again with this number of samples, or use `path` or `direct`");
    }
    let mut before = film.clone();
    before.samples = old;
    let cone = view.pixel_cone.map(|_| PixelCone::new(&view.camera, &before));
    if cone != view.pixel_cone {
        let message = format!(
            "textures are filtered by the number of samples below 64: {old} samples differ from the first {old} of {}",
            film.samples
        );
        return refuse(
            message,
            "render again with this number of samples; films of 64 or more can be extended",
        );
    }
    Ok(())
}
