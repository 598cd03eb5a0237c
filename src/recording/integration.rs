//! Integration of logged speeds to a position.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Integration rule of a speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Integration {
    /// The mean of two neighbours in between: for an instantaneous speed.
    #[default]
    Trapezoid,
    /// A row's speed since the previous row: for a difference of positions.
    Backward,
    /// A row's speed until the next row: for one measured under the command of the same row.
    Forward,
}

impl Integration {
    /// Name in mappings and flags.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Trapezoid => "trapezoid",
            Self::Backward => "backward",
            Self::Forward => "forward",
        }
    }

    /// The mean speed of a step of `step_s`, between the speeds of its rows. `time_constant_s` is the motor's.
    pub(crate) fn mean_between(
        self,
        (before, speed): (f64, f64),
        step_s: f64,
        time_constant_s: Option<f64>,
    ) -> f64 {
        match self {
            Self::Trapezoid => before + weight_of_end(step_s, time_constant_s) * (speed - before),
            Self::Backward => speed,
            Self::Forward => before,
        }
    }
}

impl FromStr for Integration {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Trapezoid, Self::Backward, Self::Forward]
            .into_iter()
            .find(|rule| rule.name() == text)
            .ok_or_else(|| {
                format!("'{text}' is no rule of integration\nhint: backward, trapezoid or forward")
            })
    }
}

/// Weight of the final speed in the mean between two rows: 0.5 for a straight line. A first-order response with time
/// constant `T` from `v0` to `v1` in a step of `h` has the mean `v0 + (v1 - v0) (1 / (1 - exp(-h/T)) - T/h)`.
fn weight_of_end(step_s: f64, time_constant_s: Option<f64>) -> f64 {
    let Some(time_constant_s) = time_constant_s else {
        return 0.5;
    };
    let h = step_s / time_constant_s;
    // The two terms cancel for small values, where the series is used.
    match h < 1e-3 {
        true => 0.5 + h / 12.0,
        false => -(-h).exp_m1().recip() - h.recip(),
    }
}
