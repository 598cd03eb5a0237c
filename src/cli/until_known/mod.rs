//! `motorlab capture --until-known`: records, diagnoses and records the proposed experiment until the cause is known.

mod bench;
mod bound;
mod plan;
mod report;

use std::path::{Path, PathBuf};

use clap::Args;

use super::capture::Capture;
use super::capture_report::ending_error;
use super::findings::listed;
use super::foreign::unreadable;
use super::motor_file::motor_file;
use super::progress::{set_share, spinner};
use super::signals::StopSignal;
use super::{Failure, Output, Status};
use crate::board::Profile;
use crate::check::{Finding, Severity, check, is_fatal};
use crate::diagnose::{Diagnosis, NominalSource, Options, diagnose};
use crate::motor::Motor;
use crate::plain::shown;
use crate::recording::{Captured, Ending, Run, read_run};
use bench::Bench;
use bound::Bound;
use plan::{Next, Plan};
use report::{Ended, Round, SessionResult, command_line, round_line};

/// Default duration of each recording in s.
const ROUND_S: f64 = 15.0;
/// First profile: of all built-in profiles it hides and ties the fewest effects (`motorlab design`, 15 s at 10 ms),
/// except `jog`, whose first diagnoses name fewer.
const FIRST: &str = "brakes";
/// Highest number of a run's file.
const MOST_NAMES: usize = 9999;

/// Options of the loop.
#[derive(Debug, Clone, Args)]
pub(super) struct UntilKnown {
    /// Record, diagnose, and record what the diagnosis proposes, until the cause of the error is known; no longer than so many
    /// seconds of recording in all (60s), or so many recordings (4). The runs are run-1.csv, run-2.csv ... by the name
    /// after -o. Each lasts --duration, else as long as the profile's file or name says, else 15 s.
    #[arg(long = "until-known", value_name = "SECONDSs|COUNT", value_parser = Bound::parse, group = "simulating",
        conflicts_with_all = ["columns", "reconnect", "log"])]
    bound: Option<Bound>,
}

impl UntilKnown {
    pub(super) fn bound(&self) -> Option<Bound> {
        self.bound
    }
}

struct Session<'a> {
    asked: &'a Capture,
    bound: Bound,
    motor: Motor,
    plans: Vec<Plan>,
    rounds: Vec<Round>,
    runs: Vec<Run>,
    findings: Vec<Finding>,
    found: Option<Diagnosis>,
}

/// Records and diagnoses until the cause is known, the bound is reached, or Ctrl-C.
pub(super) async fn until_known(
    asked: &Capture,
    bound: Bound,
    output: &Output,
) -> Result<Status, Failure> {
    let first = first_plan(asked)?;
    if !bound.allows(0, 0.0, first.duration_s) {
        return Err(Failure::wrong(
            format!(
                "--until-known: {} is less than one recording of {} s",
                bound.words(),
                first.duration_s
            ),
            "raise the bound of --until-known, or lower --duration",
        ));
    }
    let motor = match &asked.motor {
        Some(path) => motor_file(path, output)?,
        None => {
            output.message("no --motor: the runs are compared with the lab handout's motor");
            Motor::default()
        }
    };
    let stop = StopSignal::install().map_err(Failure::device)?;
    let mut session = Session {
        asked,
        bound,
        motor,
        plans: Vec::new(),
        rounds: Vec::new(),
        runs: Vec::new(),
        findings: Vec::new(),
        found: None,
    };
    let ended = session.continue_rounds(first, &stop, output).await;
    if ended.is_err() && !session.rounds.is_empty() {
        output.message(&format!(
            "what was recorded is kept: {}",
            command_line(&session.rounds, asked.motor.as_ref())
        ));
    }
    session.reached(ended?).say(output)
}

fn first_plan(asked: &Capture) -> Result<Plan, Failure> {
    let profile = asked.profile.clone().unwrap_or_else(|| FIRST.to_owned());
    let supply_v = Motor::default().parameters.supply_v;
    let played = Profile::named(&profile, supply_v, ROUND_S).map_err(Failure::input)?;
    let duration_s = asked.duration.unwrap_or_else(|| played.duration_s());
    if duration_s == 0.0 {
        return Err(Failure::wrong(
            "--until-known: each recording needs an end",
            "give a --duration above 0, such as --duration 6",
        ));
    }
    Ok(Plan {
        profile,
        duration_s,
        change: None,
        why: String::new(),
    })
}

