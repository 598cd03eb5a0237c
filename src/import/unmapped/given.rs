//! Facts about a log from the user, one flag per quantity: from their text to columns, units and steps.

use super::super::map::ColumnRef;
use super::unclear::Unclear;
use super::units::{Role, unit_of};
use crate::recording::Integration;

/// The flags of `motorlab import`, as given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GivenFlags {
    /// `COL:UNIT`, or `10ms`: the sample time.
    pub time: Option<String>,
    /// `COL:UNIT`, `7V@0.95s`, `2*COL-2*COL:UNIT`, `none`.
    pub command: Option<String>,
    /// Limit of the magnitude of a command that is a sum.
    pub command_limit: Option<f64>,
    /// `COL`, or `COL:NUMBER` with the value of the reverse direction; `none`.
    pub direction: Option<String>,
    /// `COL:UNIT`.
    pub position: Option<String>,
    /// `COL:UNIT`.
    pub speed: Option<String>,
    /// Integration rule of the speed.
    pub integrate: Option<Integration>,
    /// `COL:UNIT`.
    pub current: Option<String>,
    /// Volts, or `COL:UNIT` for a measured supply.
    pub supply: Option<String>,
    /// Encoder counts per revolution.
    pub counts_per_rev: Option<f64>,
    /// Travel of a linear axis in m per revolution.
    pub m_per_rev: Option<f64>,
    /// PWM value at full drive.
    pub pwm_full: Option<f64>,
    /// Range after which the position wraps.
    pub wrap: Option<f64>,
    /// The position column holds the counts since the previous row.
    pub increments: bool,
    /// The sign of the motion is inverted.
    pub reverse: bool,
    /// Whether the encoder has one channel, and no sign.
    pub unsigned: Option<bool>,
    /// Decimation factor.
    pub every: Option<u64>,
    /// Most runs into which restarts of the clock split the log.
    pub runs: Option<u64>,
}

