//! Data frames of pandas as `DataFrame.to_json` writes them: from the orients `split`, `table`, `index` and `columns`
//! to a table. An index other than the row numbers becomes a column.

use serde_json::{Map, Value};

use super::super::table::{Table, TableColumn};
use super::json::{Columns, number};
use super::{Form, FormatError};

const FORM: Form = Form::Json;
/// An object with fewer rows is a nested document.
const LEAST_ROWS: usize = 3;
const INDEX_COLUMN: &str = "index";

/// A frame in the orient `split`, `table` or `index`.
pub(super) fn of_pandas(map: &Map<String, Value>) -> Result<Option<Table>, FormatError> {
    let list = |key: &str| map.get(key).and_then(Value::as_array);
    let has_fields = map
        .get("schema")
        .is_some_and(|schema| schema.get("fields").is_some());
    match (list("columns"), list("data")) {
        (Some(names), Some(rows)) => split_orient(names, rows, list("index")),
        (None, Some(rows)) if has_fields => {
            let mut columns = Columns::default();
            rows.iter().try_for_each(|row| columns.row(row))?;
            Ok(Some(columns.table()))
        }
        _ => index_orient(map),
    }
}

fn split_orient(
    names: &[Value],
    rows: &[Value],
    index: Option<&Vec<Value>>,
) -> Result<Option<Table>, FormatError> {
    let names: Option<Vec<String>> = names.iter().map(column_name).collect();
    let rows: Option<Vec<&Vec<Value>>> = rows.iter().map(Value::as_array).collect();
    let (Some(names), Some(rows)) = (names, rows) else {
        return Ok(None);
    };
    if rows.iter().any(|row| row.len() != names.len()) {
        return Ok(None);
    }
    let index: Option<Vec<f64>> = index.and_then(|index| index.iter().map(number).collect());
    let index = index.filter(|index| index.len() == rows.len() && differs_from_row_numbers(index));
    let mut columns = Columns::default();
    for (at, row) in rows.into_iter().enumerate() {
        if let Some(index) = &index {
            columns.put(INDEX_COLUMN, index[at]);
        }
        for (name, value) in names.iter().zip(row) {
            columns.put_value(name, value, 1);
        }
        columns.end_row(FORM)?;
    }
    Ok(Some(columns.table()))
}

/// An object of rows with the index as keys.
fn index_orient(map: &Map<String, Value>) -> Result<Option<Table>, FormatError> {
    let is_row = |row: &&Value| {
        let names = row.as_object().map(Map::keys);
        names.is_some_and(|mut names| names.all(|name| name.parse::<f64>().is_err()))
    };
    let is_frame =
        |(_, rows): &(Vec<f64>, Vec<&Value>)| rows.len() >= LEAST_ROWS && rows.iter().all(is_row);
    let Some((index, rows)) = sorted_by_index(map).filter(is_frame) else {
        return Ok(None);
    };
    let has_index_column = differs_from_row_numbers(&index);
    let mut columns = Columns::default();
    for (index, row) in index.iter().zip(rows) {
        if has_index_column {
            columns.put(INDEX_COLUMN, *index);
        }
        columns.row(row)?;
    }
    Ok(Some(columns.table()))
}

/// Lists of equal length, or the orient `columns`: an object of columns with the index as keys.
pub(super) fn of_columns(map: &Map<String, Value>) -> Option<Table> {
    let indexed_numbers = |value: &Value| -> Option<Indexed> {
        let (index, values): (Vec<f64>, Vec<&Value>) = match value {
            Value::Array(values) => (Vec::new(), values.iter().collect()),
            Value::Object(rows) => sorted_by_index(rows)?,
            _ => return None,
        };
        let cell = |value: &Value| match value {
            Value::Null => Some(f64::NAN),
            value => number(value),
        };
        Some((index, values.into_iter().map(cell).collect::<Option<_>>()?))
    };
    let column = |name: &str| TableColumn {
        name: name.to_owned(),
        unit: None,
    };
    let read = |(name, value): (&String, &Value)| Some((column(name), indexed_numbers(value)?));
    let found: Vec<(TableColumn, Indexed)> = map.iter().filter_map(read).collect();
    let (index, first) = found.first().map(|(_, first)| first)?;
    let (index, rows) = (index.clone(), first.len());
    let has_same_rows =
        |(_, (other, numbers)): &(TableColumn, Indexed)| *other == index && numbers.len() == rows;
    if rows < LEAST_ROWS || found.len() < 2 || !found.iter().all(has_same_rows) {
        return None;
    }
    let index = Some(index).filter(|index| differs_from_row_numbers(index));
    let index = index.map(|index| (column(INDEX_COLUMN), index)).into_iter();
    let columns = found
        .into_iter()
        .map(|(column, (_, numbers))| (column, numbers));
    Some(Table::whole(index.chain(columns).collect()))
}

