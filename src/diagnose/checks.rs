//! What is wrong with a recording itself, before anything is fitted.

use super::verdict::DataProblem;
use crate::check::check;
use crate::check::host_clock::{host_clock, stands};
use crate::compare::lost_samples;
use crate::recording::Run;

/// Sample intervals may scatter by this share of the sample time.
const JITTER: f64 = 0.05;
/// The median interval, or the host's clock, may be off by this share.
const CLOCK: f64 = 0.005;
/// A clock further off than the catalogue goes was not a clock: times of a run that was not taken in real time.
pub(super) const WIDEST_CLOCK: f64 = 0.12;

/// What an imported log did not have, though nothing can be diagnosed without it: the column is nought throughout.
pub(super) fn not_recorded(run: &Run) -> Option<&'static str> {
    let imported = run.header.get("imported")?;
    ["position", "command"]
        .into_iter()
        .find(|what| imported.get(what).and_then(toml::Value::as_str) == Some("not recorded"))
}

/// What can be said of such a log: of its times, its flags and its supply.
pub(super) fn of_what_there_is(name: &str, run: &Run) -> String {
    let found = problems(name, run).into_iter();
    found.map(|found| format!("; {}", found.detail)).collect()
}

/// Every problem of a run.
pub(super) fn problems(name: &str, run: &Run) -> Vec<DataProblem> {
    let mut found = Vec::new();
    let mut say = |problem: &'static str, detail: String| {
        found.push(DataProblem {
            run: name.to_owned(),
            problem: problem.to_owned(),
            detail,
        });
    };
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
    let findings = check(std::slice::from_ref(run), None);
    found.extend(findings.into_iter().map(|finding| DataProblem {
        run: name.to_owned(),
        problem: finding.id(),
        detail: finding.message,
    }));
    found
}

fn intervals(run: &Run, say: &mut impl FnMut(&'static str, String)) {
    if run.len() < 2 {
        return;
    }
    let mut dt: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    dt.sort_by(f64::total_cmp);
    let at = |share: f64| dt[((dt.len() - 1) as f64 * share) as usize];
    let (low, high) = (at(0.05), at(0.95));
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

    /// What is said of the timing.
    fn kinds(run: &Run) -> Vec<String> {
        let found = problems("run.csv", run).into_iter();
        found
            .map(|found| found.problem)
            .filter(|problem| {
                !matches!(
                    problem.as_str(),
                    "command_constant" | "clock_rate" | "time_unit"
                )
            })
            .collect()
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
