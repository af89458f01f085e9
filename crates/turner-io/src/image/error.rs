//! Errors of images.

use turner::schema::{ErrorCode, Remedy, SceneError};

use super::ImageFormat;
use crate::assets::printable;
use crate::scene::two_lines;

/// Why an image could not be read or written: file, problem and remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The extension of an output path is not that of a writable format.
    #[error("{name}: {found} {problem}{nearest}\n  use one of {valid}")]
    UnknownExtension {
        /// The path.
        name: String,
        /// The extension or format found.
        found: String,
        /// The problem.
        problem: &'static str,
        /// The valid extensions.
        valid: String,
        /// `"; the nearest is .png"`, or empty.
        nearest: String,
    },
    /// The first bytes are not those of a supported format.
    #[error("{name}: found {found}; expected an image in one of {valid}\n  {remedy}")]
    NotAnImage {
        /// The file.
        name: String,
        /// What the file is.
        found: String,
        /// The supported formats.
        valid: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// The image claims a size beyond the limits, or more pixels than its bytes can represent.
    #[error("{name}: {format} of {width} x {height} pixels {problem}\n  {help}")]
    Size {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// Claimed columns.
        width: u64,
        /// Claimed rows.
        height: u64,
        /// The problem.
        problem: String,
        /// The remedy.
        help: SizeHelp,
    },
    /// The file is not valid.
    #[error("{name}: damaged {format}: {problem}\n  export or download it again")]
    Damaged {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// The problem.
        problem: String,
    },
    /// A valid file that uses an unsupported feature of its format.
    #[error("{name}: {format} with {found} is not supported; expected {expected}\n  convert it first")]
    Unsupported {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// The feature.
        found: String,
        /// What is supported.
        expected: String,
    },
    /// The file has no layer of that name.
    #[error("{name}: OpenEXR with {layer}\n  its layers and channels: {layers}")]
    NoLayer {
        /// The file.
        name: String,
        /// The problem: `no layer "albedo"`.
        layer: String,
        /// The layers of the file.
        layers: String,
    },
    /// Out of memory for the samples.
    #[error("{name}: not enough memory for {bytes} bytes of pixels\n  use a smaller image")]
    OutOfMemory {
        /// The file.
        name: String,
        /// Bytes requested.
        bytes: u64,
    },
    /// The image cannot be written.
    #[error("cannot write {format}: {problem}")]
    Encode {
        /// The format's name.
        format: &'static str,
        /// The problem.
        problem: String,
    },
}

/// The remedy for an image whose size is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SizeHelp {
    /// The image has no pixels.
    #[error("export or download it again")]
    Empty,
    /// A file of this length cannot contain that many pixels.
    #[error("the file is damaged: export or download it again")]
    Damaged,
    /// This machine cannot address that much memory.
    #[error("scale it down")]
    Machine,
    /// More columns, rows or pixels than the limits allow.
    #[error("scale it down, or raise the image size limit")]
    Sides,
    /// More memory than the limits allow.
    #[error("scale it down, or raise the memory limit")]
    Memory,
    /// Implausibly high compression, as in a decompression bomb.
    #[error("scale it down, or allow images of this size")]
    Packed,
}

impl SizeHelp {
    /// What a program can do about the error.
    pub fn remedy(self) -> Option<Remedy> {
        match self {
            SizeHelp::Empty | SizeHelp::Damaged | SizeHelp::Machine => None,
            SizeHelp::Sides | SizeHelp::Packed => Some(Remedy::LargerPictures),
            SizeHelp::Memory => Some(Remedy::MoreMemory),
        }
    }
}

impl ImageError {
    /// Converts to an error of the scene that uses the image.
    pub fn to_scene_error(&self) -> SceneError {
        let error = two_lines(ErrorCode::Image, &self.to_string());
        match self {
            ImageError::Size { help, .. } => error.remedy(help.remedy()),
            _ => error,
        }
    }

    pub(super) fn damaged(name: &str, format: ImageFormat, problem: impl ToString) -> Self {
        let problem = printable(&problem.to_string());
        Self::Damaged { name: printable(name), format: format.name(), problem }
    }

    pub(super) fn unsupported(
        name: &str,
        format: ImageFormat,
        found: impl ToString,
        expected: impl ToString,
    ) -> Self {
        let (found, expected) = (printable(&found.to_string()), expected.to_string());
        Self::Unsupported { name: printable(name), format: format.name(), found, expected }
    }

    /// Converts an error of the image crate; `expected` is what is supported.
    pub(super) fn of_decoder(name: &str, format: ImageFormat, e: image::ImageError, expected: &str) -> Self {
        use image::error::UnsupportedErrorKind;
        match e {
            image::ImageError::Unsupported(what) => match what.kind() {
                UnsupportedErrorKind::GenericFeature(found) => {
                    Self::unsupported(name, format, found, expected)
                }
                UnsupportedErrorKind::Color(kind) => {
                    Self::unsupported(name, format, format!("{kind:?} pixels"), expected)
                }
                _ => Self::unsupported(name, format, what, expected),
            },
            image::ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
                Self::damaged(name, format, "the file ends before all pixels are read")
            }
            other => Self::damaged(name, format, other),
        }
    }

    pub(crate) fn encode(format: ImageFormat, problem: impl ToString) -> Self {
        Self::Encode { format: format.name(), problem: printable(&problem.to_string()) }
    }
}
