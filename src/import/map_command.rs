//! The section `[command]` of a mapping file.

use serde::{Deserialize, Serialize};

use super::MapError;
use super::map::{Backwards, ColumnRef, CommandNumber, CommandSource, NumberFrom, Term};
use super::map_values::{finite, nonzero, optional_positive, positive};
use super::unit::{self, Axis, CommandUnit};
use crate::recording::CommandKind;

/// Name of the mapping in messages.
pub(super) const TOP: &str = "the mapping";

#[derive(Debug, Clone, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CommandSection {
    pub column: Option<ColumnRef>,
    /// The word of comment lines before the command.
    pub comment: Option<String>,
    pub unit: Option<String>,
    pub full: Option<f64>,
    pub supply: Option<SupplyOf>,
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    /// Limit of the magnitude of `sum`.
    pub limit: Option<f64>,
    pub sum: Option<Vec<Term>>,
    /// The column of its direction.
    pub direction: Option<ColumnRef>,
    /// The number or word for backwards.
    pub reverse: Option<Backwards>,
    pub points: Option<Vec<(f64, f64)>>,
    #[serde(default, skip_serializing_if = "Between::is_hold")]
    pub between: Between,
    pub recorded: Option<bool>,
}

/// The supply of a share of full drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SupplyOf {
    Nominal,
    Measured,
}

/// Interpolation of a profile between its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Between {
    #[default]
    Hold,
    Line,
}

impl Between {
    fn is_hold(&self) -> bool {
        *self == Self::Hold
    }
}

impl CommandSection {
    /// Number of given keys for the source of the command.
    fn sources(&self) -> usize {
        [
            self.column.is_some(),
            self.comment.is_some(),
            self.sum.is_some(),
            self.points.is_some(),
        ]
        .into_iter()
        .filter(|is_given| *is_given)
        .count()
    }

    /// Source and kind of the command.
    pub fn checked(
        self,
        axis: &Axis,
        supply_v: Option<f64>,
        supply_measured: bool,
    ) -> Result<(CommandSource, CommandKind), MapError> {
        let section = "[command]";
        if self.recorded == Some(false) {
            if self.sources() > 0 {
                return Err(MapError::Conflict {
                    section,
                    what: "`recorded = false` is given together with `column`, `sum`, `comment` or `points`\nhint: leave one of the two out",
                });
            }
            let kind = match self.unit.as_deref().map(|unit| unit::command(unit, axis)) {
                Some(Ok(CommandUnit::Direct(kind, _))) => kind,
                Some(Err(error)) => return Err(error),
                Some(Ok(CommandUnit::Share(_))) | None => CommandKind::Voltage,
            };
            return Ok((CommandSource::NotRecorded, kind));
        }
        let unit = self.unit.as_deref().ok_or(MapError::Missing {
            section,
            key: "unit",
            why: "V, A, N m, pwm and others",
        })?;
        let measured = self.supply == Some(SupplyOf::Measured);
        let (kind, factor, most) = match unit::command(unit, axis)? {
            CommandUnit::Direct(kind, factor) => (kind, factor, None),
            CommandUnit::Share(full) => {
                let full = full.or(self.full).ok_or(MapError::Missing {
                    section,
                    key: "full",
                    why: "the number that stands for full drive, such as 255",
                })?;
                let full = positive(section, "full", full)?;
                let supply_v = match (measured, supply_v) {
                    (true, _) if !supply_measured => {
                        return Err(MapError::Missing {
                            section: TOP,
                            key: "[supply]",
                            why: "`supply = \"measured\"` takes the supply of each row from there",
                        });
                    }
                    (true, _) => 1.0,
                    (false, Some(supply_v)) => supply_v,
                    (false, None) => {
                        return Err(MapError::Missing {
                            section: TOP,
                            key: "supply_v",
                            why: "a command that is a share of the supply needs it",
                        });
                    }
                };
                (CommandKind::Voltage, supply_v / full, Some(supply_v))
            }
        };
        let scale = nonzero(section, self.scale)? * factor;
        let offset = finite(section, "offset", self.offset)? * factor;
        let is_one = self.sources() == 1;
        let limit = optional_positive(section, "limit", self.limit)?;
        if limit.is_some() && self.sum.is_none() {
            return Err(MapError::Conflict {
                section,
                what: "`limit` is given without a `sum`\nhint: leave `limit` out: a share of full drive is limited to `full` in any case",
            });
        }
        let direction = match (self.direction, self.reverse) {
            (Some(column), Some(reverse)) => {
                if let Backwards::Number(number) = reverse {
                    finite(section, "reverse", Some(number))?;
                }
                Some((column, reverse))
            }
            (None, None) => None,
            _ => {
                return Err(MapError::Conflict {
                    section,
                    what: "one of `direction` (a column) and `reverse` (the number or word there that is backwards) is given\nhint: give both",
                });
            }
        };
        let number = match (self.column, self.sum, self.comment) {
            (Some(column), None, None) => Some(NumberFrom::Column(column)),
            (None, Some(terms), None) => {
                let is_good = |term: &Term| term.factor.is_finite() && term.factor != 0.0;
                if terms.is_empty() || !terms.iter().all(is_good) {
                    return Err(MapError::Value {
                        section,
                        key: "sum",
                        found: format!("a list of {}", terms.len()),
                        expected: "[{column = ..., factor = a number other than 0}, ...]"
                            .to_owned(),
                    });
                }
                Some(NumberFrom::Sum { terms, limit })
            }
            (None, None, Some(word)) if !word.trim().is_empty() => Some(NumberFrom::Comment(word)),
            _ => None,
        };
        let source = match (number, self.points) {
            (Some(from), None) if is_one => CommandSource::Number(CommandNumber {
                from,
                scale,
                offset,
                most,
                of_measured_supply: measured,
                direction,
            }),
            (None, Some(points)) if !measured && is_one => {
                let rising = points.windows(2).all(|pair| pair[1].0 > pair[0].0);
                let finite = points.iter().all(|(t, v)| t.is_finite() && v.is_finite());
                if points.is_empty() || !rising || !finite {
                    return Err(MapError::Value {
                        section,
                        key: "points",
                        found: format!("a list of {}", points.len()),
                        expected: "[[time in s, value], ...] with rising times".to_owned(),
                    });
                }
                let points = points
                    .into_iter()
                    .map(|(t_s, value)| (t_s, value * scale + offset))
                    .collect();
                CommandSource::Profile {
                    points,
                    line: self.between == Between::Line,
                }
            }
            _ => {
                return Err(MapError::Conflict {
                    section,
                    what: "no source of the command, or more than one\nhint: give one of `column`, `sum` (of columns), `comment` (the word before the number in \
                           comment lines), `points` of a command known from elsewhere (of the nominal \
                           supply), and `recorded = false`",
                });
            }
        };
        Ok((source, kind))
    }
}
