//! Errors of scenes as Python's exceptions, and warnings as Python's.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use turner::schema::{SceneError, Warning};
use turner_io::scene::Sources;

use crate::places::Places;

/// The module with the exceptions.
const MODULE: &str = "turner._errors";

/// What locates the positions of errors and warnings.
#[derive(Clone, Copy)]
pub(crate) struct Origin<'a> {
    /// The texts of the scene's files.
    pub(crate) sources: &'a Sources,
    /// The paths of values from Python.
    pub(crate) places: &'a Places,
}

impl Origin<'_> {
    /// `turner.SceneError` with the attributes `code`, `message`, `file`, `line`, `column`, `path`, `help` and `others`.
    pub(crate) fn error(self, py: Python<'_>, error: &SceneError) -> PyErr {
        self.exception(py, error).map_or_else(|e| e, PyErr::from_value)
    }

    fn exception<'py>(self, py: Python<'py>, error: &SceneError) -> PyResult<Bound<'py, PyAny>> {
        let facts = PyDict::new(py);
        facts.set_item("code", error.code.as_str())?;
        facts.set_item("message", &error.message)?;
        facts.set_item("help", &error.help)?;
        if let Some(span) = error.span {
            if let Some(at) = self.sources.locate(span) {
                facts.set_item("file", at.file)?;
                facts.set_item("line", at.line)?;
                facts.set_item("column", at.column)?;
            }
            facts.set_item("path", self.places.path(span))?;
        }
        let others = PyList::empty(py);
        for other in &error.more {
            others.append(self.exception(py, other)?)?;
        }
        facts.set_item("others", others)?;
        py.import(MODULE)?.getattr("SceneError")?.call((), Some(&facts))
    }

    /// Issues `turner.SceneWarning`s, those of a kind that is only noted excepted.
    pub(crate) fn warn(self, py: Python<'_>, warnings: &[Warning]) -> PyResult<()> {
        if warnings.is_empty() {
            return Ok(());
        }
        let issue = py.import(MODULE)?.getattr("issue")?;
        for warning in warnings {
            let at = warning.span.and_then(|span| self.sources.locate(span));
            let place = match (&at, warning.span) {
                (Some(at), _) => Some(format!("{}:{}:{}", at.file, at.line, at.column)),
                (None, Some(span)) => self.places.path(span),
                (None, None) => None,
            };
            issue.call1((warning.kind.word(), &warning.message, place, warning.count))?;
        }
        Ok(())
    }
}
