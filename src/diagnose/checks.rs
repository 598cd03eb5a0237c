//! What is wrong with a recording itself, before anything is fitted.

use super::verdict::DataProblem;
use crate::check::host_clock::{host_clock, stands};
use crate::compare::lost_samples;
use crate::recording::Run;

/// Sample intervals may scatter by this share of the sample time.
const JITTER: f64 = 0.05;
/// The median interval, or the host's clock, may be off by this share.
const CLOCK: f64 = 0.005;
/// A supply that varies by this share is worth saying; it sags where the command explains this share of the variance.
const SUPPLY: f64 = 0.01;
const FOLLOWS: f64 = 0.25;
/// A clock further off than the catalogue goes was not a clock: times of a run that was not taken in real time.
pub(super) const WIDEST_CLOCK: f64 = 0.12;
/// Fewer counts than this say nothing of the motor.
const FEWEST_COUNTS: i64 = 50;
/// Fewer samples than this say nothing either.
const FEWEST_SAMPLES: usize = 20;

/// What an imported log did not have, though nothing can be diagnosed without it: the column is nought throughout.
pub(super) fn not_recorded(run: &Run) -> Option<&'static str> {
    let imported = run.header.get("imported")?;
    ["position", "command"]
        .into_iter()
        .find(|what| imported.get(what).and_then(toml::Value::as_str) == Some("not recorded"))
}

/// What can be said of such a log: of its times, its flags and its supply.
pub(super) fn of_what_there_is(name: &str, run: &Run) -> String {
    let there = |found: &DataProblem| {
        !matches!(found.problem, "no_motion" | "not_at_rest" | "stale_counts")
    };
    let found = problems(name, run).into_iter().filter(there);
    found.map(|found| format!("; {}", found.detail)).collect()
}

/// Every problem of a run.
pub(super) fn problems(name: &str, run: &Run) -> Vec<DataProblem> {
    let mut found = Vec::new();
    let mut say = |problem: &'static str, detail: String| {
        found.push(DataProblem {
            run: name.to_owned(),
            problem,
            detail,
        });
    };
    if run.len() < FEWEST_SAMPLES {
        say(
            "too_short",
            format!("{} samples only: record longer", run.len()),
        );
        return found;
    }
    let lost = lost_samples(run);
    if lost > 0 {
        say(
            "lost_samples",
            format!(
                "{lost} samples are missing; times are the device's, so that the fit bridges them"
            ),
        );
    }
    if !run.complete && lost == 0 {
        say(
            "incomplete",
            "the file does not say that the recording ended properly".to_owned(),
        );
    }
    intervals(run, &mut say);
    clocks(run, &mut say);
    flags(run, &mut say);
    supply(run, &mut say);
    motion(run, &mut say);
    found
}

