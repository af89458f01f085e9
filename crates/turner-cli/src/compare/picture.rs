//! The difference picture.

use std::path::{Path, PathBuf};

use turner::color::heat;
use turner::compare::{Measured, Metric, Pair};
use turner::schema::ErrorCode;
use turner::schema::error::escape;
use turner_io::image::{Display, ImageFormat, Metadata, OutputFile, OutputImage, Transfer, encode};

use super::{Diff, refused};
use crate::failure::{Failure, two_lines};

/// The checked output file.
pub(super) struct Target(PathBuf, OutputFile);

/// Checks that the file can be written and is neither of the compared pictures.
pub(super) fn target(path: &Path, compared: [&PathBuf; 2]) -> Result<Target, Failure> {
    if !matches!(ImageFormat::of_path(path), Ok(ImageFormat::Png)) {
        return Err(refused(path, "the difference is written as PNG", "give it the extension .png"));
    }
    if let Ok(own) = path.canonicalize()
        && compared.iter().any(|p| p.canonicalize().is_ok_and(|p| p == own))
    {
        return Err(refused(path, "is one of the compared pictures", "name another file"));
    }
    let file = OutputFile::create(path).map_err(|e| failed(&e))?;
    Ok(Target(path.to_owned(), file))
}

fn failed(error: &impl std::fmt::Display) -> Failure {
    Failure::new(two_lines(ErrorCode::Output, &error.to_string()))
}

impl Target {
    /// Writes the map of a metric in the colour map magma. FLIP and 1 - SSIM have the range 0 to 1, other metrics 0 to
    /// the largest value in the map.
    pub(super) fn write(
        self,
        pair: &Pair,
        metric: Metric,
        found: &Measured,
        threads: usize,
    ) -> Result<Diff, Failure> {
        let Target(path, file) = self;
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
            display: Some(Display::U8(&colors)),
            transfer: Transfer::Srgb,
            metadata: &metadata,
            threads,
            ..OutputImage::default()
        };
        let bytes = encode(&image, ImageFormat::Png).map_err(|e| failed(&e))?;
        file.commit(&bytes).map_err(|e| failed(&e))?;
        Ok(Diff { path: escape(&path.to_string_lossy()), metric, white })
    }
}
