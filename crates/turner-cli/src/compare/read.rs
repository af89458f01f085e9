//! Reads the pictures to compare.

use std::path::Path;

use turner::compare::Canvas;

use crate::failure::Failure;
use crate::picture_file::PictureFile;

/// Reads a picture, or a layer of an EXR file. EXR values are taken as stored, with colours premultiplied by alpha.
pub(super) fn canvas(path: &Path, layer: Option<&str>) -> Result<Canvas, Failure> {
    let (image, associated) = PictureFile::read(path)?.image(layer)?;
    Ok(Canvas::new(&image, associated))
}
