//! The picture of a difference.

use std::path::{Path, PathBuf};

use turner::color::heat;
use turner::compare::{Measured, Metric, Pair};
use turner::schema::ErrorCode;
use turner::schema::error::escape;
use turner_io::image::{Display, ImageFormat, Metadata, OutputFile, OutputImage, Transfer, encode};

use super::{Diff, refused};
use crate::failure::{Failure, two_lines};

/// Where it goes.
pub(super) struct Place(PathBuf, OutputFile);

/// Checks that it can be written, and that it is neither of the pictures compared.
pub(super) fn place(path: &Path, compared: [&PathBuf; 2]) -> Result<Place, Failure> {
    if !matches!(ImageFormat::of_path(path), Ok(ImageFormat::Png)) {
        return Err(refused(path, "the difference is written as PNG", "give it the extension .png"));
    }
    if let Ok(own) = path.canonicalize()
        && compared.iter().any(|p| p.canonicalize().is_ok_and(|p| p == own))
    {
        return Err(refused(path, "is one of the pictures that are compared", "name another file"));
    }
    let file = OutputFile::create(path).map_err(|e| failed(&e))?;
    Ok(Place(path.to_owned(), file))
}

fn failed(error: &impl std::fmt::Display) -> Failure {
    Failure::new(two_lines(ErrorCode::Output, &error.to_string()))
}

impl Place {
    /// Writes a metric's map in colours. FLIP and SSIM have a range of their own, 0 to 1; others go to the largest value there is.
    pub(super) fn write(
        self,
        pair: &Pair,
        metric: Metric,
        found: &Measured,
        threads: usize,
    ) -> Result<Diff, Failure> {
        let Place(path, file) = self;
        let white = match metric {
            Metric::Flip | Metric::Ssim => 1.0,
            _ => found.worst.value,
        };
        let scaled = |v: f32| if white > 0.0 { v / white } else { 0.0 };
        let byte = |v: f32| (v * 255.0 + 0.5) as u8;
        let colors: Vec<[u8; 4]> = found
            .map
            .iter()
            .map(|v| {
                let [r, g, b] = heat(scaled(*v)).to_array().map(byte);
                [r, g, b, 255]
            })
            .collect();
        let metadata: Metadata = [
            ("Software", format!("Turner {}", env!("CARGO_PKG_VERSION"))),
            ("turner:difference", format!("{} from 0 to {white}", metric.word())),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value.as_str().into()))
        .collect();
        let image = OutputImage {
            width: pair.width,
            height: pair.height,
            alpha: false,
            linear: None,
            display: Some(Display::U8(&colors)),
            transfer: Transfer::Srgb,
            metadata: &metadata,
            threads,
        };
        let bytes = encode(&image, ImageFormat::Png).map_err(|e| failed(&e))?;
        file.commit(&bytes).map_err(|e| failed(&e))?;
        Ok(Diff { path: escape(&path.to_string_lossy()), metric, white })
    }
}
