//! What can be wrong with a picture.

use turner::schema::{ErrorCode, Remedy, SceneError};

use super::ImageFormat;
use crate::assets::printable;
use crate::scene::two_lines;

/// Why a picture could not be read or written: the file, what was found, what was expected, the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// An output path whose extension names no format.
    #[error("{name}: {found} {problem}{nearest}\n  use one of {valid}")]
    UnknownExtension {
        /// The path.
        name: String,
        /// The extension or the format found.
        found: String,
        /// What is wrong with it.
        problem: &'static str,
        /// All valid extensions.
        valid: String,
        /// `"; the nearest is .png"`, or empty.
        nearest: String,
    },
    /// The first bytes belong to no format that is read.
    #[error("{name}: found {found}; expected a picture in {valid}\n  {remedy}")]
    NotAnImage {
        /// The file.
        name: String,
        /// What it begins with.
        found: String,
        /// The formats that are read.
        valid: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The picture claims a size beyond the limits, or more pixels than its bytes can hold.
    #[error("{name}: {format} of {width} x {height} pixels {problem}\n  {help}")]
    Size {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// Columns claimed.
        width: u64,
        /// Rows claimed.
        height: u64,
        /// What is wrong with that.
        problem: String,
        /// What to do.
        help: SizeHelp,
    },
    /// The file breaks the rules of its format.
    #[error("{name}: damaged {format}: {problem}\n  export or download it again")]
    Damaged {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// What was found.
        problem: String,
    },
    /// A valid file that uses a part of its format that is not read.
    #[error("{name}: {format} with {found} is not supported; expected {expected}\n  convert it first")]
    Unsupported {
        /// The file.
        name: String,
        /// The format's name.
        format: &'static str,
        /// What was found.
        found: String,
        /// What would have been accepted.
        expected: String,
    },
    /// There was not enough memory for the samples.
    #[error("{name}: not enough memory for {bytes} bytes of pixels\n  use a smaller picture")]
    OutOfMemory {
        /// The file.
        name: String,
        /// Bytes asked for.
        bytes: u64,
    },
    /// A picture that cannot be written as asked.
    #[error("cannot write {format}: {problem}")]
    Encode {
        /// The format's name.
        format: &'static str,
        /// What was found and what was expected.
        problem: String,
    },
}

/// What to do about a picture of a size that is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SizeHelp {
    /// It has no pixels.
    #[error("export or download it again")]
    Empty,
    /// No file of this length holds so much.
    #[error("the file is damaged: export or download it again")]
    Damaged,
    /// This machine cannot hold it.
    #[error("scale it down")]
    Machine,
    /// It has more columns, rows or pixels than a picture may have.
    #[error("scale it down, or raise the limit of sizes of pictures")]
    Sides,
    /// It takes more memory than there may be.
    #[error("scale it down, or raise the limit of memory")]
    Memory,
    /// It is packed so well that nobody can have meant it.
    #[error("scale it down, or say that pictures of such a size are meant")]
    Packed,
}

impl SizeHelp {
    /// What a program can do about it.
    pub fn remedy(self) -> Option<Remedy> {
        match self {
            SizeHelp::Empty | SizeHelp::Damaged | SizeHelp::Machine => None,
            SizeHelp::Sides | SizeHelp::Packed => Some(Remedy::LargerPictures),
            SizeHelp::Memory => Some(Remedy::MoreMemory),
        }
    }
}

impl ImageError {
    /// As an error of the scene that shows the picture.
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

    /// An error of the image crate; `expected` is what it reads.
    pub(super) fn of_decoder(name: &str, format: ImageFormat, e: image::ImageError, expected: &str) -> Self {
        use image::error::UnsupportedErrorKind;
        match e {
            image::ImageError::Unsupported(what) => match what.kind() {
                UnsupportedErrorKind::GenericFeature(found) => {
                    Self::unsupported(name, format, found, expected)
                }
                UnsupportedErrorKind::Color(kind) => {
                    Self::unsupported(name, format, format!("pixels of the kind {kind:?}"), expected)
                }
                _ => Self::unsupported(name, format, what, expected),
            },
            image::ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
                Self::damaged(name, format, "it ends before the picture does")
            }
            other => Self::damaged(name, format, other),
        }
    }

    pub(super) fn encode(format: ImageFormat, problem: impl ToString) -> Self {
        Self::Encode { format: format.name(), problem: printable(&problem.to_string()) }
    }
}
