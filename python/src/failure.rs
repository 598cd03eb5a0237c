//! Errors as Python sees them: the program's own text, and where it is about a file, which file and row.

use std::error::Error;
use std::path::Path;

use motorlab::cli::{Failure, unreadable};
use motorlab::recording::ReadError;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

pyo3::create_exception!(
    motorlab,
    MotorlabError,
    PyValueError,
    "Error of the program for wrong use or bad input, in the same words.\n\nkind, file, row and remedy are those of the program's --json."
);

/// Wrong use or bad input.
pub(crate) fn refused(py: Python<'_>, error: impl Error + Send + Sync + 'static) -> PyErr {
    raised(py, &Failure::input(error))
}

/// Wrong use or bad input of several kinds.
pub(crate) fn refused_of(py: Python<'_>, error: Box<dyn Error + Send + Sync>) -> PyErr {
    raised(py, &Failure::input_of(error))
}

/// A run file that cannot be read.
pub(crate) fn not_read(py: Python<'_>, path: &Path, error: ReadError) -> PyErr {
    raised(py, &unreadable(path, error))
}

/// A failure as an exception.
pub(crate) fn raised(py: Python<'_>, failure: &Failure) -> PyErr {
    let document = failure.document();
    let told = &document["error"];
    let text = told["message"].as_str().unwrap_or_default().to_owned();
    let error = MotorlabError::new_err(text);
    let value = error.value(py);
    for key in ["kind", "file", "remedy"] {
        // Setting an attribute of one's own exception does not fail.
        let _ = value.setattr(key, told[key].as_str());
    }
    let _ = value.setattr("row", told["row"].as_u64());
    error
}