/// Index of a column, empty for a list, and its numbers.
type Indexed = (Vec<f64>, Vec<f64>);

fn differs_from_row_numbers(index: &[f64]) -> bool {
    index.iter().enumerate().any(|(at, x)| *x != at as f64)
}

/// The levels of a `MultiIndex` are joined.
fn column_name(value: &Value) -> Option<String> {
    match value {
        Value::String(name) => Some(name.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Array(levels) => {
            let levels: Option<Vec<String>> = levels.iter().map(column_name).collect();
            levels.map(|levels| levels.join("."))
        }
        _ => None,
    }
}

/// Index and values in the order of the index: the map's keys are sorted as text.
fn sorted_by_index(map: &Map<String, Value>) -> Option<(Vec<f64>, Vec<&Value>)> {
    let key = |(key, value)| Some((number(&Value::String(String::clone(key)))?, value));
    let mut rows: Vec<(f64, &Value)> = map.iter().map(key).collect::<Option<_>>()?;
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    (!rows.is_empty()).then(|| rows.into_iter().unzip())
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::super::json::tests::text;

    #[test]
    fn every_orient_is_read_in_the_order_of_its_index() {
        let (mut rows, mut list, mut by_row) = (String::new(), String::new(), String::new());
        let (mut t, mut u, mut index) = (String::new(), String::new(), String::new());
        for k in 0..12 {
            let comma = if k > 0 { "," } else { "" };
            let _ = writeln!(rows, "{},{}", 10 * k, k % 5);
            let _ = write!(list, "{comma}[{},{}]", 10 * k, k % 5);
            let _ = write!(
                by_row,
                "{comma}\"{k}\":{{\"t\":{},\"u\":{}}}",
                10 * k,
                k % 5
            );
            let _ = write!(t, "{comma}\"{k}\":{}", 10 * k);
            let _ = write!(u, "{comma}\"{k}\":{}", k % 5);
            let _ = write!(index, "{comma}{k}");
        }
        let records: Vec<&str> = by_row.split_inclusive('}').collect();
        let records: String = (records.iter())
            .map(|row| row[row.find('{').expect("a row")..].to_owned() + ",")
            .collect();
        for json in [
            format!("{{\"columns\":[\"t\",\"u\"],\"index\":[{index}],\"data\":[{list}]}}"),
            format!("{{{by_row}}}"),
            format!("{{\"t\":{{{t}}},\"u\":{{{u}}}}}"),
            format!(
                "{{\"schema\":{{\"fields\":[]}},\"data\":[{}]}}",
                records.trim_end_matches(',')
            ),
        ] {
            assert_eq!(text(&json), format!("\"t\",\"u\"\n{rows}"), "{json}");
        }
    }

    #[test]
    fn an_index_of_times_is_a_column() {
        let table = "\"index\",\"n\",\"u\"\n0,3,5\n0.5,4,6\n1,5,\n";
        for json in [
            "{\"columns\":[\"n\",\"u\"],\"index\":[0.0,0.5,1.0],\"data\":[[3,5],[4,6],[5,null]]}",
            "{\"0.0\":{\"n\":3,\"u\":5},\"0.5\":{\"n\":4,\"u\":6},\"1.0\":{\"n\":5,\"u\":null}}",
            "{\"n\":{\"0.0\":3,\"0.5\":4,\"1.0\":5},\"u\":{\"0.0\":5,\"0.5\":6,\"1.0\":null}}",
        ] {
            assert_eq!(text(json), table, "{json}");
        }
    }
}
