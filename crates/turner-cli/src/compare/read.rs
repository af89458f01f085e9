//! Reads the pictures to compare.

use std::path::Path;

use turner::compare::Canvas;
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::assets::{AssetSource, DEFAULT_BUDGET, FolderAssets};
use turner_io::image::{DecodeLimits, ImageFormat, decode, exr};

use crate::failure::{Failure, two_lines};

/// Reads a picture. EXR values are taken as stored, with colours premultiplied by alpha.
pub(super) fn canvas(path: &Path) -> Result<Canvas, Failure> {
    let name = path.to_string_lossy();
    let file = |message: &str| Failure::new(two_lines(ErrorCode::File, message));
    let Some(own) = path.file_name() else {
        let message = format!("{}: names no file", escape(&name));
        return Err(Failure::new(SceneError::new(ErrorCode::File, message).help("name a picture")));
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let assets = FolderAssets::new(folder).map_err(|e| file(&e.to_string()))?.allow_outside(true);
    let bytes = assets.read(&own.to_string_lossy(), DEFAULT_BUDGET).map_err(|e| file(&e.to_string()))?;
    let limits = DecodeLimits::default();
    let read = || match ImageFormat::of_bytes(&bytes, &name)? {
        ImageFormat::Exr => Ok((exr::decode_as_stored(&bytes, &name, &limits)?, true)),
        _ => Ok((decode(&bytes, &name, &limits)?, false)),
    };
    let (image, associated) = read().map_err(|e: turner_io::image::ImageError| {
        Failure::new(two_lines(ErrorCode::Image, &e.to_string()))
    })?;
    Ok(Canvas::new(&image, associated))
}
