//! From the lines above the first row to names and units of the columns, and to the mapping's keys `skip_lines`,
//! `names` and `unit_lines`.

use super::super::cells::{Cells, Separator, decode, number};
use super::super::labels::labels;
use super::super::stamp::stamp;
use super::column::Column;
use super::commas::COMMAS_WITHIN;
use super::survey::Survey;
use super::table::{Layout, Numbered};
use super::units::unit_of;

/// Rows that are tested for an index in the first cell.
const INDEX_ROWS: usize = 3;

pub(super) fn cells_of(line: &[u8], separator: Separator) -> Vec<String> {
    let mut cells = Cells::default();
    cells.split(line, separator);
    let mut found: Vec<String> = (0..cells.len())
        .map(|at| cells.text(at).into_owned())
        .collect();
    while found.len() > 1 && found.last().is_some_and(String::is_empty) {
        found.pop();
    }
    found
}

fn is_name(cell: &str) -> bool {
    !cell.is_empty() && number(cell.as_bytes(), true, "").is_err()
}

/// Whether no cell is a number, except for a terminal's time stamp and the unnamed index of pandas.
pub(super) fn all_words(cells: &[String]) -> bool {
    let is_stamp_or_index = |cell: &String| cell.is_empty() || stamp(cell.as_bytes()).is_some();
    let from = usize::from(cells.first().is_some_and(is_stamp_or_index));
    cells.len() > from && cells[from..].iter().all(|cell| is_name(cell))
}

pub(super) fn is_names(cells: &Cells) -> bool {
    let texts: Vec<String> = (0..cells.len())
        .map(|at| cells.text(at).into_owned())
        .collect();
    all_words(&texts)
}

/// A unit without its brackets, and without the `Unit: ` of Simulink's Data Inspector.
fn unit_in(cell: &str) -> &str {
    let cell = cell.strip_prefix("Unit:").unwrap_or(cell).trim();
    cell.trim_matches(['[', ']', '(', ')'])
}

/// A line of units between names and rows, such as `ms;V;deg`.
fn is_units(cells: &[String]) -> bool {
    use super::units::Role::{Command, Current, Position, Speed, Time};
    let is_unit = |cell: &String| {
        let cell = unit_in(cell);
        let roles = [Time, Position, Speed, Command, Current];
        let is_known = || roles.into_iter().any(|role| unit_of(role, cell).is_some());
        cell.is_empty() || matches!(cell, "-" | "1" | "PWM") || is_known()
    };
    cells.iter().any(|cell| !cell.is_empty()) && cells.iter().all(is_unit)
}

pub(super) fn name_columns(found: &mut Survey, table: &[Numbered], layout: &Layout) {
    let lines_before_rows = table[layout.first].0 - 1;
    if layout.separator == Separator::Labels {
        found.file.skip_lines = lines_before_rows;
        let labels = labels(&table[layout.first].1).unwrap_or_default();
        for (column, label) in found.columns.iter_mut().zip(labels) {
            column.name = Some(decode(&label).into_owned()).filter(|name| !name.is_empty());
            column.is_by_name = column.name.is_some();
        }
        only_one_of_a_name(&mut found.columns);
        return;
    }
    let above = |back: usize| {
        let at = layout.first.checked_sub(back)?;
        let (line, text) = &table[at];
        Some((*line, cells_of(text, layout.separator)))
    };
    let is_header =
        |cells: &[String]| all_words(cells) && cells.len() == layout.columns && !is_banner(cells);
    let is_header_line = |header: &Option<(u64, Vec<String>)>| {
        header.as_ref().is_some_and(|(_, cells)| is_header(cells))
    };
    let (last, second_last) = (above(1), above(2));
    let has_units = is_header_line(&second_last)
        && last
            .as_ref()
            .is_some_and(|(_, cells)| cells.len() <= layout.columns && is_units(cells));
    let (header, units) = if has_units {
        (second_last, last)
    } else {
        (last, None)
    };
    match header {
        Some((line, cells)) if is_header(&cells) => {
            found.file.skip_lines = line - 1;
            found.file.names = Some(true);
            found.file.unit_lines = u64::from(units.is_some());
            for (column, name) in found.columns.iter_mut().zip(cells) {
                column.name =
                    Some(name).filter(|name| !name.is_empty() && stamp(name.as_bytes()).is_none());
                column.is_by_name = column.name.is_some();
            }
            for (column, unit) in found
                .columns
                .iter_mut()
                .zip(units.into_iter().flat_map(|(_, cells)| cells))
            {
                column.unit_line = Some(unit_in(&unit).to_owned());
            }
        }
        // The rows have one cell more than the names: a terminal's time stamp, or the row names of R.
        Some((_, cells))
            if all_words(&cells)
                && cells.len() + 1 == layout.columns
                && !is_banner(&cells)
                && have_index(&table[layout.first..], layout.separator) =>
        {
            found.file.skip_lines = lines_before_rows;
            found.file.names = Some(false);
            for (column, name) in found.columns.iter_mut().skip(1).zip(cells) {
                column.name = Some(name);
            }
        }
        Some(_) => {
            found.file.skip_lines = lines_before_rows;
            found.file.names = Some(false);
            found
                .notes
                .extend(note_on_commas(&table[..layout.first], layout));
        }
        None => found.file.names = Some(false),
    }
    only_one_of_a_name(&mut found.columns);
}

/// Decimal commas make more cells in the rows than in the line of names.
fn note_on_commas(above: &[Numbered], layout: &Layout) -> Option<String> {
    let mut lines = above
        .iter()
        .rev()
        .map(|(_, line)| cells_of(line, layout.separator));
    let names = lines.find(|cells| cells.len() > 1 && all_words(cells))?;
    let is_short = names.len() < layout.columns && layout.separator == Separator::Byte(b',');
    is_short.then(|| {
        let (names, cells) = (names.len(), layout.columns);
        format!("the line of names has {names} cells and the rows have {cells}; {COMMAS_WITHIN}")
    })
}

/// Whether the first cells are an index: time stamps, words or row numbers.
fn have_index(rows: &[Numbered], separator: Separator) -> bool {
    let first = |(_, line): &Numbered| cells_of(line, separator).into_iter().next();
    let firsts: Vec<String> = rows.iter().take(INDEX_ROWS).filter_map(first).collect();
    let numbers: Vec<f64> = (firsts.iter())
        .filter_map(|cell| number(cell.as_bytes(), true, "").ok())
        .collect();
    numbers.is_empty()
        || (numbers.len() == firsts.len() && numbers.windows(2).all(|two| two[1] - two[0] == 1.0))
}

/// Whether a line is `out =` of MATLAB, or a terminal's own, which begins with `---`.
fn is_banner(cells: &[String]) -> bool {
    let is_of_terminal = |cell: &String| cell.starts_with("---");
    cells.last().is_some_and(|last| last == "=") || cells.first().is_some_and(is_of_terminal)
}

/// Columns with a repeated name are referred to by number.
pub(super) fn only_one_of_a_name(columns: &mut [Column]) {
    let names: Vec<Option<String>> = columns.iter().map(|column| column.name.clone()).collect();
    for column in columns {
        let is_repeated = names.iter().filter(|name| **name == column.name).count() > 1;
        column.is_by_name &= !is_repeated;
    }
}
