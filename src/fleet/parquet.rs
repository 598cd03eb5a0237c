//! Tables as Parquet files: text, `DOUBLE` and `INT64`, every cell optional.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::table::{Column, Table, Values};

/// Writes a table; the file's metadata names the program that wrote it.
///
/// # Errors
/// `sink` fails.
pub fn write_table(table: &Table, sink: impl Write + Send) -> Result<(), ParquetError> {
    let fields = table
        .columns
        .iter()
        .map(field)
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("table")
        .with_fields(fields)
        .build()?;
    let writer = KeyValue::new(
        "written_by".to_owned(),
        "written by motorlab tabulate".to_owned(),
    );
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(concat!("motorlab ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(vec![writer]))
        .build();
    let mut writer = SerializedFileWriter::new(sink, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in &table.columns {
        match &column.values {
            Values::Text(cells) => {
                let cells = cells
                    .iter()
                    .map(|cell| cell.as_deref().map(ByteArray::from));
                put::<ByteArrayType, _>(&mut group, cells)?;
            }
            Values::Number(cells) => put::<DoubleType, _>(&mut group, cells.iter().copied())?,
            Values::Whole(cells) => put::<Int64Type, _>(&mut group, cells.iter().copied())?,
        }
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let physical = match column.values {
        Values::Text(_) => Physical::BYTE_ARRAY,
        Values::Number(_) => Physical::DOUBLE,
        Values::Whole(_) => Physical::INT64,
    };
    let builder =
        Type::primitive_type_builder(column.name, physical).with_repetition(Repetition::OPTIONAL);
    let builder = match column.values {
        Values::Text(_) => builder.with_logical_type(Some(LogicalType::String)),
        _ => builder,
    };
    Ok(Arc::new(builder.build()?))
}

fn put<D: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: impl Iterator<Item = Option<D::T>>,
) -> Result<(), ParquetError> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    for cell in cells {
        levels.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("a column too many".to_owned()));
    };
    column
        .typed::<D>()
        .write_batch(&values, Some(&levels), None)?;
    column.close()
}
