//! The mapping file: its sections and keys, and their conversion to a mapping.

use serde::{Deserialize, Serialize};

use super::MapError;
use super::cells::Separator;
use super::clock::Counts;
use super::map::{ColumnRef, Field, Map, PositionSource, Shape, TimeSource};
use super::map_command::{CommandSection, TOP};
use super::map_values::{finite, nonzero, optional_positive, positive, unity, wrong};
use super::unit::{self, Axis};
use crate::motor::plausible;
use crate::recording::{Integration, known_differences};

/// The mapping file as written.
#[derive(Debug, Clone, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MapFile {
    pub counts_per_rev: f64,
    pub m_per_rev: Option<f64>,
    pub supply_v: Option<f64>,
    pub sample_time_s: Option<f64>,
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub header: toml::Table,
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub differs: toml::Table,
    #[serde(default, skip_serializing_if = "is_default")]
    pub file: FileSection,
    pub time: Option<TimeSection>,
    pub command: Option<CommandSection>,
    pub position: Option<PositionSection>,
    pub speed: Option<SpeedSection>,
    pub current: Option<FieldSection>,
    pub supply: Option<FieldSection>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub rows: RowsSection,
}

/// Keys omitted from a written mapping file.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileSection {
    pub delimiter: Option<String>,
    pub decimal: Option<String>,
    pub thousands: Option<String>,
    pub comment: Option<String>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub skip_lines: u64,
    pub names: Option<bool>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub unit_lines: u64,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RowsSection {
    pub split_by: Option<ColumnRef>,
    pub empty: Option<Empty>,
    pub every: Option<u64>,
    pub unsigned: Option<bool>,
    /// Most runs made by restarts of the clock.
    pub runs: Option<u64>,
}

/// Meaning of an empty cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Empty {
    /// The previous value.
    Hold,
}

#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeSection {
    pub column: ColumnRef,
    pub unit: String,
    pub scale: Option<f64>,
    pub wrap: Option<f64>,
    /// The column of the fraction, such as `nanosec` beside `sec`, and its unit.
    pub fraction: Option<ColumnRef>,
    pub fraction_unit: Option<String>,
    /// Time since the previous row.
    pub increments: Option<bool>,
    /// Step of a clock that several rows share, in the column's units.
    pub resolution: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PositionSection {
    pub column: Option<ColumnRef>,
    pub unit: Option<String>,
    pub counts_per_rev: Option<f64>,
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    pub wrap: Option<f64>,
    /// Counts since the previous row.
    pub increments: Option<bool>,
    pub recorded: Option<bool>,
}

#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpeedSection {
    pub column: ColumnRef,
    pub unit: String,
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    #[serde(default)]
    pub integrate: Integration,
    /// Time constant of the interpolation of an instantaneous speed between rows.
    pub time_constant_s: Option<f64>,
    /// Resolution of its numbers.
    pub resolution: Option<f64>,
}

#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FieldSection {
    pub column: ColumnRef,
    pub unit: String,
    pub scale: Option<f64>,
    pub offset: Option<f64>,
}

impl MapFile {
    /// Reverses the motion.
    pub fn reverse(&mut self) {
        let turned = |scale: &mut Option<f64>, offset: &mut Option<f64>| {
            *scale = Some(-scale.unwrap_or(1.0));
            *offset = offset.map(|offset| -offset);
        };
        if let Some(position) = &mut self.position {
            turned(&mut position.scale, &mut position.offset);
        }
        if let Some(speed) = &mut self.speed {
            turned(&mut speed.scale, &mut speed.offset);
        }
    }

    /// Parses the text of a mapping file.
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

    /// The mapping, if it is valid.
    pub fn checked(self) -> Result<Map, MapError> {
        let top = |key, value: Option<f64>, range: plausible::Range| match value {
            Some(value) if !range.holds(value) => Err(wrong(TOP, key, value, &range.to_string())),
            value => Ok(value),
        };
        // Runs that the readers refuse are not written.
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
                    what: "a position is mapped as well\nhint: leave one of the two out: a speed is only for logs without a position",
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
            Some(section) => section.checked(sample_time_s)?,
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
            holds: self.rows.empty == Some(Empty::Hold),
            every: match self.rows.every {
                Some(0) => {
                    return Err(wrong(
                        "[rows]",
                        "every",
                        0.0,
                        "a whole number of 1 and more",
                    ));
                }
                every => every.unwrap_or(1),
            },
            unsigned: self.rows.unsigned == Some(true),
            most_runs: match self.rows.runs {
                Some(0) => {
                    let expected = "a whole number of 1 and more";
                    return Err(wrong("[rows]", "runs", 0.0, expected));
                }
                runs => runs.map(|runs| usize::try_from(runs).unwrap_or(usize::MAX)),
            },
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
            Some("labels") => Some(Separator::Labels),
            Some(one) if one.len() == 1 && !one.contains(['"', '\n', '\r']) => {
                Some(Separator::Byte(one.as_bytes()[0]))
            }
            Some(other) => {
                let expected =
                    "one character, tab, space (any number of blanks) or labels (label:value)";
                return Err(wrong("delimiter", other, expected));
            }
        };
        let thousands = match self.thousands.as_deref() {
            None => None,
            Some("," | ".") if self.thousands == self.decimal => {
                return Err(MapError::Conflict {
                    section: "[file]",
                    what: "`thousands` and `decimal` are the same mark\nhint: give the decimal mark, and leave `thousands` out where there is none",
                });
            }
            Some(",") => Some(b','),
            Some(".") => Some(b'.'),
            Some(other) => return Err(wrong("thousands", other, ". or ,")),
        };
        let decimal_comma = match self.decimal.as_deref() {
            None | Some(".") => false,
            // A comma-separated decimal comma needs quotes.
            Some(",") => true,
            Some(other) => return Err(wrong("decimal", other, ". or ,")),
        };
        Ok(Shape {
            separator,
            decimal_comma,
            thousands,
            comment: self.comment.unwrap_or_else(|| "#".to_owned()),
            skip_lines: self.skip_lines,
            names: self.names,
            unit_lines: self.unit_lines,
        })
    }
}

