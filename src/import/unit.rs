//! Units of foreign logs and their factors to SI.

use std::f64::consts::TAU;

use super::MapError;
use crate::recording::CommandKind;

/// Conversion of counts and metres to angles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// Counts of the encoder in one revolution.
    pub counts_per_rev: f64,
    /// Travel of a linear axis in one revolution in m, if the mapping has it.
    pub m_per_rev: Option<f64>,
}

impl Axis {
    fn m_per_rev(&self, section: &'static str) -> Result<f64, MapError> {
        self.m_per_rev.ok_or(MapError::Missing {
            section,
            key: "m_per_rev",
            why: "a linear axis needs, at the top of the mapping, its travel in one revolution in m",
        })
    }
}

/// A unit in a normalized notation.
fn plain(unit: &str) -> String {
    unit.trim()
        .replace(['µ', 'μ'], "u")
        .replace('°', "deg")
        .replace([' ', '·', '*'], "")
}

fn unknown(section: &'static str, unit: &str, expected: &str) -> MapError {
    MapError::Value {
        section,
        key: "unit",
        found: format!("`{unit}`"),
        expected: format!("one of {expected}"),
    }
}

/// Seconds per unit.
pub(super) fn time_s(unit: &str) -> Result<f64, MapError> {
    Ok(match plain(unit).as_str() {
        // A time stamp is in seconds in any case.
        "s" | "stamp" => 1.0,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "100ns" => 1e-7,
        "min" => 60.0,
        "h" => 3600.0,
        "d" => 86_400.0,
        _ => {
            return Err(unknown(
                "[time]",
                unit,
                "s, ms, us, ns, 100ns, min, h, d, stamp (12:34:56.789, 2026-04-13 19:03:12)",
            ));
        }
    })
}

/// Revolutions per unit.
pub(super) fn angle_rev(unit: &str, axis: &Axis) -> Result<f64, MapError> {
    let section = "[position]";
    Ok(match plain(unit).as_str() {
        "counts" | "count" | "ticks" => 1.0 / axis.counts_per_rev,
        "rev" | "turn" | "turns" => 1.0,
        "rad" => 1.0 / TAU,
        "mrad" => 1e-3 / TAU,
        "deg" => 1.0 / 360.0,
        "m" => 1.0 / axis.m_per_rev(section)?,
        "cm" => 1e-2 / axis.m_per_rev(section)?,
        "mm" => 1e-3 / axis.m_per_rev(section)?,
        "um" => 1e-6 / axis.m_per_rev(section)?,
        _ => {
            return Err(unknown(
                section,
                unit,
                "counts, rev, rad, mrad, deg, m, cm, mm, um",
            ));
        }
    })
}

/// Revolutions per second per unit.
pub(super) fn speed_rev_s(unit: &str, axis: &Axis) -> Result<f64, MapError> {
    let section = "[speed]";
    Ok(match plain(unit).as_str() {
        "rpm" | "RPM" | "rev/min" => 1.0 / 60.0,
        "rev/s" | "Hz" => 1.0,
        "rad/s" => 1.0 / TAU,
        "deg/s" => 1.0 / 360.0,
        "counts/s" => 1.0 / axis.counts_per_rev,
        "m/s" => 1.0 / axis.m_per_rev(section)?,
        "cm/s" => 1e-2 / axis.m_per_rev(section)?,
        "mm/s" => 1e-3 / axis.m_per_rev(section)?,
        "km/h" => 1.0 / 3.6 / axis.m_per_rev(section)?,
        _ => {
            return Err(unknown(
                section,
                unit,
                "rpm, rev/s, rad/s, deg/s, counts/s, m/s, cm/s, mm/s, km/h",
            ));
        }
    })
}

/// Amperes per unit.
pub(super) fn current_a(unit: &str) -> Result<f64, MapError> {
    Ok(match plain(unit).as_str() {
        "A" => 1.0,
        "mA" => 1e-3,
        _ => return Err(unknown("[current]", unit, "A, mA")),
    })
}

/// Volts per unit.
pub(super) fn supply_v(unit: &str) -> Result<f64, MapError> {
    Ok(match plain(unit).as_str() {
        "V" => 1.0,
        "mV" => 1e-3,
        _ => return Err(unknown("[supply]", unit, "V, mV")),
    })
}

/// Meaning of a command's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CommandUnit {
    /// Factor to V, A or N m.
    Direct(CommandKind, f64),
    /// A share of the supply; full drive is this number, or the mapping's `full`.
    Share(Option<f64>),
}

/// Source of the command.
pub(super) fn command(unit: &str, axis: &Axis) -> Result<CommandUnit, MapError> {
    use CommandKind::{Current, Torque, Voltage};
    let section = "[command]";
    Ok(match plain(unit).as_str() {
        "V" => CommandUnit::Direct(Voltage, 1.0),
        "mV" => CommandUnit::Direct(Voltage, 1e-3),
        "A" => CommandUnit::Direct(Current, 1.0),
        "mA" => CommandUnit::Direct(Current, 1e-3),
        "Nm" => CommandUnit::Direct(Torque, 1.0),
        "mNm" => CommandUnit::Direct(Torque, 1e-3),
        // Work of one revolution: F * travel = torque * 2 pi.
        "N" => CommandUnit::Direct(Torque, axis.m_per_rev(section)? / TAU),
        "pwm" | "PWM" => CommandUnit::Share(None),
        "percent" | "%" => CommandUnit::Share(Some(100.0)),
        "share" => CommandUnit::Share(Some(1.0)),
        _ => {
            return Err(unknown(
                section,
                unit,
                "V, mV, A, mA, N m, mN m, N (with m_per_rev), pwm (with full), percent, share",
            ));
        }
    })
}
