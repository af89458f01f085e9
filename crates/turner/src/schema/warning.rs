//! Remarks about a scene that are no errors.

use super::Remedy;
use super::value::Span;

/// What sort of remark a warning is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum WarningKind {
    /// Something that was asked for has no effect on the picture; an error where everything must have its effect.
    #[default]
    Ignored,
    /// Something is shown, but not exactly as asked for.
    Approximated,
    /// Something is unlikely to be meant.
    Doubtful,
    /// Something that was not said was chosen.
    Note,
}

impl WarningKind {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            WarningKind::Ignored => "ignored",
            WarningKind::Approximated => "approximated",
            WarningKind::Doubtful => "doubtful",
            WarningKind::Note => "note",
        }
    }
}

/// Something ignored, approximated or doubtful.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// What sort of remark.
    pub kind: WarningKind,
    /// What.
    pub message: String,
    /// Where.
    pub span: Option<Span>,
    /// How often.
    pub count: u64,
    /// What would change it, where a program can carry it out.
    pub remedy: Option<Remedy>,
}

impl Warning {
    /// A remark without a place in a file.
    pub fn new(kind: WarningKind, message: impl Into<String>) -> Warning {
        Warning { kind, message: message.into(), span: None, count: 1, remedy: None }
    }
}