impl TimeSection {
    /// A column in this unit.
    pub fn of(column: ColumnRef, unit: &str) -> Self {
        Self {
            column,
            unit: unit.to_owned(),
            scale: None,
            wrap: None,
            fraction: None,
            fraction_unit: None,
            increments: None,
            resolution: None,
        }
    }

    fn checked(self, sample_time_s: Option<f64>) -> Result<TimeSource, MapError> {
        let section = "[time]";
        let missing = |key, why| MapError::Missing { section, key, why };
        let conflict = |what| MapError::Conflict { section, what };
        let scale = positive(section, "scale", self.scale.unwrap_or(1.0))?;
        let unit_s = scale * unit::time_s(&self.unit)?;
        let resolution = optional_positive(section, "resolution", self.resolution)?;
        let counts = match (self.increments, resolution) {
            (Some(true), Some(_)) => {
                return Err(conflict(
                    "`increments` is a time since the row before and `resolution` the step of a clock: leave one of the two out",
                ));
            }
            (Some(true), None) => Counts::SinceRowBefore,
            (_, Some(resolution)) => Counts::Coarsely {
                resolution_s: resolution * unit_s,
                sample_time_s: sample_time_s.ok_or(missing(
                    "sample_time_s",
                    "rows that share a reading of the clock are spread by it; it stands at the top of the mapping",
                ))?,
            },
            _ => Counts::SinceOrigin,
        };
        let fraction = match (self.fraction, self.fraction_unit) {
            (None, None) => None,
            (Some(column), Some(unit)) => Some(Field {
                column,
                scale: unit::time_s(&unit)?,
                offset: 0.0,
                wrap: None,
            }),
            (Some(_), None) => return Err(missing("fraction_unit", "ns, us or ms")),
            (None, Some(_)) => return Err(missing("fraction", "the column in that unit")),
        };
        if fraction.is_some() && (self.wrap.is_some() || counts == Counts::SinceRowBefore) {
            return Err(conflict(
                "a time of two columns neither wraps nor counts since the row before: leave `wrap` and `increments` out",
            ));
        }
        Ok(TimeSource::Column {
            field: Field {
                column: self.column,
                scale: unit_s,
                offset: 0.0,
                wrap: optional_positive(section, "wrap", self.wrap)?,
            },
            fraction,
            counts,
        })
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
        let field = Field {
            column: self.column.ok_or(missing("column", "its name or number"))?,
            scale: nonzero(section, self.scale)? * unity(factor),
            offset: finite(section, "offset", self.offset)? * unity(factor),
            wrap: optional_positive(section, "wrap", self.wrap)?,
        };
        match (self.increments, field.wrap) {
            (Some(true), Some(_)) => Err(MapError::Conflict {
                section,
                what: "`wrap` is given, and `increments` do not wrap\nhint: leave `wrap` out",
            }),
            (Some(true), None) => Ok(PositionSource::Increments(field)),
            _ => Ok(PositionSource::Column(field)),
        }
    }
}

impl SpeedSection {
    fn checked(self, axis: &Axis, counts_per_rev: f64) -> Result<PositionSource, MapError> {
        let section = "[speed]";
        let factor = unit::speed_rev_s(&self.unit, axis)? * counts_per_rev;
        let scale = nonzero(section, self.scale)? * factor;
        Ok(PositionSource::Speed {
            field: Field {
                column: self.column,
                scale,
                offset: finite(section, "offset", self.offset)? * factor,
                wrap: None,
            },
            curve: match (
                self.integrate,
                optional_positive(section, "time_constant_s", self.time_constant_s)?,
            ) {
                (Integration::Trapezoid, time_constant_s) => time_constant_s,
                (_, None) => None,
                (_, Some(_)) => {
                    return Err(MapError::Conflict {
                        section,
                        what: "`time_constant_s` belongs to an instantaneous speed\nhint: give `integrate = \"trapezoid\"` as well, or leave `time_constant_s` out",
                    });
                }
            },
            rule: self.integrate,
            resolution: optional_positive(section, "resolution", self.resolution)?
                .map(|resolution| resolution * scale.abs()),
        })
    }
}

impl FieldSection {
    /// A column in this unit.
    pub fn of(column: ColumnRef, unit: &str) -> Self {
        Self {
            column,
            unit: unit.to_owned(),
            scale: None,
            offset: None,
        }
    }

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
