//! Start of the numeric rows in a log, and their separator.

use super::super::cells::{Cells, Separator, grouped, number};
use super::super::labels::labels;
use super::super::stamp::{before_line, stamp};

/// A line of the log, and its number from 1.
pub(super) type Numbered = (u64, Vec<u8>);

/// Consecutive equal rows that make a table.
const ALIKE: usize = 3;
/// Consecutive equal rows that are no banner.
const LONG: usize = 10;
/// Lines among which the first numeric row is searched: a banner is shorter.
pub(super) const BANNER_LINES: usize = 400;

/// Start of the table of numbers, and the separator of its cells.
pub(super) struct Layout {
    pub separator: Separator,
    pub columns: usize,
    /// Index of the first row.
    pub first: usize,
    pub is_decimal_comma: bool,
}

/// The separator with which the earliest and most of the lines are numeric rows.
pub(super) fn layout(table: &[Numbered]) -> Option<Layout> {
    if let Some(labelled) = labelled(table) {
        return Some(labelled);
    }
    let separators = [
        Separator::Byte(b'\t'),
        Separator::Byte(b';'),
        Separator::Byte(b','),
        Separator::Byte(b'|'),
        Separator::Blanks,
    ];
    let mut best: Option<(f64, Layout)> = None;
    for separator in separators {
        // A decimal comma between commas is quoted.
        let is_decimal_comma = true;
        let shapes: Vec<LineShape> = (table.iter().take(BANNER_LINES))
            .map(|(_, line)| LineShape::at(line, separator, is_decimal_comma))
            .collect();
        // A separator at the end of every row ends it; at the end of some it precedes an empty cell.
        let mut rows = shapes
            .iter()
            .filter(|shape| shape.share >= 0.5 && shape.cells > 1);
        let surplus = usize::from(rows.clone().count() > 0 && rows.all(|shape| shape.is_open));
        let alike = ALIKE.min(shapes.len().saturating_sub(1)).max(1);
        let is_row = |shape: &LineShape, cells: usize| shape.cells == cells && shape.share >= 0.5;
        let begins = (0..shapes.len().saturating_sub(alike - 1)).filter(|&at| {
            let cells = shapes[at].cells;
            cells > surplus
                && shapes[at..at + alike]
                    .iter()
                    .all(|shape| is_row(shape, cells))
        });
        // A banner of `key,number` lines is a short table.
        let rows = |at: usize| {
            let rows = shapes[at..].iter();
            rows.take_while(|shape| is_row(shape, shapes[at].cells))
                .count()
        };
        let long = begins.clone().find(|&at| rows(at) >= LONG);
        let Some(first) = long.or_else(|| begins.clone().next()) else {
            continue;
        };
        let shape = &shapes[first];
        let columns = shape.cells - surplus;
        // The number of columns is preferred to a larger share: a list of one column is all numbers too. A terminal's
        // stamp is no column.
        let own = columns - usize::from(shape.is_stamped);
        let score = shape.share * if own > 1 { 1.0 } else { 0.4 };
        if best
            .as_ref()
            .is_none_or(|(before, _)| score > *before + 1e-9)
        {
            best = Some((
                score,
                Layout {
                    separator,
                    columns,
                    first,
                    is_decimal_comma,
                },
            ));
        }
    }
    best.map(|(_, layout)| layout)
}

/// The first lines with equal labels: `Pos:123 PWM:80`.
fn labelled(table: &[Numbered]) -> Option<Layout> {
    let named: Vec<Option<Vec<Vec<u8>>>> = (table.iter().take(BANNER_LINES))
        .map(|(_, line)| labels(line).filter(|labels| is_of_numbers(line, labels)))
        .collect();
    let alike = ALIKE.min(named.len()).max(1);
    let first = named.windows(alike).position(|window| {
        window[0].is_some() && window.iter().all(|labels| *labels == window[0])
    })?;
    Some(Layout {
        separator: Separator::Labels,
        columns: named[first].as_ref()?.len(),
        first,
        is_decimal_comma: false,
    })
}

/// Whether the values after the labels are numbers.
fn is_of_numbers(line: &[u8], labels: &[Vec<u8>]) -> bool {
    let mut cells = Cells::default();
    cells.expect(labels.to_vec());
    cells.split(line, Separator::Labels);
    (0..cells.len())
        .all(|at| number(cells.get(at), false, "").is_ok() || stamp(cells.get(at)).is_some())
}

/// Cells of one line with one separator.
struct LineShape {
    cells: usize,
    /// Share of numbers and stamps among the non-empty cells.
    share: f64,
    /// The last cell is empty.
    is_open: bool,
    /// The line begins with a terminal's stamp.
    is_stamped: bool,
}

impl LineShape {
    fn at(line: &[u8], separator: Separator, is_decimal_comma: bool) -> Self {
        let mut cells = Cells::default();
        cells.split(line, separator);
        let count = cells.len();
        let filled: Vec<&[u8]> = (0..count)
            .map(|at| cells.get(at))
            .filter(|cell| !cell.is_empty())
            .collect();
        let is_grouped = |cell: &[u8]| {
            [b',', b'.']
                .iter()
                .any(|mark| grouped(cell, *mark).is_some())
        };
        let is_number = |cell: &&&[u8]| {
            number(cell, is_decimal_comma, "").is_ok() || stamp(cell).is_some() || is_grouped(cell)
        };
        let numbers = filled.iter().filter(is_number).count();
        Self {
            cells: count,
            share: numbers as f64 / filled.len().max(1) as f64,
            is_open: count > 1 && cells.get(count - 1).is_empty(),
            is_stamped: before_line(line).is_some(),
        }
    }
}
