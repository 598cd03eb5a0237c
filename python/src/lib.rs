//! The extension module beneath the Python package `motorlab`: the library's types and one function a verb.
//!
//! Names, units and documents are the library's. Python's additions (frames, pictures, docstrings) are in `motorlab/`.

// The macros of pyo3 write items that bear no comment.
#![allow(missing_docs)]

mod apart;
mod arrow_in;
mod arrow_out;
mod asked;
mod diagnosis;
mod failure;
mod frame;
mod motor;
mod run;
mod verbs;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program with these arguments, its own name first; the exit status.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> i32 {
    py.detach(|| motorlab::cli::CommandLine::run_these(arguments) as i32)
}

#[pymodule]
mod _motorlab {
    use super::*;

    #[pymodule_export]
    use super::diagnosis::{Diagnosis, diagnose};
    #[pymodule_export]
    use super::main;
    #[pymodule_export]
    use super::motor::Motor;
    #[pymodule_export]
    use super::run::Run;
    #[pymodule_export]
    use super::verbs::{check, compare, simulate};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let error = module.py().get_type::<failure::MotorlabError>();
        module.add("MotorlabError", error)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
