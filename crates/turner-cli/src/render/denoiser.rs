//! The library of `--denoise oidn`, which is loaded before the first sample.

use std::sync::Arc;

use turner::film::Denoise;
use turner::render::Renderer;
use turner::schema::{ErrorCode, SceneError};
use turner_oidn::{LIBRARY, Oidn, OidnError, VARIABLE};

/// Gives the renderer the denoiser that its picture asks for, if that is not Turner's own.
///
/// Errors: it cannot be loaded.
pub(super) fn load_denoiser(renderer: &mut Renderer) -> Result<(), SceneError> {
    if renderer.prepared().view.film.denoise != Denoise::Oidn || !renderer.denoises() {
        return Ok(());
    }
    let oidn = Oidn::find().map_err(|error| {
        let remedy = match &error {
            OidnError::Device(_) => "write `--denoise on` for Turner's own denoiser".to_owned(),
            _ => format!(
                "install Open Image Denoise 2 and write `{VARIABLE}=FOLDER`, the folder of `{LIBRARY}`, before the \
                 command; or write `--denoise on` for Turner's own denoiser"
            ),
        };
        SceneError::new(ErrorCode::File, error.to_string()).help(remedy)
    })?;
    renderer.denoise_with(Arc::new(oidn));
    Ok(())
}
