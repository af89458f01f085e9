//! Why a command ends early: an error, the texts it lies in, the exit code.

use std::collections::HashMap;

use turner::schema::{ErrorCode, SceneError};
use turner_io::scene::{LoadError, Sources};

/// Exit code of bad input and failures.
pub const FAILED: u8 = 1;
/// Exit code of bad usage.
pub const USAGE: u8 = 2;
/// Exit code after Ctrl-C: 128 and the signal's number.
pub(crate) const INTERRUPTED: u8 = 130;
/// Exit code after a request to terminate.
#[cfg(unix)]
pub(crate) const TERMINATED: u8 = 143;
/// Exit code after the terminal was closed.
#[cfg(unix)]
pub(crate) const HUNG_UP: u8 = 129;

/// How options of the command line are called in messages: by the override they became.
pub type Labels = HashMap<String, String>;

/// An error with all it takes to show it.
#[derive(Debug)]
pub struct Failure {
    /// What is wrong. Several at once under `--strict`.
    pub errors: Vec<SceneError>,
    /// The texts that its place may lie in.
    pub sources: Sources,
    /// Names of options.
    pub labels: Labels,
    /// The exit code.
    pub exit: u8,
}

impl Failure {
    /// A failure without a place.
    pub fn new(error: SceneError) -> Failure {
        Failure { errors: vec![error], sources: Sources::default(), labels: Labels::new(), exit: FAILED }
    }

    /// Bad usage.
    pub fn usage(error: SceneError) -> Failure {
        Failure { exit: USAGE, ..Failure::new(error) }
    }

    /// The same with more to say at the end.
    pub(crate) fn note(mut self, text: String) -> Failure {
        if let Some(error) = self.errors.last_mut() {
            error.help = Some(match error.help.take() {
                Some(help) => format!("{help}; {text}"),
                None => text,
            });
        }
        self
    }

    /// An error of a scene; bad usage if its place is an argument.
    pub fn in_scene(mut error: SceneError, sources: &Sources, labels: &Labels) -> Failure {
        // What concerns the scene as a whole has no place in it, but names its file.
        if let (None, Some(scene)) = (error.span, sources.files().first())
            && !error.message.starts_with(&scene.name)
        {
            error.message = format!("{}: {}", scene.name, error.message);
        }
        let is_argument =
            error.span.and_then(|s| sources.get(s.file)).is_some_and(|source| source.is_argument);
        Failure {
            errors: vec![error],
            sources: sources.clone(),
            labels: labels.clone(),
            exit: if is_argument { USAGE } else { FAILED },
        }
    }

    /// An error of loading.
    pub fn load(error: LoadError, labels: &Labels) -> Failure {
        Failure::in_scene(error.error, &error.sources, labels)
    }
}

/// Splits `what is wrong\n  remedy`, the form of errors of pictures and files.
pub fn two_lines(code: ErrorCode, text: &str) -> SceneError {
    match text.split_once("\n  ") {
        Some((message, help)) => SceneError::new(code, message).help(help),
        None => SceneError::new(code, text),
    }
}
