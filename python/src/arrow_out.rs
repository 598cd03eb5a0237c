//! A run as a stream of Arrow's C interface: the run's own memory, without a copy where the layout is Arrow's.

use std::ptr::NonNull;
use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::ArrowPrimitiveType;
use arrow_array::{
    ArrayRef, Float64Array, Int64Array, PrimitiveArray, RecordBatch, RecordBatchIterator,
    StringArray,
};
use arrow_buffer::{Buffer, NullBuffer, ScalarBuffer};
use arrow_schema::{ArrowError, Field, Schema};
use motorlab::recording::Run;

use crate::run::velocities;

/// The stream of one batch with the columns of a run file.
pub(crate) fn stream_of(run: &Arc<Run>) -> Result<FFI_ArrowArrayStream, ArrowError> {
    let mut columns: Vec<(&str, ArrayRef)> = Vec::new();
    if let Some(seq) = &run.seq {
        columns.push((
            "seq",
            Arc::new(shared::<arrow_array::types::UInt64Type>(seq, run)) as ArrayRef,
        ));
    }
    let float = |values: &Vec<f64>| {
        Arc::new(shared::<arrow_array::types::Float64Type>(values, run)) as ArrayRef
    };
    columns.push(("t_s", float(&run.t_s)));
    if let Some(host_t_s) = &run.host_t_s {
        columns.push(("host_t_s", with_gaps(host_t_s, run)));
    }
    columns.push((run.command_kind.column(), float(&run.command)));
    let counts: Int64Array = shared::<arrow_array::types::Int64Type>(&run.counts, run);
    columns.push(("counts", Arc::new(counts)));
    // The one column that is laid out anew.
    let speeds: Float64Array = velocities(run).into_iter().collect();
    columns.push(("velocity_rad_s", Arc::new(speeds)));
    if let Some(flags) = &run.flags {
        let words: StringArray = flags.iter().map(|flags| Some(flags.to_string())).collect();
        columns.push(("flags", Arc::new(words)));
    }
    for (name, measured) in [
        ("supply_v", &run.measured_supply_v),
        ("current_a", &run.measured_current_a),
    ] {
        if let Some(measured) = measured {
            columns.push((name, with_gaps(measured, run)));
        }
    }
    let fields: Vec<Field> = columns
        .iter()
        .map(|(name, array)| Field::new(*name, array.data_type().clone(), is_open(name)))
        .collect();
    let schema = Arc::new(Schema::new(fields));
    let arrays = columns.into_iter().map(|(_, array)| array).collect();
    let batch = RecordBatch::try_new(schema.clone(), arrays)?;
    let batches = RecordBatchIterator::new([Ok(batch)], schema);
    Ok(FFI_ArrowArrayStream::new(Box::new(batches)))
}

/// Whether a sample may lack its value.
fn is_open(name: &str) -> bool {
    !matches!(
        name,
        "seq" | "t_s" | "counts" | "command_v" | "command_a" | "command_nm"
    )
}

/// A column of the run as an array over the same memory.
fn shared<T: ArrowPrimitiveType>(values: &[T::Native], run: &Arc<Run>) -> PrimitiveArray<T> {
    let Some(start) = NonNull::new(values.as_ptr().cast_mut().cast::<u8>()) else {
        return PrimitiveArray::from_iter_values(values.iter().copied());
    };
    // SAFETY: the memory is a column of the run, which the buffer keeps alive and which nothing changes.
    let buffer = unsafe {
        Buffer::from_custom_allocation(start, std::mem::size_of_val(values), Arc::clone(run) as _)
    };
    PrimitiveArray::new(ScalarBuffer::new(buffer, 0, values.len()), None)
}

/// The same of measured values: what a sample lacks is null, not NaN.
fn with_gaps(values: &[f64], run: &Arc<Run>) -> ArrayRef {
    let array: Float64Array = shared::<arrow_array::types::Float64Type>(values, run);
    if !values.iter().any(|value| value.is_nan()) {
        return Arc::new(array);
    }
    let known: NullBuffer = values
        .iter()
        .map(|value| !value.is_nan())
        .collect::<Vec<bool>>()
        .into();
    Arc::new(Float64Array::new(array.values().clone(), Some(known)))
}
