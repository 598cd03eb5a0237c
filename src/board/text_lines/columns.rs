//! Meaning of each number of a text line.
//!
//! Names are those that sketches print, in any case, with `_`, `-` or a unit in brackets: `t_us`, `micros`,
//! `time_ms`, `millis`, `t_s`, `counts`, `encoder`, `command_v`, `pwm` …

use std::fmt;

use thiserror::Error;

use super::speed_unit::SpeedUnit;
use crate::motor::nearest_name;

/// Meaning of one column of a text line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// Board time in microseconds, as `micros()` gives it (wraps at 2^32).
    TimeMicros,
    /// Board time in milliseconds, as `millis()` gives it (wraps at 2^32).
    TimeMillis,
    /// Board time in seconds.
    TimeSeconds,
    /// Sample number.
    Sequence,
    /// Encoder counts.
    Counts,
    /// Encoder counts since the previous line (`readAndReset`), which are summed.
    Increments,
    /// Speed in this unit, which is integrated over time.
    Speed(SpeedUnit),
    /// Command in V.
    CommandVolts,
    /// Command as the 8-bit PWM value of `analogWrite`, signed.
    CommandPwm255,
    /// Command in percent of full drive.
    CommandPercent,
    /// Measured supply in V.
    SupplyVolts,
    /// Measured current in A.
    CurrentAmperes,
    /// Not used.
    Ignored,
}

/// Every name of a column; the first one is the printed one.
pub(super) const NAMES: &[(&str, Column)] = &[
    ("t_us", Column::TimeMicros),
    ("time_us", Column::TimeMicros),
    ("micros", Column::TimeMicros),
    ("us", Column::TimeMicros),
    ("t_ms", Column::TimeMillis),
    ("time_ms", Column::TimeMillis),
    ("millis", Column::TimeMillis),
    ("ms", Column::TimeMillis),
    ("t_s", Column::TimeSeconds),
    ("time_s", Column::TimeSeconds),
    ("t", Column::TimeSeconds),
    ("time", Column::TimeSeconds),
    ("seconds", Column::TimeSeconds),
    ("seq", Column::Sequence),
    ("sample", Column::Sequence),
    ("counts", Column::Counts),
    ("count", Column::Counts),
    ("encoder", Column::Counts),
    ("enc", Column::Counts),
    ("position", Column::Counts),
    ("pos", Column::Counts),
    ("ticks", Column::Counts),
    ("increments", Column::Increments),
    ("increment", Column::Increments),
    ("inc", Column::Increments),
    ("delta", Column::Increments),
    ("delta_counts", Column::Increments),
    ("dcounts", Column::Increments),
    ("rpm", Column::Speed(SpeedUnit::Rpm)),
    ("speed_rpm", Column::Speed(SpeedUnit::Rpm)),
    ("velocity_rpm", Column::Speed(SpeedUnit::Rpm)),
    ("speed", Column::Speed(SpeedUnit::Unsaid)),
    ("rad_s", Column::Speed(SpeedUnit::RadPerS)),
    ("speed_rad_s", Column::Speed(SpeedUnit::RadPerS)),
    ("velocity_rad_s", Column::Speed(SpeedUnit::RadPerS)),
    ("omega_rad_s", Column::Speed(SpeedUnit::RadPerS)),
    ("deg_s", Column::Speed(SpeedUnit::DegPerS)),
    ("speed_deg_s", Column::Speed(SpeedUnit::DegPerS)),
    ("velocity_deg_s", Column::Speed(SpeedUnit::DegPerS)),
    ("dps", Column::Speed(SpeedUnit::DegPerS)),
    ("rev_s", Column::Speed(SpeedUnit::RevPerS)),
    ("speed_rev_s", Column::Speed(SpeedUnit::RevPerS)),
    ("velocity_rev_s", Column::Speed(SpeedUnit::RevPerS)),
    ("counts_s", Column::Speed(SpeedUnit::CountsPerS)),
    ("speed_counts_s", Column::Speed(SpeedUnit::CountsPerS)),
    ("velocity_counts_s", Column::Speed(SpeedUnit::CountsPerS)),
    ("ticks_s", Column::Speed(SpeedUnit::CountsPerS)),
    ("command_v", Column::CommandVolts),
    ("command", Column::CommandVolts),
    ("u", Column::CommandVolts),
    ("voltage", Column::CommandVolts),
    ("voltage_v", Column::CommandVolts),
    ("volts", Column::CommandVolts),
    ("v", Column::CommandVolts),
    ("pwm", Column::CommandPwm255),
    ("duty", Column::CommandPwm255),
    ("pwm_255", Column::CommandPwm255),
    ("percent", Column::CommandPercent),
    ("duty_percent", Column::CommandPercent),
    ("duty_pct", Column::CommandPercent),
    ("pwm_percent", Column::CommandPercent),
    ("pwm_pct", Column::CommandPercent),
    ("command_percent", Column::CommandPercent),
    ("control_pct", Column::CommandPercent),
    ("supply_v", Column::SupplyVolts),
    ("battery_v", Column::SupplyVolts),
    ("vbat", Column::SupplyVolts),
    ("current_a", Column::CurrentAmperes),
    ("current", Column::CurrentAmperes),
    ("i", Column::CurrentAmperes),
    ("-", Column::Ignored),
    ("ignore", Column::Ignored),
    ("skip", Column::Ignored),
];