impl Session<'_> {
    async fn continue_rounds(
        &mut self,
        first: Plan,
        stop: &StopSignal,
        output: &Output,
    ) -> Result<Ended, Failure> {
        let mut bench = Bench::of(self.asked);
        let names = free_names(&self.asked.output, output);
        let mut plan = first;
        loop {
            let file = numbered(&self.asked.output, names + self.rounds.len());
            output.message(&format!("recording {}: {}", shown(&file), plan.profile));
            let Some(captured) = bench.record(&plan, file, stop, output).await? else {
                return Ok(Ended::Stopped);
            };
            self.add_run(&plan, &captured)?;
            if captured.ending == Ending::Stopped {
                return Ok(Ended::Stopped);
            }
            if let Some(ending_error) = ending_error(captured.ending) {
                return Err(Failure::device(ending_error).at(&captured.path));
            }
            if !self.is_sound(output) {
                return Ok(Ended::BadRecording);
            }
            let Some(found) = self.diagnosed(stop).await? else {
                return Ok(Ended::Stopped);
            };
            let next = plan::next(&found, &self.plans, bench.changes_itself());
            self.report_round(&found, &next, output)?;
            self.found = Some(found);
            plan = match next {
                Next::Nothing => return Ok(Ended::Known),
                Next::ByHand => return Ok(Ended::ByHand),
                Next::Record(plan) => plan,
            };
            if !(self.bound).allows(self.rounds.len(), self.planned_s(), plan.duration_s) {
                return Ok(Ended::Bound);
            }
        }
    }

    /// Reads the run back, so that the diagnosis is that of the files.
    fn add_run(&mut self, plan: &Plan, captured: &Captured) -> Result<(), Failure> {
        self.rounds.push(Round::of(plan, captured));
        self.plans.push(plan.clone());
        if captured.statistics.samples > 0 {
            let read = read_run(&captured.path);
            let (run, _) = read.map_err(|error| unreadable(&captured.path, error))?;
            self.runs.push(run);
        }
        Ok(())
    }

    /// Whether there is no fatal finding; prints fatal findings, and warnings of the latest run.
    fn is_sound(&mut self, output: &Output) -> bool {
        let given = self.asked.motor.is_some().then_some(&self.motor);
        self.findings = check(&self.runs, given);
        let latest =
            (self.rounds.last()).map_or(String::new(), |round| round.path().display().to_string());
        let shown = self.findings.iter().filter(|finding| {
            finding.severity == Severity::Fatal
                || (finding.severity == Severity::Warning && finding.run == latest)
        });
        let shown: Vec<Finding> = shown.cloned().collect();
        for text in listed(&shown, false) {
            output.message(&text);
        }
        !is_fatal(&self.findings)
    }

    async fn diagnosed(&self, stop: &StopSignal) -> Result<Option<Diagnosis>, Failure> {
        let shown = spinner();
        let (runs, motor) = (self.runs.clone(), self.motor.clone());
        let asked = command_line(&self.rounds, self.asked.motor.as_ref());
        let nominal_source = match self.asked.motor {
            Some(_) => NominalSource::Given,
            None => NominalSource::Handout,
        };
        let bar = shown.clone();
        let computing = tokio::task::spawn_blocking(move || {
            let progress = |what: &str| bar.set_message(what.to_owned());
            let done = |share: f64| set_share(&bar, share);
            let options = Options {
                nominal_source,
                asked: Some(&asked),
                progress: &progress,
                done: &done,
                ..Options::default()
            };
            diagnose(&runs, &motor, &options)
        });
        let found = tokio::select! {
            found = computing => Some(found.map_err(Failure::device)?.map_err(Failure::input)?),
            () = stop.clone().asked() => None,
        };
        shown.finish_and_clear();
        Ok(found)
    }

    fn report_round(
        &mut self,
        found: &Diagnosis,
        next: &Next,
        output: &Output,
    ) -> Result<(), Failure> {
        let number = self.rounds.len();
        let Some(round) = self.rounds.last_mut() else {
            return Ok(());
        };
        round.diagnosed(found);
        round.then(next);
        let line = round_line(number, round, found, next);
        if output.json {
            output.message(&line);
            return Ok(());
        }
        output.line(&line)
    }

    fn planned_s(&self) -> f64 {
        self.plans.iter().map(|plan| plan.duration_s).sum()
    }

    fn reached(&self, ended: Ended) -> SessionResult<'_> {
        SessionResult {
            ended,
            bound: self.bound,
            rounds: &self.rounds,
            found: self.found.as_ref(),
            findings: &self.findings,
            diagnose: command_line(&self.rounds, self.asked.motor.as_ref()),
        }
    }
}

/// `run-3.csv` for `run.csv`.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("-{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// The number of the first run: after all existing ones, so that the runs of one call are consecutive.
fn free_names(path: &Path, output: &Output) -> usize {
    let is_taken = |number: &usize| numbered(path, *number).symlink_metadata().is_ok();
    let first = 1 + (1..=MOST_NAMES).rfind(is_taken).unwrap_or(0);
    if first > 1 {
        output.message(&format!(
            "{} exists and stays as it is; recording from {} on",
            shown(numbered(path, first - 1)),
            shown(numbered(path, first))
        ));
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_numbered_before_the_extension() {
        assert_eq!(
            numbered(Path::new("a/run.csv"), 2),
            Path::new("a/run-2.csv")
        );
        assert_eq!(numbered(Path::new("run"), 1), Path::new("run-1"));
    }
}
