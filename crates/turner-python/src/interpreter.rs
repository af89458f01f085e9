//! Which interpreter imports the module.
#![allow(unsafe_code)]

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;

/// Errors: an interpreter other than the main one. Classes and caches of this module are those of the process, which
/// interpreters with locks of their own may not share.
pub(crate) fn check(_: Python<'_>) -> PyResult<()> {
    // SAFETY: the token proves that this thread is attached to an interpreter, which `PyInterpreterState_Get` returns; its
    // number is only read.
    let number = unsafe { pyo3::ffi::PyInterpreterState_GetID(pyo3::ffi::PyInterpreterState_Get()) };
    if number == 0 {
        return Ok(());
    }
    Err(PyImportError::new_err(
        "turner cannot be imported by a subinterpreter; use threads (the GIL is released while it renders) or processes",
    ))
}