impl GivenFlags {
    /// Flags and values, as on the command line.
    #[must_use]
    pub fn flags(&self) -> Vec<(&'static str, String)> {
        let texts = [
            ("--time", &self.time),
            ("--command", &self.command),
            ("--direction", &self.direction),
            ("--position", &self.position),
            ("--speed", &self.speed),
            ("--current", &self.current),
            ("--supply", &self.supply),
        ];
        let numbers = [
            ("--command-limit", self.command_limit),
            ("--counts-per-rev", self.counts_per_rev),
            ("--m-per-rev", self.m_per_rev),
            ("--pwm-full", self.pwm_full),
            ("--wrap", self.wrap),
        ];
        let mut flags: Vec<(&'static str, String)> = texts
            .into_iter()
            .filter_map(|(flag, text)| Some((flag, text.clone()?)))
            .collect();
        flags.extend(
            (numbers.into_iter()).filter_map(|(flag, number)| Some((flag, number?.to_string()))),
        );
        flags.extend((self.integrate).map(|rule| ("--integrate", rule.name().to_owned())));
        if self.increments {
            flags.push(("--increments", String::new()));
        }
        if self.reverse {
            flags.push(("--reverse", String::new()));
        }
        match self.unsigned {
            Some(true) => flags.push(("--unsigned", String::new())),
            Some(false) => flags.push(("--unsigned=false", String::new())),
            None => {}
        }
        flags.extend(self.every.map(|every| ("--every", every.to_string())));
        flags.extend(self.runs.map(|runs| ("--runs", runs.to_string())));
        flags
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct GivenColumn {
    pub column: String,
    pub unit: Option<&'static str>,
}

impl GivenColumn {
    /// From `COL:UNIT` or `COL`. A column's name may contain a colon: a text that `is_column` has no unit.
    pub fn parse(
        flag: &'static str,
        role: Role,
        text: &str,
        is_column: impl Fn(&str) -> bool,
    ) -> Result<Self, Unclear> {
        let text = text.trim();
        let plain = |column: &str, unit| Self {
            column: column.trim().to_owned(),
            unit,
        };
        match text.rsplit_once(':') {
            _ if is_column(text) => Ok(plain(text, None)),
            Some((column, unit)) => match unit_of(role, unit) {
                Some(unit) => Ok(plain(column, Some(unit))),
                None => Err(Unclear::Unit {
                    flag,
                    unit: unit.to_owned(),
                    expected: expected(role),
                }),
            },
            None => Ok(plain(text, None)),
        }
    }

    /// Digits are a column number: without the log its names are unknown.
    pub fn column_ref(&self) -> ColumnRef {
        match self.column.parse() {
            Ok(number) => ColumnRef::Number(number),
            Err(_) => ColumnRef::Name(self.column.clone()),
        }
    }
}

/// Units of a quantity, for messages.
pub(super) fn expected(role: Role) -> &'static str {
    match role {
        Role::Time | Role::Interval => "s, ms, us, ns, min",
        Role::Position | Role::Increments => "counts, rev, rad, mrad, deg, m, cm, mm",
        Role::Speed => "rpm, rev/s, rad/s, deg/s, counts/s, m/s, cm/s, mm/s, km/h",
        Role::Current => "A, mA",
        Role::Supply => "V, mV",
        Role::Command | Role::CommandOrSupply | Role::Reference => {
            "pwm, percent, share, servo, esc, V, mV, A, mA, N m"
        }
    }
}

/// A command that is not logged: `7V@0.95s`, or several steps separated by commas.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Steps {
    pub unit: &'static str,
    /// Time in s, value in the unit.
    pub points: Vec<(f64, f64)>,
}

impl Steps {
    /// `None` for a text without `@`.
    pub fn parse(text: &str) -> Result<Option<Self>, Unclear> {
        if !text.contains('@') {
            return Ok(None);
        }
        let wrong = || Unclear::Form {
            flag: "--command",
            text: text.to_owned(),
            expected: "such as 7V@0.95s: 0 before, 7 V from then on; more steps after commas, all of one unit",
        };
        let mut found: Option<Self> = None;
        for part in text.split(',') {
            let (value, time) = part.split_once('@').ok_or_else(wrong)?;
            let (value, unit) = number_and_rest(value).ok_or_else(wrong)?;
            let unit = unit_of(Role::Command, unit).ok_or_else(wrong)?;
            let (time, time_unit) = number_and_rest(time).ok_or_else(wrong)?;
            let t_s = match time_unit {
                "" | "s" => time,
                "ms" => time * 1e-3,
                _ => return Err(wrong()),
            };
            let steps = found.get_or_insert(Self {
                unit,
                points: Vec::new(),
            });
            let is_later = steps.points.last().is_none_or(|(before, _)| t_s > *before);
            if steps.unit != unit || !is_later || t_s < 0.0 {
                return Err(wrong());
            }
            steps.points.push((t_s, value));
        }
        let mut steps = found.ok_or_else(wrong)?;
        if steps.points[0].0 > 0.0 {
            steps.points.insert(0, (0.0, 0.0));
        }
        Ok(Some(steps))
    }
}

/// `10ms` is 10 and `ms`; `2:ms` is a column and its unit, hence `None`.
pub(super) fn number_and_rest(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    if text.contains(':') {
        return None;
    }
    let end = text
        .find(|c: char| !matches!(c, '0'..='9' | '.' | '-' | '+'))
        .unwrap_or(text.len());
    let number: f64 = text[..end].parse().ok()?;
    number.is_finite().then_some((number, text[end..].trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_and_units_are_parsed_from_one_argument() {
        let none = |_: &str| false;
        let parse = |text| GivenColumn::parse("--time", Role::Time, text, none);
        let found = parse("t_us:us").expect("good");
        assert_eq!((found.column.as_str(), found.unit), ("t_us", Some("us")));
        assert_eq!(parse("time").expect("good").unit, None);
        assert!(parse("time:furlong").is_err());
        let whole = GivenColumn::parse("--speed", Role::Speed, "a:rpm", |name| name == "a:rpm");
        assert_eq!(whole.expect("good").column, "a:rpm");
    }

    #[test]
    fn a_number_before_a_colon_is_a_column() {
        assert_eq!(number_and_rest("10ms"), Some((10.0, "ms")));
        assert_eq!(number_and_rest("2:ms"), None);
    }

    #[test]
    fn given_steps_are_parsed_from_one_argument() {
        let steps = Steps::parse("7V@0.95s").expect("good").expect("steps");
        assert_eq!(
            (steps.unit, steps.points),
            ("V", vec![(0.0, 0.0), (0.95, 7.0)])
        );
        let steps = Steps::parse("-10%@0,0%@1500ms")
            .expect("good")
            .expect("steps");
        assert_eq!(
            (steps.unit, steps.points),
            ("percent", vec![(0.0, -10.0), (1.5, 0.0)])
        );
        assert_eq!(Steps::parse("pwm").expect("good"), None);
        for wrong in [
            "7@1s",
            "V@1s",
            "7V@",
            "7V@1h",
            "7V@2s,3V@1s",
            "7V@0s,3A@1s",
            "@",
        ] {
            assert!(Steps::parse(wrong).is_err(), "{wrong}");
        }
    }
}
