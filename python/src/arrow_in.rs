//! Columns of any frame that speaks Arrow's PyCapsule interface (pandas, polars, DuckDB, pyarrow).

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::{
    Float16Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type,
    UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrowPrimitiveType, RecordBatch, RecordBatchReader};
use arrow_schema::{DataType, TimeUnit};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::failure::refused;
use crate::frame::{Column, Numbers};

/// The columns of numbers of an Arrow stream; what is no number (text, lists) is left out.
pub(crate) fn columns_of(py: Python<'_>, capsule: &Bound<'_, PyCapsule>) -> PyResult<Vec<Column>> {
    let stream = capsule.pointer_checked(Some(c"arrow_array_stream"))?;
    // SAFETY: the capsule's name says that it holds a stream of Arrow's C interface. It is moved out, and an empty one stays behind,
    // as the interface asks.
    let reader = unsafe {
        RecordBatchStreamReader::from_raw(stream.as_ptr().cast::<FFI_ArrowArrayStream>())
    };
    let reader = reader.map_err(|error| refused(py, error))?;
    let schema = reader.schema();
    let batches: Result<Vec<RecordBatch>, _> = reader.collect();
    let batches = batches.map_err(|error| refused(py, error))?;
    let mut columns = Vec::new();
    for (at, field) in schema.fields().iter().enumerate() {
        let parts: Vec<&dyn Array> = batches
            .iter()
            .map(|batch| batch.column(at).as_ref())
            .collect();
        if let Some(numbers) = numbers(&parts, field.data_type()) {
            columns.push(Column {
                name: field.name().clone(),
                numbers,
                unit: unit_of(field.data_type()),
            });
        }
    }
    match columns.is_empty() {
        true => Err(PyTypeError::new_err("the frame has no column of numbers")),
        false => Ok(columns),
    }
}

fn unit_of(kind: &DataType) -> Option<&'static str> {
    match kind {
        DataType::Timestamp(unit, _) | DataType::Duration(unit) => Some(match unit {
            TimeUnit::Second => "s",
            TimeUnit::Millisecond => "ms",
            TimeUnit::Microsecond => "us",
            TimeUnit::Nanosecond => "ns",
        }),
        _ => None,
    }
}

fn numbers(parts: &[&dyn Array], kind: &DataType) -> Option<Numbers> {
    Some(match kind {
        DataType::Float64 => floats::<Float64Type>(parts, |x| x),
        DataType::Float32 => floats::<Float32Type>(parts, f64::from),
        DataType::Float16 => floats::<Float16Type>(parts, f64::from),
        DataType::Int8 => wholes::<Int8Type>(parts, i64::from),
        DataType::Int16 => wholes::<Int16Type>(parts, i64::from),
        DataType::Int32 => wholes::<Int32Type>(parts, i64::from),
        DataType::Int64 => wholes::<Int64Type>(parts, |x| x),
        DataType::UInt8 => wholes::<UInt8Type>(parts, i64::from),
        DataType::UInt16 => wholes::<UInt16Type>(parts, i64::from),
        DataType::UInt32 => wholes::<UInt32Type>(parts, i64::from),
        DataType::UInt64 => floats::<UInt64Type>(parts, |x| x as f64),
        DataType::Boolean => Numbers::Floats(
            (parts.iter())
                .flat_map(|part| part.as_boolean().iter())
                .map(|value| value.map_or(f64::NAN, |value| f64::from(u8::from(value))))
                .collect(),
        ),
        // Counted in whole units, whatever the unit.
        DataType::Timestamp(..) | DataType::Duration(_) => {
            let data = parts.iter().map(|part| {
                let data = part.to_data().into_builder().data_type(DataType::Int64);
                // SAFETY: the layout of a time stamp is that of a whole number of 64 bits.
                arrow_array::make_array(unsafe { data.build_unchecked() })
            });
            let data: Vec<_> = data.collect();
            let parts: Vec<&dyn Array> = data.iter().map(AsRef::as_ref).collect();
            wholes::<Int64Type>(&parts, |x| x)
        }
        _ => return None,
    })
}

fn floats<T: ArrowPrimitiveType>(parts: &[&dyn Array], of: impl Fn(T::Native) -> f64) -> Numbers {
    let values = parts
        .iter()
        .flat_map(|part| part.as_primitive::<T>().iter());
    Numbers::Floats(values.map(|value| value.map_or(f64::NAN, &of)).collect())
}

fn wholes<T: ArrowPrimitiveType>(parts: &[&dyn Array], of: impl Fn(T::Native) -> i64) -> Numbers {
    if parts.iter().any(|part| part.null_count() > 0) {
        return floats::<T>(parts, |value| of(value) as f64);
    }
    let values = parts
        .iter()
        .flat_map(|part| part.as_primitive::<T>().iter());
    Numbers::Wholes(values.flatten().map(of).collect())
}
