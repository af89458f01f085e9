//! Errors of calls.

use serde_json::{Value as Json, json};
use turner::schema::SceneError;
use turner_io::scene::{LoadError, Sources};

/// Why a call failed.
#[derive(Clone, Debug, Default)]
pub struct CallError {
    /// The problem.
    pub message: String,
    /// The remedy, if one is known.
    pub help: Option<String>,
    /// The stable code of the error.
    pub code: Option<&'static str>,
    /// Its place in a text.
    pub place: Option<Box<Place>>,
}

/// A place in a text.
#[derive(Clone, Debug)]
pub struct Place {
    /// The name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Characters, at least 1.
    pub length: usize,
    /// The line.
    pub excerpt: String,
}

impl CallError {
    /// An error without a place.
    pub fn new(message: impl Into<String>) -> CallError {
        CallError { message: message.into(), ..CallError::default() }
    }

    /// An error of a scene, with its place in these texts.
    pub(crate) fn of_scene(error: &SceneError, sources: &Sources) -> CallError {
        let place = error.span.and_then(|span| sources.locate(span)).map(|at| {
            Box::new(Place {
                file: at.file.to_owned(),
                line: at.line,
                column: at.column,
                length: at.length,
                excerpt: at.excerpt,
            })
        });
        CallError {
            message: error.message.clone(),
            help: error.help.clone(),
            code: Some(error.code.as_str()),
            place,
        }
    }

    /// As JSON.
    pub fn json(&self) -> Json {
        let mut out = json!({ "message": self.message, "help": self.help, "code": self.code });
        if let Some(at) = &self.place {
            out["file"] = json!(at.file);
            out["line"] = json!(at.line);
            out["column"] = json!(at.column);
            out["end_column"] = json!(at.column + at.length);
            out["excerpt"] = json!(at.excerpt);
        }
        out
    }
}

impl From<&LoadError> for CallError {
    fn from(error: &LoadError) -> CallError {
        CallError::of_scene(&error.error, &error.sources)
    }
}

impl From<LoadError> for CallError {
    fn from(error: LoadError) -> CallError {
        CallError::from(&error)
    }
}

impl From<SceneError> for CallError {
    fn from(error: SceneError) -> CallError {
        CallError::of_scene(&error, &Sources::default())
    }
}
