//! Where values that come from Python stand: the path of a value, as a position for messages.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use turner::schema::value::{FileId, Span};

/// The "file" of values from Python.
pub(crate) const PYTHON: FileId = FileId(u32::MAX - 1);

/// The paths of values from Python, each once: `objects[3].radius`. A span of [`PYTHON`] is an index into them.
#[derive(Debug, Default)]
pub(crate) struct Places(Mutex<Known>);

#[derive(Clone, Debug, Default)]
struct Known {
    paths: Vec<String>,
    numbers: HashMap<String, u32>,
}

/// The most paths that are kept: later ones share the last.
const MOST: usize = 1 << 20;

impl Places {
    /// The span of a path.
    pub(crate) fn span(&self, path: &str) -> Span {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let start = match known.numbers.get(path) {
            Some(number) => *number,
            None if known.paths.len() >= MOST => known.paths.len() as u32 - 1,
            None => {
                let number = known.paths.len() as u32;
                known.paths.push(path.to_owned());
                known.numbers.insert(path.to_owned(), number);
                number
            }
        };
        Span { file: PYTHON, start, end: start + 1 }
    }

    /// The path of a span; `None` if it is one of a file.
    pub(crate) fn path(&self, span: Span) -> Option<String> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        (span.file == PYTHON).then(|| known.paths.get(span.start as usize).cloned()).flatten()
    }
}

impl Clone for Places {
    fn clone(&self) -> Places {
        Places(Mutex::new(self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()))
    }
}