impl Column {
    /// The column with this name, ignoring case, spaces and a bracketed unit.
    pub fn from_name(name: &str) -> Option<Self> {
        let plain = plain(name);
        NAMES
            .iter()
            .find(|(known, _)| *known == plain)
            .map(|&(_, column)| column)
    }

    /// Whether both are the same quantity in any unit.
    pub(super) fn is_kind_of(self, other: Self) -> bool {
        let kind = |column| match column {
            Self::TimeMicros | Self::TimeMillis | Self::TimeSeconds => Self::TimeMicros,
            Self::CommandVolts | Self::CommandPwm255 | Self::CommandPercent => Self::CommandVolts,
            Self::Speed(_) => Self::Speed(SpeedUnit::Rpm),
            same => same,
        };
        kind(self) == kind(other)
    }

    /// The column of time with a unit `factor` times as long, if there is one.
    pub(crate) fn in_unit_times(self, factor: f64) -> Option<Self> {
        let units = [
            (Self::TimeMicros, 1e-6),
            (Self::TimeMillis, 1e-3),
            (Self::TimeSeconds, 1.0),
        ];
        let (_, unit_s) = units.iter().find(|(column, _)| *column == self)?;
        let wanted_s = unit_s * factor;
        let found = units
            .iter()
            .find(|(_, s)| (s / wanted_s - 1.0).abs() < 0.01);
        found.map(|&(column, _)| column)
    }

    /// The printed names, one per column.
    pub fn names() -> String {
        let mut names: Vec<&str> = NAMES.iter().map(|(_, column)| column.name()).collect();
        names.dedup();
        names.join(", ")
    }

    /// The name that is printed for this column.
    pub fn name(self) -> &'static str {
        NAMES
            .iter()
            .find(|&&(_, column)| column == self)
            .map_or("-", |&(name, _)| name)
    }
}

/// `"Encoder (counts)"` and `" ENCODER"` both give `encoder`; `"time [us]"` gives `time_us`.
fn plain(name: &str) -> String {
    let name = name.trim().to_ascii_lowercase();
    let (stem, unit) = match name.find(['(', '[']) {
        Some(at) => (
            name[..at].trim_end(),
            name[at + 1..].trim_end_matches([')', ']']),
        ),
        None => (name.as_str(), ""),
    };
    let stem = stem.replace([' ', '-'], "_");
    let stem = if stem == "_" { "-".to_owned() } else { stem };
    match unit.trim() {
        unit @ ("us" | "ms" | "s" | "v" | "a") if !stem.ends_with(&format!("_{unit}")) => {
            format!("{stem}_{unit}")
        }
        "%" => format!("{stem}_percent"),
        // A speed with another unit in brackets is not in RPM.
        unit if !unit.is_empty() && SPEEDS.contains(&stem.as_str()) => {
            format!("{stem}_{}", unit.replace(['/', ' '], "_"))
        }
        _ => stem,
    }
}

