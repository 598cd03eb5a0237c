//! A clock in two columns: integral seconds and their fraction, `sec` and `nanosec`, `tv_sec` and `tv_usec`; or
//! minutes and seconds. The integral seconds may be time stamps.

use super::super::clock::Counts;
use super::clock::{Clock, median};
use super::clock_units::in_seconds;
use super::decide::Decision;
use super::readings::Readings;
use super::units::Role;

/// Names of a column of minutes.
const MINUTES: [&str; 5] = ["min", "mins", "minute", "minutes", "minuten"];

impl Decision<'_> {
    /// A time in two columns, one of which is `with`, if known. The fraction wraps in exactly the rows in which the
    /// seconds increase.
    pub(super) fn pair(&self, with: Option<usize>) -> Option<Clock> {
        let all = || 0..self.survey.columns.len();
        let is_time = |at: usize| matches!(self.name_facts[at].role, None | Some(Role::Time));
        let is_seconds = |&at: &usize| {
            let has_unit = matches!(self.name_facts[at].unit, None | Some("s"));
            is_time(at) && has_unit && self.is_whole_seconds(at)
        };
        let is_with = |a, b| with.is_none_or(|with| with == a || with == b);
        all().filter(is_seconds).find_map(|whole| {
            all()
                .filter(|&rest| rest != whole && is_time(rest) && is_with(whole, rest))
                .find_map(|rest| self.pair_of(whole, rest))
        })
    }

    /// Whether a column counts seconds: integers that increase by one, in less than half of the rows.
    fn is_whole_seconds(&self, at: usize) -> bool {
        let column = self.column(at);
        let readings = column.readings();
        let steps: Vec<f64> = readings.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let count = |is: fn(f64) -> bool| steps.iter().filter(|step| is(**step)).count();
        let (ones, pauses) = (count(|step| step == 1.0), count(|step| step > 1.0));
        (column.is_numeric() || column.is_stamps())
            && readings.iter().all(|x| x.fract() == 0.0 || !x.is_finite())
            && count(|step| step < 0.0) == 0
            && ones > pauses
            && 2 * ones < steps.len()
    }

    fn pair_of(&self, whole: usize, rest: usize) -> Option<Clock> {
        let (seconds, parts) = (self.column(whole), self.column(rest));
        let is_minutes =
            (self.name_facts[whole].words.iter()).any(|word| MINUTES.contains(&word.as_str()));
        let whole_unit = match (is_minutes, seconds.is_stamps()) {
            (true, _) => "min",
            (_, true) => "stamp",
            (_, false) => "s",
        };
        let unit = match (self.name_facts[rest].unit, is_minutes) {
            (Some(unit @ ("ns" | "us" | "ms")), false) => unit,
            (None | Some("s"), true) => "s",
            (None, false) => unit_of_part(parts.highest())?,
            _ => return None,
        };
        let unit_s = in_seconds(unit);
        let whole_s = in_seconds(whole_unit);
        let is_part = parts.is_numeric()
            && (parts.is_whole() || is_minutes)
            && parts.lowest() >= 0.0
            && parts.highest() * unit_s < whole_s;
        let rows: Vec<(f64, f64)> = (seconds.readings().iter().copied())
            .zip(parts.numbers.iter().copied())
            .filter(|(whole, rest)| whole.is_finite() && rest.is_finite())
            .collect();
        // Across a pause the fraction may do either.
        let fits = |pair: &[(f64, f64)]| match pair[1].0 - pair[0].0 {
            0.0 => pair[1].1 >= pair[0].1,
            1.0 => pair[1].1 < pair[0].1,
            _ => true,
        };
        let first = rows.first()?.0;
        let times: Vec<f64> = (rows.iter())
            .map(|(whole, rest)| (whole - first) * whole_s + rest * unit_s)
            .collect();
        let is_clock =
            is_part && rows.windows(2).all(fits) && Readings::of(&times) == Readings::Rising;
        is_clock.then(|| Clock {
            at: whole,
            unit: whole_unit,
            unit_by: None,
            fraction: Some((rest, unit)),
            counts: Counts::SinceOrigin,
            wrap: None,
            shared: 1.0,
            step_s: median(times.windows(2).map(|pair| pair[1] - pair[0]).collect()),
        })
    }
}

/// The unit of the fraction of integral seconds, by the digits of the largest.
fn unit_of_part(highest: f64) -> Option<&'static str> {
    Some(match highest {
        1e6..1e9 => "ns",
        1e3..1e6 => "us",
        1.0..1e3 => "ms",
        _ => return None,
    })
}
