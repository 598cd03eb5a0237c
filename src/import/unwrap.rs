//! Phase unwrapping (K. Itoh, Applied Optics 21(14), 1982) of wrapping counters, and interpolation of given commands.
//!
//! Unwrapping is correct if successive numbers differ by less than half of the range.

/// State of the unwrapping after a number.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Unwrapped {
    previous: Option<f64>,
    turns: f64,
}

impl Unwrapped {
    /// The unwrapped number, and the state after it, which the caller keeps only if the row is accepted.
    pub fn next(self, number: f64, wrap: Option<f64>) -> (f64, Self) {
        let Some(wrap) = wrap else {
            return (number, self);
        };
        let jump = self.previous.map_or(0.0, |previous| number - previous);
        let after = Self {
            previous: Some(number),
            turns: self.turns - (jump / wrap).round(),
        };
        (number + after.turns * wrap, after)
    }
}

/// Value of a profile at a time: linear interpolation or zero-order hold, constant beyond the ends.
pub(super) fn profile(points: &[(f64, f64)], is_linear: bool, t_s: f64) -> f64 {
    // A point at the time of a row applies from that row on, regardless of rounding.
    let after = points.partition_point(|&(at, _)| at <= t_s + 1e-9);
    let Some(&(from_s, from)) = after.checked_sub(1).and_then(|k| points.get(k)) else {
        return points.first().map_or(0.0, |&(_, value)| value);
    };
    match points.get(after) {
        Some(&(to_s, to)) if is_linear => {
            from + (to - from) * ((t_s - from_s) / (to_s - from_s)).max(0.0)
        }
        _ => from,
    }
}
