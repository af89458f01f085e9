//! What can be wrong with a glTF file: where, as a JSON pointer, what was found and what was expected.

use turner::schema::{ErrorCode, Remedy, SceneError};

use crate::assets::printable;

/// A result whose error does not name the file yet.
pub(super) type Outcome<T> = Result<T, Fault>;

/// Why a file is refused.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    code: ErrorCode,
    /// A JSON pointer such as `/accessors/3`, or empty for the file as a whole.
    at: String,
    message: String,
    help: String,
    remedy: Option<Remedy>,
}

const DAMAGED: &str = "export or download it again; a glTF validator tells more";

impl Fault {
    /// A broken rule of the format, at a place.
    pub(super) fn at(pointer: impl Into<String>, message: impl Into<String>) -> Fault {
        let (at, message, help) = (pointer.into(), message.into(), DAMAGED.to_owned());
        Fault { code: ErrorCode::Model, at, message, help, remedy: None }
    }

    /// A broken rule of the file as a whole.
    pub(super) fn of_file(message: impl Into<String>) -> Fault {
        Fault::at("", message)
    }

    /// More than a limit.
    pub(super) fn too_large(pointer: impl Into<String>, message: impl Into<String>) -> Fault {
        Fault { code: ErrorCode::TooLarge, ..Fault::at(pointer, message).help("use a smaller file") }
    }

    /// An error of the limits.
    pub(super) fn of_scene(error: SceneError) -> Fault {
        Fault {
            code: error.code,
            at: String::new(),
            message: error.message,
            help: error.help.unwrap_or_default(),
            remedy: error.remedy.map(|r| *r),
        }
    }

    /// An index that names nothing.
    pub(super) fn dangling(pointer: impl Into<String>, kind: &str, index: u32, count: usize) -> Fault {
        Fault::at(pointer, format!("names {kind} {index}, but there are {count}"))
    }

    /// With another code.
    pub(super) fn code(mut self, code: ErrorCode) -> Fault {
        self.code = code;
        self
    }

    /// With another remedy; names in it must be fit for a terminal.
    pub(super) fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = help.into();
        self
    }

    /// With a remedy as data.
    pub(super) fn remedy(mut self, remedy: Option<Remedy>) -> Fault {
        self.remedy = remedy;
        self
    }

    /// Of the file `name`.
    pub(super) fn in_file(self, name: &str) -> SceneError {
        let place = if self.at.is_empty() { String::new() } else { format!("{}: ", printable(&self.at)) };
        let message = format!("{}: {place}{}", printable(name), printable(&self.message));
        SceneError::new(self.code, message).help(self.help).remedy(self.remedy)
    }
}