fn intervals(run: &Run, say: &mut impl FnMut(&'static str, String)) {
    let mut dt: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    dt.sort_by(f64::total_cmp);
    let at = |share: f64| dt[((dt.len() - 1) as f64 * share) as usize];
    let (median, low, high) = (at(0.5), at(0.05), at(0.95));
    // Lines that arrive in bunches have no typical interval.
    let typical = if run.is_host_timed() {
        dt.iter().sum::<f64>() / dt.len() as f64
    } else {
        median
    };
    if (typical / run.sample_time_s - 1.0).abs() > CLOCK {
        say(
            "wrong_sample_time",
            format!(
                "samples come every {:.3} ms, the file states {:.3} ms",
                typical * 1e3,
                run.sample_time_s * 1e3
            ),
        );
    }
    if high - low > 2.0 * JITTER * run.sample_time_s {
        say(
            "jitter",
            format!(
                "nine in ten intervals lie between {:.3} and {:.3} ms",
                low * 1e3,
                high * 1e3
            ),
        );
    }
}

fn clocks(run: &Run, say: &mut impl FnMut(&'static str, String)) {
    if run.is_host_timed() {
        say(
            "host_timing",
            "times are arrival times at the host: timing effects are not to be trusted".to_owned(),
        );
        return;
    }
    let Some((error, span_s)) = host_clock(run) else {
        return;
    };
    if error.abs() > WIDEST_CLOCK {
        say(
            "not_real_time",
            format!(
                "the host's clock says the board's seconds last {:.4} s: a board in a hurry, whose clock cannot be judged",
                1.0 + error
            ),
        );
        return;
    }
    let stands = stands(run);
    if let Some(first) = stands.first() {
        say(
            "clock_stood",
            format!(
                "by the host's clock the board's stood still {} times, for {:.0} ms in all, first for {:.0} ms at {:.3} s",
                stands.len(),
                1e3 * stands.iter().map(|stand| stand.lost_s).sum::<f64>(),
                1e3 * first.lost_s,
                run.t_s[first.sample]
            ),
        );
    }
    // The earliest arrivals scatter by a millisecond or so.
    if error.abs() > CLOCK.max(0.004 / span_s) {
        say(
            "clock",
            format!(
                "the host's clock says the board's seconds last {:.4} s: its crystal or its timer setting is off",
                1.0 + error
            ),
        );
    }
}

fn flags(run: &Run, say: &mut impl FnMut(&'static str, String)) {
    let Some(flags) = &run.flags else { return };
    let count =
        |which: fn(&crate::recording::Flags) -> bool| flags.iter().filter(|f| which(f)).count();
    for (problem, samples, meaning) in [
        (
            "overruns",
            count(|f| f.overrun),
            "were taken late by the board",
        ),
        (
            "encoder_errors",
            count(|f| f.encoder_error),
            "follow an edge that the decoder missed",
        ),
        (
            "saturated",
            count(|f| f.saturated),
            "had their command limited by the supply",
        ),
    ] {
        if samples > 0 {
            say(problem, format!("{samples} samples {meaning}"));
        }
    }
}

/// What a measured supply does beside the command: a sag follows it, anything else is the supply's own.
fn supply(run: &Run, say: &mut impl FnMut(&'static str, String)) {
    let Some(measured_v) = run.measured_supply_v.as_ref() else {
        return;
    };
    let driven: Vec<f64> = run.command.iter().map(|u| u.abs()).collect();
    let largest = driven.iter().fold(0.0, |most: f64, u| most.max(*u));
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
    let (v_mean, u_mean) = (mean(measured_v), mean(&driven));
    let (mut vv, mut uv, mut uu) = (0.0, 0.0, 0.0);
    for (v, u) in measured_v.iter().zip(&driven) {
        vv += (v - v_mean).powi(2);
        uv += (u - u_mean) * (v - v_mean);
        uu += (u - u_mean).powi(2);
    }
    let deviation = (vv / measured_v.len().max(1) as f64).sqrt();
    let varies = deviation > SUPPLY * v_mean;
    if !varies {
        return;
    }
    let (lo, hi) = measured_v
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| {
            (v.min(lo), v.max(hi))
        });
    let about = format!(
        "the measured supply is {v_mean:.2} V and varies by {deviation:.2} V (standard deviation; {lo:.1} to {hi:.1} V)"
    );
    let explained = if uu > 0.0 { uv * uv / (uu * vv) } else { 0.0 };
    if explained > FOLLOWS && uv < 0.0 {
        say(
            "supply_sags",
            format!(
                "{about}; it falls by {:.2} V at the largest command, which explains {:.0} % of that",
                -uv / uu * largest,
                100.0 * explained
            ),
        );
    } else {
        say(
            "supply_varies",
            format!(
                "{about}; the size of the command explains {:.0} % of that: it is no sag under load",
                100.0 * explained
            ),
        );
    }
}

fn motion(run: &Run, say: &mut impl FnMut(&'static str, String)) {
    let (least, most) = run
        .counts
        .iter()
        .fold((i64::MAX, i64::MIN), |(lo, hi), &n| (lo.min(n), hi.max(n)));
    if most.saturating_sub(least) < FEWEST_COUNTS {
        say(
            "no_motion",
            format!(
                "the shaft moved by {} counts in the whole run: is the encoder connected?",
                most.saturating_sub(least)
            ),
        );
        return;
    }
    let before_drive = run.command.iter().take_while(|u| **u == 0.0).count();
    if before_drive > 1 {
        let drift = run.counts[..before_drive]
            .iter()
            .any(|n| n.abs_diff(run.counts[0]) > 1);
        if drift {
            say(
                "not_at_rest",
                "the shaft moves before anything is commanded: the simulation starts from rest"
                    .to_owned(),
            );
        }
    }
    let driven = run.command.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    // A long stretch of full command without a single count, after the shaft has moved.
    let longest = run
        .counts
        .windows(2)
        .zip(&run.command)
        .fold((0usize, 0usize), |(now, most), (pair, u)| {
            let stuck = pair[0] == pair[1] && u.abs() > 0.6 * driven;
            let now = if stuck { now + 1 } else { 0 };
            (now, most.max(now))
        })
        .1;
    if longest as f64 * run.sample_time_s > 0.5 {
        say(
            "stale_counts",
            format!(
                "the count stands still for {:.2} s at more than half of the largest command",
                longest as f64 * run.sample_time_s
            ),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turning() -> Run {
        let mut run = Run {
            sample_time_s: 0.005,
            counts_per_rev: 720.0,
            complete: true,
            ..Run::default()
        };
        for k in 0..400_u32 {
            run.t_s.push(f64::from(k) * 0.005);
            run.command.push(4.5);
            run.counts.push(i64::from(k) * 3);
        }
        run
    }

    fn kinds(run: &Run) -> Vec<&'static str> {
        let found = problems("run.csv", run);
        found.iter().map(|found| found.problem).collect()
    }

    #[test]
    fn the_timing_of_a_host_timed_run_is_not_trusted_and_no_clock_is_accused() {
        let mut run = turning();
        // A host's clock that runs 2 % fast beside the times.
        run.host_t_s = Some(run.t_s.iter().map(|t| 1.02 * t).collect());
        assert_eq!(kinds(&run), ["clock"]);
        run.header.insert("timing".to_owned(), "host".into());
        assert_eq!(kinds(&run), ["host_timing"]);
    }

    #[test]
    fn a_supply_that_falls_with_the_command_sags_and_one_that_does_not_varies() {
        let mut run = turning();
        run.command = (0..400)
            .map(|k| f64::from((k / 100 + 1) % 2) * 4.0)
            .collect();
        run.measured_supply_v = Some(run.command.iter().map(|u| 7.4 - 0.1 * u).collect());
        let found = problems("run.csv", &run);
        assert_eq!(found[0].problem, "supply_sags");
        assert!(
            found[0].detail.contains("falls by 0.40 V"),
            "{}",
            found[0].detail
        );
        // One that rises with the command does not sag.
        run.measured_supply_v = Some(run.command.iter().map(|u| 7.0 + 0.1 * u).collect());
        assert_eq!(kinds(&run), ["supply_varies"]);
        run.measured_supply_v = Some((0..400).map(|k| 7.4 + f64::from(k % 2)).collect());
        assert_eq!(kinds(&run), ["supply_varies"]);
        run.measured_supply_v = Some(vec![7.4; 400]);
        assert!(kinds(&run).is_empty());
    }

    #[test]
    fn of_a_log_without_position_its_supply_can_be_told_and_nothing_of_its_motion() {
        let mut run = turning();
        assert_eq!(not_recorded(&run), None);
        let imported: toml::Table = "[imported]\nposition = 'not recorded'"
            .parse()
            .expect("TOML");
        run.header = imported;
        run.counts = vec![0; 400];
        run.command[..100].fill(0.0);
        run.measured_supply_v = Some(run.command.iter().map(|u| 7.4 - 0.1 * u).collect());
        assert_eq!(not_recorded(&run), Some("position"));
        let found = of_what_there_is("run.csv", &run);
        assert!(found.contains("it falls by 0.45 V"), "{found}");
        assert!(!found.contains("encoder"), "{found}");
    }

    #[test]
    fn no_clock_is_accused_where_the_board_was_in_a_hurry() {
        let mut run = turning();
        for factor in [0.005, 3.0] {
            run.host_t_s = Some(run.t_s.iter().map(|t| factor * t).collect());
            assert_eq!(kinds(&run), ["not_real_time"], "{factor}");
        }
    }
}
