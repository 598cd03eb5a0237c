//! A run: its columns as arrays over its own memory, its header, its file.

use std::path::PathBuf;
use std::sync::Arc;

use motorlab::cli::Failure;
use motorlab::recording::{self, difference_velocities, read_run, write_run};
use numpy::ndarray::ArrayView1;
use numpy::{Element, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::arrow_in::columns_of;
use crate::arrow_out::stream_of;
use crate::failure::{not_read, raised};
use crate::frame::{Column, Keywords, Numbers, run_of};

/// A run.
#[pyclass(module = "motorlab._motorlab", frozen)]
pub(crate) struct Run {
    pub(crate) inner: Arc<recording::Run>,
    notes: Vec<String>,
}

impl Run {
    pub(crate) fn of(run: recording::Run, notes: Vec<String>) -> Self {
        Self {
            inner: Arc::new(run),
            notes,
        }
    }
}

#[pymethods]
impl Run {
    /// Reads a run file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = py.detach(|| read_run(&path));
        let (run, notes) = read.map_err(|error| not_read(py, &path, error))?;
        Ok(Self::of(
            run,
            notes.iter().map(ToString::to_string).collect(),
        ))
    }

    /// Of an object with `__arrow_c_stream__`, or of names with arrays of numbers (float64 or int64) and units.
    #[staticmethod]
    fn from_columns(
        py: Python<'_>,
        frame: &Bound<'_, PyAny>,
        keywords: Keywords,
    ) -> PyResult<Self> {
        let columns = match frame.cast::<PyCapsule>() {
            Ok(capsule) => columns_of(py, capsule)?,
            Err(_) => listed(frame)?,
        };
        let (run, notes) = run_of(py, columns, keywords)?;
        Ok(Self::of(run, notes))
    }

    /// Writes the run file; the next free name is taken where the path exists.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<PathBuf> {
        let written = py.detach(|| write_run(&self.inner, &path));
        written.map_err(|error| raised(py, &Failure::device(error)))
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    #[getter]
    pub(crate) fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.inner.path.clone()
    }

    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s
    }

    #[getter]
    fn counts_per_rev(&self) -> f64 {
        self.inner.counts_per_rev
    }

    #[getter]
    fn supply_v(&self) -> Option<f64> {
        self.inner.supply_v
    }

    #[getter]
    fn complete(&self) -> bool {
        self.inner.complete
    }

    /// Name of the command column, which has its unit.
    #[getter]
    fn command_column(&self) -> &'static str {
        self.inner.command_kind.column()
    }

    /// The header as JSON.
    fn header(&self) -> PyResult<String> {
        serde_json::to_string(&self.inner.header)
            .map_err(|error| PyTypeError::new_err(error.to_string()))
    }

    /// Names of the columns, in the order of a run file.
    #[getter]
    fn columns(&self) -> Vec<&'static str> {
        let run = &self.inner;
        let named = [
            ("seq", run.seq.is_some()),
            ("t_s", true),
            ("host_t_s", run.host_t_s.is_some()),
            (run.command_kind.column(), true),
            ("counts", true),
            ("velocity_rad_s", true),
            ("flags", run.flags.is_some()),
            ("supply_v", run.measured_supply_v.is_some()),
            ("current_a", run.measured_current_a.is_some()),
        ];
        let there = named.into_iter().filter(|(_, is_there)| *is_there);
        there.map(|(name, _)| name).collect()
    }

    /// A column; a view of the run's memory that cannot be written, but for speeds and flags.
    fn column<'py>(slf: Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let run = Arc::clone(&slf.get().inner);
        let missing = || PyKeyError::new_err(format!("the run has no column {name}"));
        let of = |column: &Option<Vec<f64>>| {
            let column = column.as_ref().ok_or_else(missing)?;
            Ok(view(&slf, column)?.into_any())
        };
        match name {
            "t_s" => Ok(view(&slf, &run.t_s)?.into_any()),
            "counts" => Ok(view(&slf, &run.counts)?.into_any()),
            "seq" => {
                let seq = run.seq.as_ref().ok_or_else(missing)?;
                Ok(view(&slf, seq)?.into_any())
            }
            "host_t_s" => of(&run.host_t_s),
            "supply_v" => of(&run.measured_supply_v),
            "current_a" => of(&run.measured_current_a),
            "velocity_rad_s" => {
                let speeds = velocities(&run).into_iter();
                let speeds = speeds.map(|speed| speed.unwrap_or(f64::NAN)).collect();
                Ok(PyArray1::from_vec(py, speeds).into_any())
            }
            "flags" => {
                let flags = run.flags.as_ref().ok_or_else(missing)?;
                let words: Vec<String> = flags.iter().map(ToString::to_string).collect();
                words.into_pyobject(py).map(Bound::into_any)
            }
            name if name == run.command_kind.column() => Ok(view(&slf, &run.command)?.into_any()),
            _ => Err(missing()),
        }
    }

    /// Arrow's PyCapsule interface.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // Who asks for other types casts himself, as the interface allows.
        let _ = requested_schema;
        let stream =
            stream_of(&self.inner).map_err(|error| PyTypeError::new_err(error.to_string()))?;
        PyCapsule::new(py, stream, Some(c"arrow_array_stream".to_owned()))
    }
}

/// An array over a column of the run, which it keeps alive.
fn view<'py, T: Element>(
    owner: &Bound<'py, Run>,
    column: &[T],
) -> PyResult<Bound<'py, PyArray1<T>>> {
    let seen = ArrayView1::from(column);
    // SAFETY: the column is the run's, which is frozen, so that nothing moves it while the array keeps the run alive; nobody can write
    // through the array.
    let array = unsafe { PyArray1::borrow_from_array(&seen, owner.clone().into_any()) };
    let writable = array.try_readwrite()?;
    drop(writable.make_nonwriteable());
    Ok(array)
}

/// The speeds as recorded, or by the one rule.
pub(crate) fn velocities(run: &recording::Run) -> Vec<Option<f64>> {
    match &run.velocity_rad_s {
        Some(speeds) => speeds.clone(),
        None => {
            let seq = run.seq.as_deref();
            difference_velocities(&run.counts, seq, run.counts_per_rev, run.sample_time_s)
        }
    }
}

/// Names with arrays and units.
fn listed(frame: &Bound<'_, PyAny>) -> PyResult<Vec<Column>> {
    let named: Vec<(String, Bound<'_, PyAny>, Option<String>)> = frame.extract()?;
    named
        .into_iter()
        .map(|(name, array, unit)| {
            let numbers = match array.extract::<PyReadonlyArray1<'_, i64>>() {
                Ok(wholes) => Numbers::Wholes(wholes.as_array().to_vec()),
                Err(_) => {
                    let floats: PyReadonlyArray1<'_, f64> = array.extract()?;
                    Numbers::Floats(floats.as_array().to_vec())
                }
            };
            let unit = unit.map(|_| "ns");
            Ok(Column {
                name,
                numbers,
                unit,
            })
        })
        .collect()
}
