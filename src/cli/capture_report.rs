//! Summary at the end of a recording, live or replayed.

use serde_json::json;

use super::findings::check_written;
use super::reconnect::Segments;
use super::{Failure, Output, Status};
use crate::hint::{Hinted, parted};
use crate::plain::shown;
use crate::recording::{Captured, Ending};

/// Prints the result of a recording and returns the exit status. `until_end`: an end was requested, so that an
/// earlier stop falls short. `before`: earlier segments, ended by an unplugged board.
pub(super) fn report(
    output: &Output,
    captured: &Captured,
    until_end: bool,
    before: &Segments,
) -> Result<Status, Failure> {
    let statistics = &captured.statistics;
    let (findings, contradicts) = check_written(&[&captured.path], output);
    let failed_logs = before.failed_logs();
    let failed = captured.rescued.as_ref().map(|rescued| {
        let (what, hint) = parted(rescued);
        Hinted::new(
            what,
            hint.unwrap_or("keep other programs away from a file that is written"),
        )
    });
    let ending_problem = ending_error(captured.ending);
    let failed =
        failed.or_else(|| (ending_problem.clone()).filter(|_| captured.ending != Ending::LogEnded));
    let failed = failed.or_else(|| failed_logs.first().cloned());
    if output.json {
        let mut document = json!({
            "format": "motorlab-capture/1",
            "path": captured.path,
            "ending": captured.ending,
            "samples": statistics.samples,
            "lost": statistics.lost,
            "statistics": statistics,
            "line": captured.damage,
            "samples_taken_by_board": captured.taken,
            "complete": captured.complete,
            "contradictions": captured.contradictions,
            "findings": findings,
            "segments_before": before.files().map(|(path, samples)| {
                json!({ "path": path, "samples": samples })
            }).collect::<Vec<_>>(),
        });
        if let Some(failed) = &failed {
            let failure = Failure::device(failed.clone()).at(&captured.path);
            document["error"] = failure.document()["error"].clone();
        }
        output.document(&document)?;
    } else {
        output.line(&summary(captured))?;
    }
    for failed in &failed_logs {
        output.message(&format!("error: {failed}"));
        output.message(&format!(
            "{} holds {} rows",
            shown(&captured.path),
            statistics.samples
        ));
    }
    if let (Some(_), Some(failed)) = (&captured.rescued, &failed) {
        output.message(&format!("error: {failed}"));
        return Ok(Status::DeviceFailed);
    }
    if let Some(ending_error) = ending_problem {
        output.message(&format!("error: {ending_error}"));
        return Ok(match captured.ending {
            Ending::LogEnded => Status::FellShort,
            _ => Status::DeviceFailed,
        });
    }
    let cut_short = captured.ending == Ending::Stopped && until_end;
    if cut_short {
        output.message("stopped before the time asked for; the file is whole up to there");
    }
    if statistics.lost > 0 {
        output.message(&format!(
            "{} of {} samples were lost; the file has no row for them",
            statistics.lost,
            statistics.samples + statistics.lost
        ));
    }
    if statistics.lost > 0 && captured.damage.implausible > 0 {
        output.message(&format!(
            "{} frames came whole, and their time, counts or command do not go with the samples before them: they are no rows",
            captured.damage.implausible
        ));
    }
    let leaps = [
        (
            statistics.time_leaps,
            "time_leap",
            "the board's time fell back or leapt",
        ),
        (
            statistics.counts_leaps,
            "counts_leap",
            "the counts moved faster than any motor can, were set to 0, or may have wrapped a 16-bit counter in a gap",
        ),
    ];
    for (rows, flag, what) in leaps.into_iter().filter(|(rows, ..)| *rows > 0) {
        output.message(&format!(
            "in {rows} rows {what}: they have the flag {flag}; look at the wiring and at the sketch before you use the run"
        ));
    }
    for contradiction in &captured.contradictions {
        output.message(&format!("the board contradicts itself: {contradiction}"));
    }
    if !before.is_empty() {
        output.message("the board was unplugged on the way; each file is a run of its own");
    }
    let fell_short = cut_short
        || contradicts
        || statistics.lost > 0
        || statistics.time_leaps + statistics.counts_leaps > 0
        || !captured.contradictions.is_empty()
        || !before.is_empty();
    Ok(if !failed_logs.is_empty() {
        Status::DeviceFailed
    } else if fell_short {
        Status::FellShort
    } else {
        Status::Done
    })
}

/// Error of a recording that ended irregularly.
pub(super) fn ending_error(ending: Ending) -> Option<Hinted> {
    let (what, hint) = match ending {
        Ending::Complete | Ending::Stopped => return None,
        Ending::LinkLost => (
            "the board heard nothing of this program for half a second and stopped the motor",
            "the computer was suspended or overloaded: keep it awake, close other programs, and record again",
        ),
        Ending::Unplugged => (
            "the board was unplugged",
            "check the cable, then record again; --reconnect waits for the board and continues in a new file",
        ),
        Ending::BoardReset => (
            "the board was reset during the recording",
            "give the motor a supply of its own, check the cable, and keep other programs off the port; then record again",
        ),
        Ending::BoardChanged => (
            "during the recording the board reported another identity than before",
            "make sure that one program and one board use the port, then record again",
        ),
        Ending::RanOn => (
            "the board continues after the samples asked for and does not stop",
            "cut the motor's supply, then upload the sketch again: motorlab flash PORT",
        ),
        Ending::Silent => (
            "the board fell silent",
            "check its cable and its supply, then record again",
        ),
        Ending::LineFailed => (
            "the serial line failed",
            "unplug the board and plug it in again, then record again",
        ),
        Ending::LogEnded => (
            "the raw log ends before the recording does",
            "the rows up to there are whole; for the rest, record again",
        ),
    };
    Some(Hinted::new(format!("{what}; the file ends there"), hint))
}

fn summary(captured: &Captured) -> String {
    let statistics = &captured.statistics;
    let mut lines = vec![
        format!("wrote {}", shown(&captured.path)),
        format!(
            "  {} samples in {:.3} s, {} lost, {} overruns",
            statistics.samples, statistics.duration_s, statistics.lost, statistics.overruns
        ),
    ];
    if statistics.encoder_errors > 0 || statistics.saturated > 0 {
        lines.push(format!(
            "  {} with an illegal encoder transition, {} limited by the supply",
            statistics.encoder_errors, statistics.saturated
        ));
    }
    if captured.damage.bad_frames + captured.damage.implausible > 0 {
        lines.push(format!(
            "  {} damaged frames, {} that passed the CRC but do not fit",
            captured.damage.bad_frames, captured.damage.implausible
        ));
    }
    if let Some(dt) = &statistics.device_dt {
        lines.push(format!(
            "  device dt {} / {} / {} us (min / median / max)",
            dt.min_us, dt.median_us, dt.max_us
        ));
    }
    if let Some(clock) = &statistics.clock {
        lines.push(format!(
            "  board's clock {:+.1} ppm against the host's (sigma {:.1}), arrivals {:.2} ms late with {:.2} ms rms",
            clock.device_fast_ppm,
            clock.sigma_ppm,
            clock.mean_delay_s * 1e3,
            clock.residual_rms_s * 1e3
        ));
    }
    if let Some(rpm) = statistics.steady_rpm {
        lines.push(format!("  steady speed {rpm:.2} RPM"));
    }
    lines.join("\n")
}
