//! Findings about a recording itself, before any diagnosis.
//!
//! Input: runs and, if given, the motor file. Output: findings, each with its figures and its remedy (a flag, a key
//! of the mapping, a wire). Each kind is one file with one function and a row of the table `KINDS`. Findings that an
//! effect of the catalogue can model are never fatal.
//!
//! ```
//! use motorlab::check::{Kind, Severity, check};
//! use motorlab::recording::Run;
//!
//! let run = Run {
//!     t_s: vec![0.0, 0.003],
//!     command: vec![4.5, 4.5],
//!     counts: vec![0, 1],
//!     ..Run::default()
//! };
//! let findings = check(&[run], None);
//! assert_eq!(findings[0].id, Kind::TooShort);
//! assert_eq!(findings[0].severity, Severity::Fatal);
//! ```

use std::ops::Range;

mod channel_stuck;
mod clock_rate;
mod command_beyond_supply;
mod command_constant;
mod command_offset;
mod counter_reset;
mod counter_wrap;
mod counts_scale;
mod dead_time;
mod dither_at_rest;
mod edges_lost;
mod encoder_reversed;
mod finding;
mod gain;
mod gap_in_time;
pub(crate) mod host_clock;
mod kept_speed;
mod loss_in_one_direction;
mod misread_position;
mod moving_average;
mod named_samples;
mod off_under_command;
mod random_loss;
mod response;
mod sample_time;
mod speed_between_edges;
mod stale_rows;
mod starts_in_motion;
mod step_response;
mod subject;
mod supply_varies;
mod time_unit;
mod too_short;
mod words;
mod zero_speeds;

pub use finding::{Finding, Kind, Severity, fatal_of, is_fatal};
pub(crate) use kept_speed::{KeptSpeed, SPEED_KEPT, SpeedRow};
pub use named_samples::samples_named_by_check;
pub(crate) use named_samples::{misread_or_stale, off_under_command};
use subject::Subject;
pub(crate) use too_short::FEWEST_SAMPLES;
pub(crate) use zero_speeds::{SPEED_ZERO, ZeroSpeeds};

use crate::motor::Motor;
use crate::recording::Run;

type Find = fn(&Subject<'_>) -> Vec<Finding>;

/// Every kind of finding of one run; findings of the same severity are listed in this order.
const KINDS: &[Find] = &[
    channel_stuck::find,
    counts_scale::find,
    time_unit::find,
    counter_wrap::find,
    counter_reset::find,
    speed_between_edges::find,
    misread_position::find,
    stale_rows::find,
    off_under_command::find,
    loss_in_one_direction::find,
    moving_average::find,
    gap_in_time::find,
    sample_time::find,
    clock_rate::find,
    command_beyond_supply::find,
    command_constant::find,
    command_offset::find,
    dither_at_rest::find,
    supply_varies::find,
    starts_in_motion::find,
];

type FindAmong = fn(&[Subject<'_>]) -> Vec<Finding>;

/// Every kind of finding that compares runs of one motor; listed first among findings of the same severity.
const AMONG_RUNS: &[FindAmong] = &[encoder_reversed::find, edges_lost::find];

/// All findings of these runs of one motor, the most severe first; with the motor file where there is one.
pub fn check(runs: &[Run], motor: Option<&Motor>) -> Vec<Finding> {
    check_training(runs, std::slice::from_ref(&(0..runs.len())), motor)
}

/// As [`check`], with the requirement that the shaft moves in each of these ranges of runs (training data).
pub fn check_training(
    runs: &[Run],
    training: &[Range<usize>],
    motor: Option<&Motor>,
) -> Vec<Finding> {
    let names: Vec<String> = (runs.iter().enumerate())
        .map(|(k, run)| match &run.path {
            Some(path) => path.display().to_string(),
            None => (k + 1).to_string(),
        })
        .collect();
    let subjects: Vec<Subject<'_>> = (runs.iter().zip(&names))
        .map(|(run, name)| Subject { run, name, motor })
        .collect();
    // With a few samples nothing else can be determined.
    let each = subjects
        .iter()
        .flat_map(|subject| match too_short::find(subject) {
            short if short.is_empty() => KINDS.iter().flat_map(|find| find(subject)).collect(),
            short => short,
        });
    let among = AMONG_RUNS.iter().flat_map(|find| find(&subjects));
    let still = (training.iter()).flat_map(|runs| too_short::find_among(&subjects[runs.clone()]));
    let mut findings: Vec<Finding> = among.chain(still).chain(each).collect();
    // A constant command is worth a note only where no other run has another level.
    let levels = || runs.iter().flat_map(|run| &run.command);
    if levels().zip(levels().skip(1)).any(|(a, b)| a != b) {
        let is_note = |finding: &Finding| finding.severity == Severity::Note;
        findings.retain(|finding| finding.id != Kind::CommandConstant || !is_note(finding));
    }
    findings.sort_by_key(|finding| finding.severity);
    findings
}
