//! The mapping file: its sections and keys as they are written, and what they mean together.

use serde::Deserialize;

use super::MapError;
use super::cells::Separator;
use super::map::{
    ColumnRef, CommandSource, Field, Integration, Map, PositionSource, Shape, TimeSource,
};
use super::unit::{self, Axis, CommandUnit};
use crate::motor::plausible;
use crate::recording::{CommandKind, known_differences};

/// The mapping file as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MapFile {
    counts_per_rev: f64,
    m_per_rev: Option<f64>,
    supply_v: Option<f64>,
    sample_time_s: Option<f64>,
    #[serde(default)]
    header: toml::Table,
    #[serde(default)]
    differs: toml::Table,
    #[serde(default)]
    file: FileSection,
    time: Option<TimeSection>,
    command: Option<CommandSection>,
    position: Option<PositionSection>,
    speed: Option<SpeedSection>,
    current: Option<FieldSection>,
    supply: Option<FieldSection>,
    #[serde(default)]
    rows: RowsSection,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSection {
    delimiter: Option<String>,
    decimal: Option<String>,
    comment: Option<String>,
    #[serde(default)]
    skip_lines: u64,
    names: Option<bool>,
    #[serde(default)]
    unit_lines: u64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RowsSection {
    split_by: Option<ColumnRef>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TimeSection {
    column: ColumnRef,
    unit: String,
    scale: Option<f64>,
    wrap: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CommandSection {
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

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionSection {
    column: Option<ColumnRef>,
    unit: Option<String>,
    counts_per_rev: Option<f64>,
    scale: Option<f64>,
    offset: Option<f64>,
    wrap: Option<f64>,
    recorded: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpeedSection {
    column: ColumnRef,
    unit: String,
    scale: Option<f64>,
    offset: Option<f64>,
    #[serde(default)]
    integrate: Integration,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FieldSection {
    column: ColumnRef,
    unit: String,
    scale: Option<f64>,
    offset: Option<f64>,
}

const TOP: &str = "the mapping";

impl MapFile {
    /// Takes the text of a mapping file.
    pub fn parse(text: &str) -> Result<Self, MapError> {
        toml::from_str(text).map_err(|error: toml::de::Error| {
            let start = error.span().map_or(0, |span| span.start.min(text.len()));
            let line = 1 + text.as_bytes()[..start]
                .iter()
                .filter(|&&b| b == b'\n')
                .count();
            MapError::Toml {
                line,
                message: error.message().to_owned(),
            }
        })
    }

    /// The mapping that it says, if it says one that can be.
    pub fn checked(self) -> Result<Map, MapError> {
        let top = |key, value: Option<f64>, range: plausible::Range| match value {
            Some(value) if !range.holds(value) => Err(wrong(TOP, key, value, &range.to_string())),
            value => Ok(value),
        };
        // What the readers of run files refuse is not written.
        let counts_per_rev = self.counts_per_rev;
        top(
            "counts_per_rev",
            Some(counts_per_rev),
            plausible::COUNTS_PER_REV,
        )?;
        let supply_v = top("supply_v", self.supply_v, plausible::SUPPLY_V)?;
        let sample_time_s = top(
            "sample_time_s",
            self.sample_time_s,
            plausible::SAMPLE_TIME_S,
        )?;
        let of_source = self.position.as_ref().and_then(|p| p.counts_per_rev);
        let axis = Axis {
            counts_per_rev: optional_positive("[position]", "counts_per_rev", of_source)?
                .unwrap_or(counts_per_rev),
            m_per_rev: optional_positive(TOP, "m_per_rev", self.m_per_rev)?,
        };
        let supply = match self.supply {
            Some(section) => Some(section.field("[supply]", unit::supply_v)?),
            None => None,
        };
        let current = match self.current {
            Some(section) => Some(section.field("[current]", unit::current_a)?),
            None => None,
        };
        let command = self.command.ok_or(MapError::Missing {
            section: TOP,
            key: "[command]",
            why: "if the log does not hold the command, say `recorded = false` there",
        })?;
        let (command, command_kind) = command.checked(&axis, supply_v, supply.is_some())?;
        let position = match (self.position, self.speed) {
            (Some(_), Some(_)) => {
                return Err(MapError::Conflict {
                    section: "[speed]",
                    what: "a position is mapped as well; speed is only for logs without a position, \
                           so leave one of the two out",
                });
            }
            (Some(position), None) => position.checked(&axis, counts_per_rev)?,
            (None, Some(speed)) => speed.checked(&axis, counts_per_rev)?,
            (None, None) => {
                return Err(MapError::Missing {
                    section: TOP,
                    key: "[position] or [speed]",
                    why: "if the log holds neither, say `recorded = false` under [position]",
                });
            }
        };
        let time = match self.time {
            Some(section) => section.checked()?,
            None if sample_time_s.is_some() => TimeSource::RowNumber,
            None => {
                return Err(MapError::Missing {
                    section: TOP,
                    key: "[time]",
                    why: "if the log has no times, say `sample_time_s` at the top of the mapping",
                });
            }
        };
        if let Some(key) = ["format", "complete", "summary", "imported"]
            .into_iter()
            .find(|key| self.header.contains_key(*key))
        {
            return Err(MapError::Value {
                section: "[header]",
                key,
                found: "given".to_owned(),
                expected: "left to the import".to_owned(),
            });
        }
        let mut header = self.header;
        if !self.differs.is_empty() {
            header.insert("differs".to_owned(), self.differs.into());
        }
        known_differences(&header).map_err(MapError::Differs)?;
        Ok(Map {
            counts_per_rev,
            supply_v,
            sample_time_s,
            header,
            shape: self.file.checked()?,
            time,
            command,
            command_kind,
            position,
            current,
            supply,
            split_by: self.rows.split_by,
        })
    }
}

impl FileSection {
    fn checked(self) -> Result<Shape, MapError> {
        let wrong = |key, found: &str, expected: &str| MapError::Value {
            section: "[file]",
            key,
            found: format!("`{found}`"),
            expected: expected.to_owned(),
        };
        let separator = match self.delimiter.as_deref() {
            None => None,
            Some("tab" | "\t") => Some(Separator::Byte(b'\t')),
            Some("space" | " ") => Some(Separator::Blanks),
            Some(one) if one.len() == 1 && !one.contains(['"', '\n', '\r']) => {
                Some(Separator::Byte(one.as_bytes()[0]))
            }
            Some(other) => {
                let expected = "one character, tab or space (any number of blanks)";
                return Err(wrong("delimiter", other, expected));
            }
        };
        let decimal_comma = match self.decimal.as_deref() {
            None | Some(".") => false,
            Some(",") if separator != Some(Separator::Byte(b',')) => true,
            Some(",") => {
                return Err(MapError::Conflict {
                    section: "[file]",
                    what: "a comma cannot be both the delimiter and the decimal mark",
                });
            }
            Some(other) => return Err(wrong("decimal", other, ". or ,")),
        };
        Ok(Shape {
            separator,
            decimal_comma,
            comment: self.comment.unwrap_or_else(|| "#".to_owned()),
            skip_lines: self.skip_lines,
            names: self.names.unwrap_or(true),
            unit_lines: self.unit_lines,
        })
    }
}

impl TimeSection {
    fn checked(self) -> Result<TimeSource, MapError> {
        let section = "[time]";
        let scale = positive(section, "scale", self.scale.unwrap_or(1.0))?;
        Ok(TimeSource::Column(Field {
            column: self.column,
            scale: scale * unit::time_s(&self.unit)?,
            offset: 0.0,
            wrap: optional_positive(section, "wrap", self.wrap)?,
        }))
    }
}

impl CommandSection {
    fn checked(
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

impl PositionSection {
    fn checked(self, axis: &Axis, counts_per_rev: f64) -> Result<PositionSource, MapError> {
        let section = "[position]";
        if self.recorded == Some(false) {
            return Ok(PositionSource::NotRecorded);
        }
        let missing = |key, why| MapError::Missing { section, key, why };
        let unit = self
            .unit
            .as_deref()
            .ok_or(missing("unit", "counts, rad, deg and others"))?;
        let factor = unit::angle_rev(unit, axis)? * counts_per_rev;
        Ok(PositionSource::Column(Field {
            column: self.column.ok_or(missing("column", "its name or number"))?,
            scale: nonzero(section, self.scale)? * unity(factor),
            offset: finite(section, "offset", self.offset)? * unity(factor),
            wrap: optional_positive(section, "wrap", self.wrap)?,
        }))
    }
}

impl SpeedSection {
    fn checked(self, axis: &Axis, counts_per_rev: f64) -> Result<PositionSource, MapError> {
        let section = "[speed]";
        let factor = unit::speed_rev_s(&self.unit, axis)? * counts_per_rev;
        Ok(PositionSource::Speed {
            field: Field {
                column: self.column,
                scale: nonzero(section, self.scale)? * factor,
                offset: finite(section, "offset", self.offset)? * factor,
                wrap: None,
            },
            rule: self.integrate,
        })
    }
}

impl FieldSection {
    fn field(
        self,
        section: &'static str,
        factor: fn(&str) -> Result<f64, MapError>,
    ) -> Result<Field, MapError> {
        let factor = factor(&self.unit)?;
        Ok(Field {
            column: self.column,
            scale: nonzero(section, self.scale)? * factor,
            offset: finite(section, "offset", self.offset)? * factor,
            wrap: None,
        })
    }
}

/// A factor that is 1 but for rounding is 1, so that counts stay whole.
fn unity(factor: f64) -> f64 {
    if (factor - 1.0).abs() < 4.0 * f64::EPSILON {
        1.0
    } else {
        factor
    }
}

fn wrong(section: &'static str, key: &'static str, found: f64, expected: &str) -> MapError {
    MapError::Value {
        section,
        key,
        found: found.to_string(),
        expected: expected.to_owned(),
    }
}

fn positive(section: &'static str, key: &'static str, value: f64) -> Result<f64, MapError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(wrong(section, key, value, "a number above 0"))
    }
}

fn optional_positive(
    section: &'static str,
    key: &'static str,
    value: Option<f64>,
) -> Result<Option<f64>, MapError> {
    value.map(|value| positive(section, key, value)).transpose()
}

/// `scale`, 1 where it is not given.
fn nonzero(section: &'static str, scale: Option<f64>) -> Result<f64, MapError> {
    let scale = scale.unwrap_or(1.0);
    if scale.is_finite() && scale != 0.0 {
        Ok(scale)
    } else {
        Err(wrong(section, "scale", scale, "a number other than 0"))
    }
}

fn finite(section: &'static str, key: &'static str, value: Option<f64>) -> Result<f64, MapError> {
    let value = value.unwrap_or(0.0);
    if value.is_finite() {
        Ok(value)
    } else {
        Err(wrong(section, key, value, "a finite number"))
    }
}
