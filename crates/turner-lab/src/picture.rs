//! Pictures in files.

use std::path::Path;

use turner::schema::{ErrorCode, SceneError};
use turner_cli::failure::{Failure, two_lines};
use turner_io::image::{DecodeLimits, decode};

/// Linear colours, row by row from the top.
pub(crate) struct Picture {
    /// Columns.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// Linear colours.
    pub(crate) pixels: Vec<[f64; 3]>,
}

impl Picture {
    /// Reads a file of any format that Turner reads.
    pub(crate) fn read(path: &Path) -> Result<Picture, Failure> {
        let shown = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|e| {
            Failure::new(SceneError::new(ErrorCode::File, format!("{shown}: the file cannot be read: {e}")))
        })?;
        let image = decode(&bytes, &shown, &DecodeLimits::default())
            .map_err(|e| Failure::new(two_lines(ErrorCode::Image, &e.to_string())))?;
        let (width, height) = (image.width, image.height);
        let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = positions.map(|(x, y)| image.rgb(x, y).map(f64::from)).collect();
        Ok(Picture { width, height, pixels })
    }
}

/// Writes `width` × `height` linear colours as EXR; missing folders are created.
pub(crate) fn save(
    path: &Path,
    (width, height): (u32, u32),
    pixels: impl Iterator<Item = [f32; 3]>,
) -> Result<(), Failure> {
    let failed = |what: String| Failure::new(two_lines(ErrorCode::Output, &what));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| failed(format!("{}: {e}", folder.display())))?;
    }
    let linear: Vec<[f32; 4]> = pixels.map(|[r, g, b]| [r, g, b, 1.0]).collect();
    let display = vec![[0; 4]; linear.len()];
    let picture =
        turner::film::Picture { width, height, linear, display, has_alpha: false, missing: 0, exposure: 0.0 };
    turner_io::save(path, &picture).map_err(|e| failed(e.to_string()))
}