/// Errors in a set of columns.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ColumnError {
    /// An unknown name.
    #[error(
        "unknown column `{name}`\nhint: {}the names are {}; `-` leaves a column out",
        nearest.map_or_else(String::new, |name| format!("did you mean `{name}`? ")),
        Column::names()
    )]
    Unknown {
        /// The given name.
        name: String,
        /// The most similar known name, if any.
        nearest: Option<&'static str>,
    },
    /// A speed without its unit, or an angle.
    #[error(
        "`{name}` is neither a count nor a speed whose unit is known\nhint: name a speed by its unit (rpm, rad_s, deg_s, rev_s, counts_s), and it is summed up; leave a column out with `-`; a log of angles is read by `motorlab import`"
    )]
    NotCounts {
        /// The given name.
        name: String,
    },
    /// A meaning given twice.
    #[error("two columns mean `{name}`\nhint: leave one out with `-`")]
    Twice {
        /// The meaning.
        name: &'static str,
    },
    /// No column of counts.
    #[error(
        "no column holds the encoder counts\nhint: name one of them `counts`, or `increments` or a speed (rpm, rad_s, …), which are summed up"
    )]
    NoCounts,
}

/// The columns of a text board, in the order of a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns(Vec<Column>);

impl Columns {
    /// Columns from `--columns t_us,counts,command`.
    ///
    /// # Errors
    /// An unknown name, a meaning given twice, or no counts.
    pub fn parse(list: &str) -> Result<Self, ColumnError> {
        let columns = list
            .split(',')
            .map(|name| Column::from_name(name).ok_or_else(|| unknown(name)))
            .collect::<Result<Vec<_>, _>>()?;
        Self::new(columns)
    }

    /// Columns in order.
    ///
    /// # Errors
    /// A meaning given twice, or no counts.
    pub fn new(columns: Vec<Column>) -> Result<Self, ColumnError> {
        for (k, column) in columns.iter().enumerate() {
            if *column != Column::Ignored && columns[..k].contains(column) {
                return Err(ColumnError::Twice {
                    name: column.name(),
                });
            }
        }
        // Counts are preferred to integrated quantities, increments to speeds.
        let rank = |column: &Column| match column {
            Column::Counts => Some(0),
            Column::Increments => Some(1),
            Column::Speed(_) => Some(2),
            _ => None,
        };
        let best = (columns.iter().filter_map(rank).min()).ok_or(ColumnError::NoCounts)?;
        let of_motion = columns.iter().filter(|column| rank(column) == Some(best));
        if of_motion.count() > 1 {
            return Err(ColumnError::Twice { name: "speed" });
        }
        let used = |column: Column| match rank(&column) {
            Some(other) if other != best => Column::Ignored,
            _ => column,
        };
        Ok(Self(columns.into_iter().map(used).collect()))
    }

    /// The column that is integrated to counts; `None` if there are counts.
    pub fn summed_up(&self) -> Option<Column> {
        let is_summed = |column: &&Column| matches!(column, Column::Increments | Column::Speed(_));
        self.0.iter().find(is_summed).copied()
    }

    /// The columns in the order of the line.
    pub fn as_slice(&self) -> &[Column] {
        &self.0
    }

    /// Whether the board states sample times; otherwise the host's arrival times are used.
    pub fn has_device_time(&self) -> bool {
        self.0.iter().any(|column| {
            matches!(
                column,
                Column::TimeMicros | Column::TimeMillis | Column::TimeSeconds
            )
        })
    }
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.0.iter().map(|column| column.name()).collect();
        f.write_str(&names.join(","))
    }
}

