//! Why a command failed: errors, their sources, the exit code.

use std::collections::HashMap;

use turner::schema::{ErrorCode, SceneError};
use turner_io::scene::{LoadError, Sources};

/// Exit code of bad input and failures.
pub const FAILED: u8 = 1;
/// Exit code of bad usage.
pub const USAGE: u8 = 2;
/// Exit code after Ctrl-C: 128 + the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;
/// Exit code after a request to terminate.
#[cfg(unix)]
pub(crate) const TERMINATED: u8 = 143;
/// Exit code after the terminal was closed.
#[cfg(unix)]
pub(crate) const HUNG_UP: u8 = 129;

/// Options as given on the command line, by the override that they became.
pub type Labels = HashMap<String, String>;

/// Errors, with everything needed to print them.
#[derive(Debug)]
pub struct Failure {
    /// What is wrong.
    pub errors: Vec<SceneError>,
    /// The texts to which their spans refer.
    pub sources: Sources,
    /// Names of options.
    pub labels: Labels,
    /// The exit code.
    pub exit: u8,
}

impl Failure {
    /// A failure without a location.
    pub fn new(error: SceneError) -> Failure {
        Failure { errors: vec![error], sources: Sources::default(), labels: Labels::new(), exit: FAILED }
    }

    /// Bad usage.
    pub fn usage(error: SceneError) -> Failure {
        Failure { exit: USAGE, ..Failure::new(error) }
    }

    /// Adds a note to the help of the last error.
    pub(crate) fn note(mut self, text: String) -> Failure {
        if let Some(error) = self.errors.last_mut() {
            error.help = Some(match error.help.take() {
                Some(help) => format!("{help}; {text}"),
                None => text,
            });
        }
        self
    }

    /// The errors of a scene; bad usage if the first one is in an argument.
    pub fn in_scene(mut error: SceneError, sources: &Sources, labels: &Labels) -> Failure {
        let is_argument =
            error.span.and_then(|s| sources.get(s.file)).is_some_and(|source| source.is_argument);
        let more = std::mem::take(&mut error.more);
        let mut errors = vec![error];
        errors.extend(more.into_vec());
        for error in &mut errors {
            // An error without a location names the file.
            if let (None, Some(scene)) = (error.span, sources.files().first())
                && !error.message.starts_with(&scene.name)
            {
                error.message = format!("{}: {}", scene.name, error.message);
            }
        }
        Failure {
            errors,
            sources: sources.clone(),
            labels: labels.clone(),
            exit: if is_argument { USAGE } else { FAILED },
        }
    }

    /// The errors of loading a scene.
    pub fn load(error: LoadError, labels: &Labels) -> Failure {
        Failure::in_scene(error.error, &error.sources, labels)
    }
}

/// Splits `message\n  remedy`, the form of errors of images and files.
pub fn two_lines(code: ErrorCode, text: &str) -> SceneError {
    match text.split_once("\n  ") {
        Some((message, help)) => SceneError::new(code, message).help(help),
        None => SceneError::new(code, text),
    }
}
