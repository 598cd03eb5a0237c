//! Column indices of a mapping in this log.

use super::ImportProblem;
use super::cells::{Cells, shortened};
use super::map::{ColumnRef, Map};
use crate::motor::is_alike;

/// Column indices in a row, from 0.
#[derive(Debug, Clone, Default)]
pub(super) struct Layout {
    /// Number of cells in a row.
    pub columns: usize,
    pub time: Option<Place>,
    /// Of the fraction of the time, such as `nanosec` beside `sec`.
    pub time_fraction: Option<Place>,
    /// Of the command, or of every term of its sum.
    pub command: Vec<Place>,
    /// Of the command's direction.
    pub direction: Option<Place>,
    pub motion: Option<Place>,
    pub current: Option<Place>,
    pub supply: Option<Place>,
    pub split_by: Option<Place>,
}

/// One column.
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// From 0.
    pub at: usize,
    /// Name for messages.
    pub name: String,
}

impl Layout {
    /// From the line of names, or without one (`has_names`) from the first row.
    ///
    /// # Errors
    /// A column is missing.
    pub fn new(
        map: &Map,
        line: u64,
        cells: &Cells,
        has_names: bool,
    ) -> Result<Self, ImportProblem> {
        let names = has_names.then_some(cells);
        let find = |column: &ColumnRef| place(column, names, cells.len(), line);
        let optional = |column: Option<&ColumnRef>| column.map(find).transpose();
        Ok(Self {
            columns: cells.len(),
            time: optional(map.time_column())?,
            time_fraction: optional(map.time_fraction().map(|field| &field.column))?,
            command: (map.command_columns().into_iter())
                .map(find)
                .collect::<Result<_, _>>()?,
            direction: optional(map.direction().map(|(column, _)| column))?,
            motion: optional(map.motion_column())?,
            current: optional(map.current.as_ref().map(|field| &field.column))?,
            supply: optional(map.supply.as_ref().map(|field| &field.column))?,
            split_by: optional(map.split_by.as_ref())?,
        })
    }
}

fn place(
    column: &ColumnRef,
    names: Option<&Cells>,
    columns: usize,
    line: u64,
) -> Result<Place, ImportProblem> {
    match (column, names) {
        (&ColumnRef::Number(number), _) => {
            if number == 0 || number > columns {
                return Err(ImportProblem::NoSuchNumber {
                    line,
                    column: number,
                    found: columns,
                });
            }
            Ok(Place {
                at: number - 1,
                name: names.map_or_else(
                    || number.to_string(),
                    |names| format!("`{}`", shortened(&names.text(number - 1))),
                ),
            })
        }
        (ColumnRef::Name(name), None) => Err(ImportProblem::NameWithoutNames(name.clone())),
        (ColumnRef::Name(name), Some(names)) => {
            let found = (0..columns).find(|&at| names.text(at) == name.trim());
            found
                .map(|at| Place {
                    at,
                    name: format!("`{name}`"),
                })
                .ok_or_else(|| no_such_column(name, names, line))
        }
    }
}

/// Most column names listed.
const MOST_LISTED: usize = 30;

fn no_such_column(name: &str, names: &Cells, line: u64) -> ImportProblem {
    let there: Vec<String> = (0..names.len())
        .map(|at| shortened(&names.text(at)))
        .collect();
    let nearest = there
        .iter()
        .map(|other| {
            (
                strsim::jaro_winkler(&name.to_lowercase(), &other.to_lowercase()),
                other,
            )
        })
        .filter(|(_, other)| is_alike(&name.to_lowercase(), &other.to_lowercase()))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let mut found = there[..there.len().min(MOST_LISTED)].join(", ");
    if there.len() > MOST_LISTED {
        found.push_str(" …");
    }
    ImportProblem::NoSuchColumn {
        line,
        column: name.to_owned(),
        nearest: nearest.map_or_else(String::new, |(_, other)| {
            format!("did you mean `{other}`? ")
        }),
        found,
    }
}
