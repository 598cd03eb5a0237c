//! Plausible ranges of the values in files and flags. Every reader checks against this table, so that later code need
//! not.
//!
//! The ranges are wide: a value at an end is rarer than a typing error or a wrong unit, but can still be simulated.

use std::fmt;

/// A range of plausible values, both ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest plausible value.
    pub lo: f64,
    /// Largest plausible value.
    pub hi: f64,
    /// Unit for output; empty for a dimensionless value.
    pub unit: &'static str,
    /// Advice for a value outside.
    pub remedy: &'static str,
}

/// Sample time in s: a microsecond is faster than any encoder board, a minute slower than any motor.
pub const SAMPLE_TIME_S: Range = range(1e-6, 60.0, "s", "is it in seconds?");

/// Encoder counts per revolution, all edges counted. The finest absolute encoders have 2^32 per revolution, and more
/// with a gear; an encoder with one count in a hundred revolutions is on the fast side of a gear.
pub const COUNTS_PER_REV: Range = range(
    0.01,
    1e12,
    "",
    "it is lines times 4, times the gear ratio where the encoder sits before the gear",
);

/// Driver supply in V.
pub const SUPPLY_V: Range = range(1e-3, 1e5, "V", "is it in volts?");

/// Time of a sample in s; 1e10 s is more than three centuries, so that times since 1970 fit.
pub const TIME_S: Range = range(-1e10, 1e10, "s", "is it in seconds?");

/// Time between two rows of a run in s; a simulation includes the gap.
pub const GAP_S: Range = range(
    0.0,
    3600.0,
    "s",
    "a recording with a longer gap is two: cut the file there",
);

/// Duration of a run, a profile or a simulation in s: up to four months.
pub const DURATION_S: Range = range(1e-6, 1e7, "s", "is it in seconds?");

/// Encoder counts of a sample: differences of two of them fit into 64 bits.
pub const COUNTS: Range = range(
    -4.6e18,
    4.6e18,
    "counts",
    "is it the position in counts of the encoder?",
);

/// A command in V, A or N m, and a measured value in V or A.
pub const COMMAND: Range = range(-1e6, 1e6, "", "is it in V, A or N m?");

/// Relative standard deviation of a parameter.
pub const TOLERANCE: Range = range(0.0, 10.0, "", "a tolerance is relative: 0.05 is 5 %");

/// A factor that a mapping file applies to a column.
pub const SCALE: Range = range(
    -1e15,
    1e15,
    "",
    "it is what one unit of the column is worth",
);

/// Offset of a mapping file's column, and the range of its wrap.
pub const OFFSET: Range = range(-1e19, 1e19, "", "it is in the column's own unit");

const fn range(lo: f64, hi: f64, unit: &'static str, remedy: &'static str) -> Range {
    Range {
        lo,
        hi,
        unit,
        remedy,
    }
}

/// The range of a nominal parameter by its key: from a watch's motor to a wind turbine's.
pub fn of_parameter(key: &str) -> Range {
    let (lo, hi, unit) = match key {
        "resistance_ohm" => (1e-6, 1e6, "ohm"),
        "back_emf_v_s_per_rad" => (0.0, 1e4, "V s/rad"),
        "torque_constant_nm_per_a" => (1e-9, 1e4, "N m/A"),
        "viscous_friction_nm_s_per_rad" => (0.0, 1e6, "N m s/rad"),
        "inductance_h" => (0.0, 1e3, "H"),
        "inertia_kg_m2" => (1e-15, 1e9, "kg m^2"),
        "coulomb_friction_nm" => (0.0, 1e9, "N m"),
        "counts_per_rev" => return COUNTS_PER_REV,
        "supply_v" => return SUPPLY_V,
        _ => (-f64::MAX, f64::MAX, ""),
    };
    range(lo, hi, unit, "is it in SI units, as the key says?")
}

/// Upper limit of a parameter of an effect, by its key and its unit; the lower limit is the effect's.
pub fn largest_of_effect(key: &str, unit: &str) -> f64 {
    match (key, unit) {
        // Up to the longest sample time.
        ("delay_s" | "spread_s" | "offset_s", _) => SAMPLE_TIME_S.hi,
        (_, "s") => 1e6,
        (_, "Hz") => 1e4,
        (_, "1/s") => 1e12,
        (_, "V") => SUPPLY_V.hi,
        (_, "A") => COMMAND.hi,
        (_, "ohm") => of_parameter("resistance_ohm").hi,
        (_, "H") => of_parameter("inductance_h").hi,
        (_, "kg m^2") => of_parameter("inertia_kg_m2").hi,
        (_, "N m") => of_parameter("coulomb_friction_nm").hi,
        (_, "rad") => 1e3,
        ("cycles_per_rev", _) => 1e5,
        // A ratio, or a dimensionless coefficient.
        (_, "") => 1e3,
        _ => 1e9,
    }
}

impl Range {
    /// Whether a value is in the range; NaN is not.
    pub fn holds(&self, value: f64) -> bool {
        (self.lo..=self.hi).contains(&value)
    }
}

/// `1e-6 .. 60 s (is it in seconds?)`.
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} .. {}", Shown(self.lo), Shown(self.hi))?;
        if !self.unit.is_empty() {
            write!(f, " {}", self.unit)?;
        }
        write!(f, " ({})", self.remedy)
    }
}

/// A number in a message, in scientific notation if it is long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown(pub f64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-4..1e9).contains(&size) || !size.is_finite() {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Parameters;

    #[test]
    fn ranges_include_their_ends_and_exclude_nan() {
        for range in [SAMPLE_TIME_S, COUNTS_PER_REV, of_parameter("inertia_kg_m2")] {
            assert!(range.holds(range.lo) && range.holds(range.hi));
            assert!(!range.holds(range.hi * 1.001) && !range.holds(range.lo * 0.999));
        }
        for value in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
            assert!(!TIME_S.holds(value));
        }
        assert_eq!(
            SAMPLE_TIME_S.to_string(),
            "1e-6 .. 60 s (is it in seconds?)"
        );
    }

    #[test]
    fn every_parameter_has_a_range_and_the_handouts_motor_lies_in_it() {
        let handout = Parameters::default();
        for key in Parameters::KEYS {
            let range = of_parameter(key);
            assert!(range.hi < f64::MAX, "{key}");
            assert!(range.holds(handout.get(key).unwrap()), "{key}");
        }
    }

    #[test]
    fn messages_have_few_digits() {
        for (value, shown) in [
            (1e-308, "1e-308"),
            (3e10, "3e10"),
            (0.003, "0.003"),
            (0.0, "0"),
        ] {
            assert_eq!(Shown(value).to_string(), shown);
        }
    }
}
