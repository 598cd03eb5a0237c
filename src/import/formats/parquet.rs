//! Apache Parquet: every flat numeric column. Time stamps are seconds relative to the first.

use ::bytes::Bytes;
use ::parquet::basic::{ConvertedType, LogicalType, TimeUnit};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use ::parquet::data_type::{
    BoolType, DataType, DoubleType, FloatType, Int32Type, Int64Type, Int96, Int96Type,
};
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;

use super::super::table::{Table, TableColumn, of_f32};
use super::{Form, FormatError, MOST_VALUES};

const FORM: Form = Form::Parquet;
/// Values read at a time.
const BATCH: usize = 1 << 14;
/// Days from the Julian day of 96-bit time stamps to 1970.
const JULIAN_1970: i64 = 2_440_588;
const DAY_NS: i64 = 86_400_000_000_000;

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let broken = |error: ParquetError| FORM.broken(error);
    let file = SerializedFileReader::new(Bytes::copy_from_slice(bytes)).map_err(broken)?;
    let schema = file.metadata().file_metadata().schema_descr_ptr();
    let rows: i64 = (file.metadata().row_groups().iter())
        .map(|group| group.num_rows())
        .fold(0, i64::saturating_add);
    let wanted: Vec<usize> = (0..schema.num_columns())
        .filter(|&at| is_number(&schema.column(at)))
        .collect();
    let rows =
        usize::try_from(rows).map_err(|_| FORM.broken("it has a negative number of rows"))?;
    if rows.saturating_mul(wanted.len()) > MOST_VALUES {
        return Err(FORM.too_much("values"));
    }
    let mut columns: Vec<Numbers> = wanted.iter().map(|_| Numbers::default()).collect();
    for group in 0..file.num_row_groups() {
        let group = file.get_row_group(group).map_err(broken)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        for (column, &at) in columns.iter_mut().zip(&wanted) {
            let descriptor = schema.column(at);
            let reader = group.get_column_reader(at).map_err(broken)?;
            column.read(reader, &descriptor, rows).map_err(broken)?;
        }
    }
    let left_out: Vec<String> = (0..schema.num_columns())
        .filter(|at| !wanted.contains(at))
        .map(|at| schema.column(at).path().string())
        .collect();
    let named = wanted.iter().zip(columns).map(|(&at, column)| {
        let descriptor = schema.column(at);
        let unit = ns_per_tick(&descriptor).map(|_| "s".to_owned());
        let name = descriptor.path().string();
        (TableColumn { name, unit }, column.numbers())
    });
    let mut table = Table::whole(named.collect());
    if !left_out.is_empty() {
        table.notes.push(format!(
            "columns that are no plain numbers are left out: {}",
            left_out.join(", ")
        ));
    }
    Ok(table)
}

/// Whether a column has one number per row.
fn is_number(column: &ColumnDescriptor) -> bool {
    use ::parquet::basic::Type as Physical;
    let is_plain = !matches!(
        column.logical_type_ref(),
        Some(LogicalType::Decimal(_) | LogicalType::Date | LogicalType::Time(_))
    ) && !matches!(column.converted_type(), ConvertedType::DECIMAL);
    column.max_rep_level() == 0
        && is_plain
        && matches!(
            column.physical_type(),
            Physical::BOOLEAN
                | Physical::INT32
                | Physical::INT64
                | Physical::INT96
                | Physical::FLOAT
                | Physical::DOUBLE
        )
}

/// Nanoseconds per tick of a time stamp; `None` for other types.
fn ns_per_tick(column: &ColumnDescriptor) -> Option<i64> {
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(stamp)), _) => Some(match stamp.unit {
            TimeUnit::MILLIS => 1_000_000,
            TimeUnit::MICROS => 1000,
            TimeUnit::NANOS => 1,
        }),
        (_, ConvertedType::TIMESTAMP_MILLIS) => Some(1_000_000),
        (_, ConvertedType::TIMESTAMP_MICROS) => Some(1000),
        _ if column.physical_type() == ::parquet::basic::Type::INT96 => Some(1),
        _ => None,
    }
}

#[derive(Debug, Default)]
struct Numbers {
    found: Vec<f64>,
    /// The first time stamp in ticks.
    first: Option<i64>,
}

impl Numbers {
    fn numbers(self) -> Vec<f64> {
        self.found
    }

    fn read(
        &mut self,
        reader: ColumnReader,
        column: &ColumnDescriptor,
        rows: usize,
    ) -> Result<(), ParquetError> {
        let tick_ns = ns_per_tick(column);
        let levels = column.max_def_level();
        let mut first = self.first;
        let mut since_first = |ticks: i64, tick_ns: i64| {
            let first = *first.get_or_insert(ticks);
            ticks.wrapping_sub(first) as f64 * tick_ns as f64 / 1e9
        };
        let found = &mut self.found;
        match reader {
            ColumnReader::BoolColumnReader(reader) => {
                all::<BoolType>(reader, levels, rows, found, |x| f64::from(u8::from(*x)))?;
            }
            ColumnReader::Int32ColumnReader(reader) => {
                let is_unsigned = column.converted_type() == ConvertedType::UINT_32;
                all::<Int32Type>(reader, levels, rows, found, |x| match is_unsigned {
                    true => f64::from(*x as u32),
                    false => f64::from(*x),
                })?;
            }
            ColumnReader::Int64ColumnReader(reader) => {
                all::<Int64Type>(reader, levels, rows, found, |x| match tick_ns {
                    Some(tick_ns) => since_first(*x, tick_ns),
                    None => *x as f64,
                })?;
            }
            ColumnReader::Int96ColumnReader(reader) => {
                let ns = |stamp: &Int96| {
                    let [low, high, day] = [0, 1, 2].map(|k| i64::from(stamp.data()[k]));
                    let of_day = low | high << 32;
                    (day - JULIAN_1970)
                        .wrapping_mul(DAY_NS)
                        .wrapping_add(of_day)
                };
                all::<Int96Type>(reader, levels, rows, found, |x| since_first(ns(x), 1))?;
            }
            ColumnReader::FloatColumnReader(reader) => {
                all::<FloatType>(reader, levels, rows, found, |x| of_f32(*x))?;
            }
            ColumnReader::DoubleColumnReader(reader) => {
                all::<DoubleType>(reader, levels, rows, found, |x| *x)?;
            }
            _ => {}
        }
        self.first = first;
        Ok(())
    }
}

/// Reads a column of a row group; a null is NaN.
fn all<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    levels: i16,
    rows: usize,
    found: &mut Vec<f64>,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<(), ParquetError> {
    let end = found.len() + rows;
    let (mut values, mut present) = (Vec::new(), Vec::new());
    while found.len() < end {
        values.clear();
        present.clear();
        let most = BATCH.min(end - found.len());
        let (records, _, _) = reader.read_records(most, Some(&mut present), None, &mut values)?;
        if records == 0 {
            return Err(ParquetError::EOF(
                "a column is shorter than its row group".to_owned(),
            ));
        }
        let mut values = values.iter();
        for at in 0..records {
            let is_there = levels == 0 || present.get(at) == Some(&levels);
            let value = is_there.then(|| values.next()).flatten();
            found.push(value.map_or(f64::NAN, &mut number));
        }
    }
    Ok(())
}
