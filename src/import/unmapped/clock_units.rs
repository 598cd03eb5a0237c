//! Units of clocks from their readings: the step from row to row, times of this century, the range at which a counter wraps.

use super::super::stamp::DAY_S;
use super::column::Column;

/// Sample times in s of motors' logs: 5 kHz to about a row a second, too slow for any start of a motor. A step of 20 is then in ms, since 20 us
/// and 20 s are outside; a step of 200 to 900 may be in us or ms.
const SAMPLE_TIMES_S: (f64, f64) = (2e-4, 0.9);
/// Sample times in s of a PC program with a stopwatch in units of 100 ns.
const STOPWATCH_S: (f64, f64) = (5e-3, 0.2);
/// Days since 1900 from 1982 to 2064.
const SPREADSHEET_DAYS: (f64, f64) = (30_000.0, 60_000.0);
/// `micros()` and `millis()` begin again at 0 here.
pub(super) const CLOCK_WRAP: f64 = 4_294_967_296.0;
/// The same in a variable of 16 bits, signed or not...
pub(super) const CLOCK_WRAP_16: f64 = 65_536.0;
/// ...where each fall is one step of a row, of at most so many usual ones, less a wrap: a new start falls to 0 from anywhere.
const WRAPPED_STEPS: f64 = 2.5;
/// The years 2000 to 2100 in s since 1970.
const THIS_CENTURY_S: (f64, f64) = (946_684_800.0, 4_102_444_800.0);
/// Units of times of this century: the first of the count (1970; 1601 of Windows; the year 1 of .NET) in s since 1970, and the unit.
const EPOCHS: [(f64, &str); 5] = [
    (0.0, "ms"),
    (0.0, "us"),
    (0.0, "ns"),
    (-11_644_473_600.0, "100ns"),
    (-62_135_596_800.0, "100ns"),
];
/// Seconds in a unit of time.
pub(super) fn in_seconds(unit: &str) -> f64 {
    match unit {
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "100ns" => 1e-7,
        "min" => 60.0,
        "d" => DAY_S,
        _ => 1.0,
    }
}

/// The unit in which readings are times of this century, and their steps those of motors' logs.
pub(super) fn unit_since_epoch(column: &Column, step: f64) -> Option<&'static str> {
    let (from_s, to_s) = THIS_CENTURY_S;
    let is_in = |(epoch_s, unit): &(f64, &str)| {
        let since_s = |reading: f64| reading * in_seconds(unit) + epoch_s;
        let is_usual = (SAMPLE_TIMES_S.0..=SAMPLE_TIMES_S.1).contains(&(step * in_seconds(unit)));
        is_usual && since_s(column.lowest()) >= from_s && since_s(column.highest()) <= to_s
    };
    EPOCHS.into_iter().find(is_in).map(|(_, unit)| unit)
}

/// Whether a clock falls, and only where a counter of 16 bits wraps.
pub(super) fn wraps_at_16_bits(readings: &[f64], step: f64) -> bool {
    let falls = || {
        let steps = readings.windows(2).map(|pair| pair[1] - pair[0]);
        steps.filter(|step| *step < 0.0)
    };
    let is_wrap = |fall: f64| {
        let went_on = fall + CLOCK_WRAP_16;
        went_on > 0.0 && went_on <= WRAPPED_STEPS * step
    };
    falls().next().is_some() && falls().all(is_wrap)
}

/// Whether readings are a spreadsheet's: days since 1900, some decades on, in steps that are samples.
pub(super) fn is_days(column: &Column, step: f64) -> bool {
    let (first, last) = SPREADSHEET_DAYS;
    let (least_s, most_s) = SAMPLE_TIMES_S;
    column.lowest() >= first
        && column.highest() <= last
        && (least_s..=most_s).contains(&(step * DAY_S))
}

/// The units in which a step of the clock is a usual sample time of motors. Units of 100 ns are a PC's, whose rows are slower, except for a
/// counter of `ticks`.
pub(super) fn units_of_clock(step: f64, is_ticks: bool) -> Vec<&'static str> {
    let units = ["s", "ms", "us", "100ns", "ns"].into_iter();
    units
        .filter(|unit| {
            let (least_s, most_s) = match *unit {
                "100ns" if !is_ticks => STOPWATCH_S,
                _ => SAMPLE_TIMES_S,
            };
            (least_s..=most_s).contains(&(step * in_seconds(unit)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_of_16_bits_is_told_from_a_new_start() {
        let wrapped = [65_520.0, 65_530.0, 4.0, 14.0];
        assert!(wraps_at_16_bits(&wrapped, 10.0));
        assert!(wraps_at_16_bits(&[32_760.0, -32_766.0, -32_756.0], 10.0));
        assert!(!wraps_at_16_bits(&[50_000.0, 50_010.0, 0.0, 10.0], 10.0));
        assert!(!wraps_at_16_bits(&[0.0, 10.0, 20.0], 10.0));
    }

    #[test]
    fn the_units_of_a_clock_are_those_that_fit() {
        for (step, units, of_ticks) in [
            (0.003, &["s"][..], &["s"][..]),
            (0.1, &["s"], &["s"]),
            (0.25, &["s", "ms"], &["s", "ms"]),
            (250.0, &["ms", "us"], &["ms", "us"]),
            (1.0, &["ms"], &["ms"]),
            (20.0, &["ms"], &["ms"]),
            (5000.0, &["us"], &["us", "100ns"]),
            (20_000.0, &["us"], &["us", "100ns"]),
            (50_000.0, &["us", "100ns"], &["us", "100ns"]),
            (100_000.0, &["us", "100ns"], &["us", "100ns"]),
            (500_000.0, &["us", "100ns", "ns"], &["us", "100ns", "ns"]),
            (5e6, &["ns"], &["100ns", "ns"]),
            (1e7, &["ns"], &["ns"]),
            (1e10, &[], &[]),
            (0.0, &[], &[]),
            (f64::NAN, &[], &[]),
        ] {
            assert_eq!(units_of_clock(step, false), units, "{step}");
            assert_eq!(units_of_clock(step, true), of_ticks, "{step}");
        }
    }
}
