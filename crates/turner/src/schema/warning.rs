//! Warnings about a scene.

use super::Remedy;
use super::value::Span;

/// The kind of a warning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum WarningKind {
    /// The scene sets something that is ignored. An error with `--strict`.
    #[default]
    Ignored,
    /// Something is rendered only approximately as described.
    Approximated,
    /// Something is probably a mistake.
    Doubtful,
    /// Turner chose something that the scene does not specify, or accepted an old name.
    Note,
}

impl WarningKind {
    /// The kind as a word.
    pub fn word(self) -> &'static str {
        match self {
            WarningKind::Ignored => "ignored",
            WarningKind::Approximated => "approximated",
            WarningKind::Doubtful => "doubtful",
            WarningKind::Note => "note",
        }
    }
}

/// A warning about a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// Its kind.
    pub kind: WarningKind,
    /// What the warning is about.
    pub message: String,
    /// The position in a file, if it has one.
    pub span: Option<Span>,
    /// How often it occurred.
    pub count: u64,
    /// A remedy as data that a program can apply.
    pub remedy: Option<Remedy>,
}

impl Warning {
    /// A warning without a position in a file.
    pub fn new(kind: WarningKind, message: impl Into<String>) -> Warning {
        Warning { kind, message: message.into(), span: None, count: 1, remedy: None }
    }
}
