//! Errors of glTF files: position as a JSON pointer, what was found and what was expected.

use turner::schema::{ErrorCode, Remedy, SceneError};

use crate::assets::printable;

/// A result whose error does not yet name the file.
pub(super) type Outcome<T> = Result<T, Fault>;

/// Why a file is rejected.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    code: ErrorCode,
    /// A JSON pointer such as `/accessors/3`; empty for the entire file.
    at: String,
    message: String,
    help: String,
    remedy: Option<Remedy>,
}

const DAMAGED: &str = "export or download it again; a glTF validator shows details";

impl Fault {
    /// A violation of the format at a JSON pointer.
    pub(super) fn at(pointer: impl Into<String>, message: impl Into<String>) -> Fault {
        let (at, message, help) = (pointer.into(), message.into(), DAMAGED.to_owned());
        Fault { code: ErrorCode::Model, at, message, help, remedy: None }
    }

    /// A violation of the format by the file as a whole.
    pub(super) fn of_file(message: impl Into<String>) -> Fault {
        Fault::at("", message)
    }

    /// A limit is exceeded.
    pub(super) fn too_large(pointer: impl Into<String>, message: impl Into<String>) -> Fault {
        Fault { code: ErrorCode::TooLarge, ..Fault::at(pointer, message).help("use a smaller file") }
    }

    /// Converts an error of the limits.
    pub(super) fn of_scene(error: SceneError) -> Fault {
        Fault {
            code: error.code,
            at: String::new(),
            message: error.message,
            help: error.help.unwrap_or_default(),
            remedy: error.remedy.map(|r| *r),
        }
    }

    /// An index that is out of range.
    pub(super) fn dangling(pointer: impl Into<String>, kind: &str, index: u32, count: usize) -> Fault {
        Fault::at(pointer, format!("refers to {kind} {index}, but there are {count}"))
    }

    /// Replaces the code.
    pub(super) fn code(mut self, code: ErrorCode) -> Fault {
        self.code = code;
        self
    }

    /// Replaces the remedy text; names in it must be printable.
    pub(super) fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = help.into();
        self
    }

    /// Sets the machine-readable remedy.
    pub(super) fn remedy(mut self, remedy: Option<Remedy>) -> Fault {
        self.remedy = remedy;
        self
    }

    /// Position and message.
    pub(super) fn text(&self) -> String {
        format!("{}: {}", printable(&self.at), printable(&self.message))
    }

    /// Adds the file name.
    pub(super) fn in_file(self, name: &str) -> SceneError {
        let place = if self.at.is_empty() { String::new() } else { format!("{}: ", printable(&self.at)) };
        let message = format!("{}: {place}{}", printable(name), printable(&self.message));
        SceneError::new(self.code, message).help(self.help).remedy(self.remedy)
    }
}
