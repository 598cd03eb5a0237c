//! The section `[command]` of a mapping file.

use serde::Deserialize;

use super::MapError;
use super::map::{ColumnRef, CommandSource, Field};
use super::map_values::{finite, nonzero, positive};
use super::unit::{self, Axis, CommandUnit};
use crate::recording::CommandKind;

/// What stands for the mapping itself in messages.
pub(super) const TOP: &str = "the mapping";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CommandSection {
    column: Option<ColumnRef>,
    unit: Option<String>,
    full: Option<f64>,
    supply: Option<SupplyOf>,
    scale: Option<f64>,
    offset: Option<f64>,
    points: Option<Vec<(f64, f64)>>,
    #[serde(default)]
    between: Between,
    recorded: Option<bool>,
}

/// Which supply a share of full drive is a share of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SupplyOf {
    Nominal,
    Measured,
}

/// What a profile is between its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Between {
    #[default]
    Hold,
    Line,
}

impl CommandSection {
    /// Where the command comes from, and what it commands.
    pub fn checked(
        self,
        axis: &Axis,
        supply_v: Option<f64>,
        supply_measured: bool,
    ) -> Result<(CommandSource, CommandKind), MapError> {
        let section = "[command]";
        if self.recorded == Some(false) {
            if self.column.is_some() || self.points.is_some() {
                return Err(MapError::Conflict {
                    section,
                    what: "`recorded = false` leaves no room for `column` or `points`",
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
        let (kind, factor) = match unit::command(unit, axis)? {
            CommandUnit::Direct(kind, factor) => (kind, factor),
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
                (CommandKind::Voltage, supply_v / full)
            }
        };
        let scale = nonzero(section, self.scale)? * factor;
        let offset = finite(section, "offset", self.offset)? * factor;
        let source = match (self.column, self.points) {
            (Some(column), None) => {
                let field = Field {
                    column,
                    scale,
                    offset,
                    wrap: None,
                };
                if measured {
                    CommandSource::OfMeasuredSupply(field)
                } else {
                    CommandSource::Column(field)
                }
            }
            (None, Some(points)) if !measured => {
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
                    what: "give either `column`, or `points` of a command known from elsewhere \
                           (of the nominal supply), or `recorded = false`",
                });
            }
        };
        Ok((source, kind))
    }
}
