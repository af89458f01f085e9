//! Errors of loading, with the texts that they refer to.

use turner::schema::{ErrorCode, SceneError};

use super::sources::{Location, Sources};

/// Why a scene could not be loaded. Each error is displayed in one to three lines:
///
/// ```text
/// error[E0102]: scene.toml:12:3: unknown key `radus` in the shape "sphere"
///   help: did you mean `radius`?
/// ```
#[derive(Clone, Debug)]
pub struct LoadError {
    /// What is wrong first; further errors of the scene are its [`SceneError::more`].
    pub error: SceneError,
    /// The texts read so far.
    pub sources: Sources,
}

impl LoadError {
    /// The stable code, e.g. `E0102`.
    pub fn code(&self) -> &'static str {
        self.error.code.as_str()
    }

    /// The position of the error, if it has one.
    pub fn location(&self) -> Option<Location<'_>> {
        self.error.span.and_then(|span| self.sources.locate(span))
    }

    /// The file, or the command-line argument.
    pub fn file(&self) -> Option<&str> {
        let id = self.error.span?.file;
        self.sources.get(id).map(|file| file.name.as_str())
    }

    /// The line, from 1.
    pub fn line(&self) -> Option<usize> {
        self.location().map(|l| l.line)
    }

    /// The column in characters, from 1.
    pub fn column(&self) -> Option<usize> {
        self.location().map(|l| l.column)
    }
}

impl std::fmt::Display for LoadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, error) in std::iter::once(&self.error).chain(&self.error.more).enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "error[{}]: ", error.code.as_str())?;
            match error.span.and_then(|span| self.sources.locate(span)) {
                Some(at) if at.is_argument => write!(f, "{}: ", at.file)?,
                Some(at) => write!(f, "{}:{}:{}: ", at.file, at.line, at.column)?,
                None => {}
            }
            write!(f, "{}", error.message)?;
            if let Some(help) = &error.help {
                write!(f, "\n  help: {help}")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for LoadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.error)
    }
}

/// Splits `problem\n  remedy`, the form of this crate's own errors.
pub(crate) fn two_lines(code: ErrorCode, text: &str) -> SceneError {
    match text.split_once("\n  ") {
        Some((message, help)) => SceneError::new(code, message).help(help),
        None => SceneError::new(code, text),
    }
}