/// Names of speeds without a unit.
const SPEEDS: &[&str] = &["speed", "velocity", "vel", "omega"];

/// Common names of speeds and angles.
const SPEEDS_AND_ANGLES: &[&str] = &[
    "rpm", "speed", "velocity", "vel", "omega", "rad_s", "deg_s", "rps", "rad", "deg", "angle",
    "theta", "degrees", "radians",
];

fn unknown(name: &str) -> ColumnError {
    let given = name.trim().to_owned();
    let plain = plain(name);
    let is_one = |known: &str| {
        let rest = plain.strip_prefix(known);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
    };
    if SPEEDS_AND_ANGLES.iter().any(|known| is_one(known)) {
        return ColumnError::NotCounts { name: given };
    }
    ColumnError::Unknown {
        name: given,
        nearest: nearest(name),
    }
}

fn nearest(name: &str) -> Option<&'static str> {
    nearest_name(&plain(name), NAMES.iter().map(|&(known, _)| known))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_column_names_of_sketches_are_recognized() {
        for (name, column) in [
            ("t_us", Column::TimeMicros),
            ("Time [us]", Column::TimeMicros),
            (" Millis", Column::TimeMillis),
            ("Encoder (counts)", Column::Counts),
            ("Voltage (V)", Column::CommandVolts),
            ("PWM", Column::CommandPwm255),
            ("Duty (%)", Column::CommandPercent),
            ("RPM", Column::Speed(SpeedUnit::Rpm)),
            ("Speed (rad/s)", Column::Speed(SpeedUnit::RadPerS)),
            ("velocity [deg/s]", Column::Speed(SpeedUnit::DegPerS)),
            ("speed", Column::Speed(SpeedUnit::Unsaid)),
            ("delta counts", Column::Increments),
            ("-", Column::Ignored),
        ] {
            assert_eq!(Column::from_name(name), Some(column), "{name}");
        }
    }

    #[test]
    fn every_printed_name_is_recognized() {
        for &(_, column) in NAMES {
            assert_eq!(Column::from_name(column.name()), Some(column));
        }
    }

    #[test]
    fn errors_have_hints() {
        assert_eq!(
            Columns::parse("t_us,cuonts"),
            Err(ColumnError::Unknown {
                name: "cuonts".into(),
                nearest: Some("counts")
            })
        );
        assert_eq!(Columns::parse("t_us,pwm"), Err(ColumnError::NoCounts));
        assert_eq!(
            Columns::parse("counts,encoder"),
            Err(ColumnError::Twice { name: "counts" })
        );
        for name in ["omega", "rps", "Speed (m/s)", "rpm_filtered", "angle"] {
            let error = Columns::parse(&format!("t_ms,{name},pwm"));
            assert_eq!(error, Err(ColumnError::NotCounts { name: name.into() }));
        }
        assert!(!Columns::parse("counts,-,-").unwrap().has_device_time());
        let unknown = Columns::parse("cuonts").expect_err("unknown").to_string();
        let names = ["t_us", "increments", "rpm", "current_a"];
        assert!(names.iter().all(|name| unknown.contains(name)), "{unknown}");
    }

    #[test]
    fn counts_take_precedence_over_integrated_speeds() {
        let summed = |list: &str| Columns::parse(list).map(|columns| columns.summed_up());
        assert_eq!(summed("t_us,counts,rpm,pwm"), Ok(None));
        assert_eq!(summed("rpm,increments"), Ok(Some(Column::Increments)));
        assert_eq!(summed("t_us,rpm"), Ok(Some(Column::Speed(SpeedUnit::Rpm))));
        assert_eq!(
            summed("rpm,rad_s"),
            Err(ColumnError::Twice { name: "speed" })
        );
    }
}
