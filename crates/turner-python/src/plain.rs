//! JSON as Python's plain data.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The dicts, lists, numbers and texts of a JSON text.
pub(crate) fn of_json<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,)).map_err(|e| PyValueError::new_err(e.to_string()))
}
