//! A run as a Parquet file: the columns of the run file under the same names, its header as metadata.
//!
//! Numbers are `DOUBLE` and `INT64`, flags are text. An empty cell is null. The header is the value of the key
//! `motorlab-run/1` in the file's metadata, as TOML.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use crate::recording::{RUN_FORMAT, Run, difference_velocities};

/// Rows per row group.
const GROUP_ROWS: usize = 1 << 20;

enum Column<'a> {
    Whole(Vec<i64>),
    Number(&'a [f64]),
    /// NaN is an empty cell.
    Measured(&'a [f64]),
    Speed(Vec<Option<f64>>),
    Text(Vec<String>),
}

/// Writes the run.
///
/// # Errors
/// `sink` fails, or a column does not fit the format.
pub fn write_run(run: &Run, sink: impl Write + Send) -> Result<(), ParquetError> {
    let columns = columns(run);
    let fields = columns
        .iter()
        .map(|(name, column)| field(name, column))
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("run")
        .with_fields(fields)
        .build()?;
    let header = KeyValue::new(RUN_FORMAT.to_owned(), run.header.to_string());
    let writer = KeyValue::new(
        "written_by".to_owned(),
        "written by motorlab export".to_owned(),
    );
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(concat!("motorlab ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(vec![header, writer]))
        .build();
    let mut writer = SerializedFileWriter::new(sink, Arc::new(schema), Arc::new(properties))?;
    for from in (0..run.len()).step_by(GROUP_ROWS) {
        let rows = from..run.len().min(from + GROUP_ROWS);
        let mut group = writer.next_row_group()?;
        for (_, column) in &columns {
            write_column(&mut group, column, rows.clone())?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}

/// The columns of the run, in the order of the run file.
fn columns(run: &Run) -> Vec<(&'static str, Column<'_>)> {
    let speeds = run.velocity_rad_s.clone().unwrap_or_else(|| {
        let seq = run.seq.as_deref();
        difference_velocities(&run.counts, seq, run.counts_per_rev, run.sample_time_s)
    });
    let mut columns = Vec::new();
    if let Some(seq) = &run.seq {
        let whole = seq.iter().map(|&n| i64::try_from(n).unwrap_or(i64::MAX));
        columns.push(("seq", Column::Whole(whole.collect())));
    }
    columns.push(("t_s", Column::Number(&run.t_s)));
    if let Some(host_t_s) = &run.host_t_s {
        columns.push(("host_t_s", Column::Measured(host_t_s)));
    }
    columns.push((run.command_kind.column(), Column::Number(&run.command)));
    columns.push(("counts", Column::Whole(run.counts.clone())));
    columns.push(("velocity_rad_s", Column::Speed(speeds)));
    if let Some(flags) = &run.flags {
        let text = flags.iter().map(ToString::to_string);
        columns.push(("flags", Column::Text(text.collect())));
    }
    if let Some(supply_v) = &run.measured_supply_v {
        columns.push(("supply_v", Column::Measured(supply_v)));
    }
    if let Some(current_a) = &run.measured_current_a {
        columns.push(("current_a", Column::Measured(current_a)));
    }
    columns
}

fn field(name: &str, column: &Column<'_>) -> Result<Arc<Type>, ParquetError> {
    let (physical, repetition) = match column {
        Column::Whole(_) => (Physical::INT64, Repetition::REQUIRED),
        Column::Number(_) => (Physical::DOUBLE, Repetition::REQUIRED),
        Column::Measured(_) | Column::Speed(_) => (Physical::DOUBLE, Repetition::OPTIONAL),
        Column::Text(_) => (Physical::BYTE_ARRAY, Repetition::REQUIRED),
    };
    let logical = matches!(column, Column::Text(_)).then_some(LogicalType::String);
    let field = Type::primitive_type_builder(name, physical)
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()?;
    Ok(Arc::new(field))
}

fn write_column<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    column: &Column<'_>,
    rows: std::ops::Range<usize>,
) -> Result<(), ParquetError> {
    let mut writer = group
        .next_column()?
        .ok_or_else(|| ParquetError::General("a column more than the schema has".to_owned()))?;
    let optional = |values: &mut dyn Iterator<Item = Option<f64>>| {
        let (mut present, mut levels) = (Vec::new(), Vec::new());
        for value in values {
            levels.push(i16::from(value.is_some()));
            present.extend(value);
        }
        (present, levels)
    };
    match column {
        Column::Whole(values) => {
            let writer = writer.typed::<Int64Type>();
            writer.write_batch(&values[rows], None, None)?;
        }
        Column::Number(values) => {
            let writer = writer.typed::<DoubleType>();
            writer.write_batch(&values[rows], None, None)?;
        }
        Column::Measured(values) => {
            let mut there = values[rows].iter().map(|&x| (!x.is_nan()).then_some(x));
            let (present, levels) = optional(&mut there);
            let writer = writer.typed::<DoubleType>();
            writer.write_batch(&present, Some(&levels), None)?;
        }
        Column::Speed(values) => {
            let (present, levels) = optional(&mut values[rows].iter().copied());
            let writer = writer.typed::<DoubleType>();
            writer.write_batch(&present, Some(&levels), None)?;
        }
        Column::Text(values) => {
            let bytes: Vec<ByteArray> = values[rows].iter().map(|t| t.as_str().into()).collect();
            let writer = writer.typed::<ByteArrayType>();
            writer.write_batch(&bytes, None, None)?;
        }
    }
    writer.close()
}
