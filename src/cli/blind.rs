//! `motorlab blind`: cases whose cause is sealed, verdicts on them, and the score.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::{fs, io, thread};

use clap::{Args, Subcommand};
use rayon::prelude::*;
use serde::Serialize;

use super::motor_file::motor_file;
use super::output_file::{Force, Form};
use super::progress::bar;
use super::signals::StopSignal;
use super::threads::Threads;
use super::{Failure, Output, Status};
use crate::blind::{
    self, BlindError, Ledger, Manifest, NewCase, Program, Recipe, Truth, add_cases, judge,
    measure_gap,
};
use crate::hint::In;
use crate::motor::Motor;
use crate::plain::shown;
use crate::recording::read_run;

/// Check diagnoses on cases whose cause is sealed: make or seal cases, run, then score.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab blind make --cases 100 set --labels away/labels.json\n  motorlab blind run set\n  motorlab blind score set --labels away/labels.json --html score.html\n\n  motorlab blind seal heavy1.csv heavy2.csv --motor motor.toml --label inertia --into exercise"
)]
pub struct Blind {
    #[command(subcommand)]
    step: Step,
}

#[derive(Debug, Subcommand)]
enum Step {
    Make(Make),
    Seal(Seal),
    Run(Run),
    Score(Score),
}

/// Make cases of simulated motors and seal their causes.
#[derive(Debug, Args)]
struct Make {
    /// Directory of the set.
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// How many cases.
    #[arg(long, default_value_t = 100)]
    cases: usize,
    /// Seed of all of them (it gives every label away; below 1000000: for tuning). [default: drawn]
    #[arg(long)]
    seed: Option<u64>,
    /// mixed, singles, pairs, none, outside, an effect's id, or two joined by +.
    #[arg(long, default_value = "mixed")]
    kind: String,
    /// Many kinds of bench: four families of motors, seven protocols (one plain step among them), 1 to 30 ms, and up to three
    /// effects.
    #[arg(long, conflicts_with_all = ["kind", "other_motors", "random_load"])]
    breadth: bool,
    /// Motors unlike the lab handout's.
    #[arg(long)]
    other_motors: bool,
    /// Factor on the random torque of load and friction.
    #[arg(long, alias = "wander", default_value_t = 1.0, value_name = "FACTOR")]
    random_load: f64,
    /// File for the labels, outside the set. [default: DIR.labels.json]
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
}

/// Seal recorded runs whose cause you arranged, as one case of a set.
#[derive(Debug, Args)]
struct Seal {
    /// Run files, all of one motor.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Motor file as it was before anything was arranged; without it the lab handout's motor.
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
    /// Arranged cause: none, an effect's id, several joined by +, or outside:WORDS.
    #[arg(long)]
    label: String,
    /// Another run of the same motor, held out from the diagnosis, to check its claimed error.
    #[arg(long, value_name = "RUN")]
    unseen: Option<PathBuf>,
    /// Directory of the set, new or begun.
    #[arg(long, value_name = "DIR", default_value = "sealed")]
    into: PathBuf,
    /// File for the labels, outside the set. [default: DIR.labels.json]
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
}

/// Diagnose every case that has no verdict yet; continues where it was stopped.
#[derive(Debug, Args)]
struct Run {
    /// Directory of the set.
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Cases at a time. [default: one a thread]
    #[arg(long)]
    jobs: Option<usize>,
    /// Another program that keeps the contract of `motorlab diagnose`, started in a folder with copies of a case and
    /// nothing else; its --version in an empty one, for a minute at most. [default: this one]
    #[arg(long, value_name = "PROGRAM")]
    diagnoser: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
}

/// Open the labels and score the verdicts; refuses where anything was changed.
#[derive(Debug, Args)]
struct Score {
    /// Directory of the set.
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// The labels.
    #[arg(long, value_name = "FILE")]
    labels: PathBuf,
    /// Hash of the verdicts as `blind run` printed it and you wrote it down; without it the order of verdicts and labels is
    /// not proved, and the score says so.
    #[arg(long, value_name = "HASH")]
    head: Option<String>,
    /// Write everything as one HTML file that needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write everything in Markdown, for a document.
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

impl Blind {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        match &self.step {
            Step::Make(make) => make.run(output),
            Step::Seal(seal) => seal.run(output),
            Step::Run(run) => run.run(output),
            Step::Score(score) => score.run(output),
        }
    }
}

#[derive(Debug, Serialize)]
struct Sealed<'a> {
    shape: &'static str,
    directory: &'a Path,
    labels: &'a Path,
    cases: usize,
}

impl Sealed<'_> {
    fn say(&self, output: &Output) -> Result<Status, Failure> {
        let labels = shown(self.labels);
        if output.json {
            output.document(self)?;
        } else {
            output.line(&format!(
                "{} cases in {}; labels in {labels}: keep that file from whoever diagnoses",
                self.cases,
                shown(self.directory)
            ))?;
        }
        Ok(Status::Done)
    }
}

impl Make {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        if !(self.random_load.is_finite() && self.random_load >= 0.0) {
            return Err(Failure::wrong(
                format!("--random-load {}: expected 0 or more", self.random_load),
                "--random-load 1 is the usual random load torque, 0 is none",
            ));
        }
        let labels = labels_path(&self.directory, self.labels.as_deref());
        if self.directory.join("manifest.json").exists() {
            return Err(Failure::wrong(
                format!("{} is a set already", shown(&self.directory)),
                "name another directory",
            ));
        }
        let recipe = Recipe {
            cases: self.cases,
            seed: match self.seed {
                Some(seed) => seed,
                None => blind::drawn_seed().map_err(failure)?,
            },
            kind: if self.breadth {
                blind::BREADTH.to_owned()
            } else {
                self.kind.clone()
            },
            other_motors: self.other_motors,
            random_torque_scale: self.random_load,
        };
        let bar = bar(self.cases, "made");
        let cases = blind::make(&recipe, &|| bar.inc(1)).map_err(Failure::input)?;
        bar.finish_and_clear();
        let manifest = add_cases(&self.directory, &labels, Some(recipe), cases).map_err(failure)?;
        Sealed {
            shape: "motorlab-blind-sealed/1",
            directory: &self.directory,
            labels: &labels,
            cases: manifest.cases.len(),
        }
        .say(output)
    }
}

impl Seal {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        let truth = Truth::from_words(&self.label).map_err(Failure::input)?;
        // A file that no diagnosis can read must not be sealed.
        for path in self.runs.iter().chain(&self.unseen) {
            read_run(path).map_err(Failure::input)?;
        }
        if let Some(path) = &self.motor {
            motor_file(path, output)?;
        }
        let text = |path: &PathBuf| {
            fs::read_to_string(path).map_err(|error| Failure::input(In::new(shown(path), error)))
        };
        let case = NewCase {
            runs: self.runs.iter().map(text).collect::<Result<_, _>>()?,
            motor: match &self.motor {
                Some(path) => text(path)?,
                None => Motor::default().to_toml(),
            },
            unseen: self.unseen.as_ref().map(text).transpose()?,
            truth,
        };
        let labels = labels_path(&self.into, self.labels.as_deref());
        let manifest = add_cases(&self.into, &labels, None, [case]).map_err(failure)?;
        output.message(
            "the runs are copied as they are: see that no header or name in them tells the cause",
        );
        Sealed {
            shape: "motorlab-blind-sealed/1",
            directory: &self.into,
            labels: &labels,
            cases: manifest.cases.len(),
        }
        .say(output)
    }
}

#[derive(Debug, Serialize)]
struct JudgedSet<'a> {
    shape: &'static str,
    directory: &'a Path,
    cases: usize,
    verdicts: usize,
    failed: u64,
    head: &'a str,
}

impl Run {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        let cores = || thread::available_parallelism().map_or(1, usize::from);
        let cores = self.threads.count().unwrap_or_else(cores);
        let jobs = self.jobs.unwrap_or(cores).max(1);
        let program = match &self.diagnoser {
            Some(program) => program.clone(),
            None => std::env::current_exe().map_err(Failure::device)?,
        };
        let program = Program::new(&program, cores.div_ceil(jobs)).map_err(failure)?;
        let cases = Manifest::read(&self.directory)
            .map_err(failure)?
            .cases
            .len();
        let (stop, _runtime) = stop_flag().map_err(Failure::device)?;
        let bar = bar(cases, "judged");
        let failed = AtomicU64::new(0);
        let ledger = blind::run(&self.directory, &program, jobs, &stop, &|progress| {
            bar.set_position(progress.done as u64);
            failed.store(progress.failed as u64, Ordering::Relaxed);
        });
        bar.finish_and_clear();
        self.say(
            &ledger.map_err(failure)?,
            cases,
            failed.into_inner(),
            output,
        )
    }

    fn say(
        &self,
        ledger: &Ledger,
        cases: usize,
        failed: u64,
        output: &Output,
    ) -> Result<Status, Failure> {
        let verdicts = ledger.entries.len();
        let head = ledger.head();
        if output.json {
            output.document(&JudgedSet {
                shape: "motorlab-blind-run/1",
                directory: &self.directory,
                cases,
                verdicts,
                failed,
                head,
            })?;
        } else {
            output.line(&format!(
                "{verdicts} of {cases} cases judged; hash of all verdicts, to be written down before the \
                 labels are opened:\n{head}"
            ))?;
        }
        if failed > 0 {
            output.message(&format!(
                "{failed} diagnoses failed; verdicts/*.json says why"
            ));
        }
        if verdicts < cases {
            output.message("stopped; the same command continues from here");
            return Ok(Status::FellShort);
        }
        Ok(if failed > 0 {
            Status::FellShort
        } else {
            Status::Done
        })
    }
}

impl Score {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        let inputs = [&self.labels, &self.directory.join("manifest.json")];
        let outputs = self.force.outputs("blind score", inputs);
        outputs.check(self.html.iter().chain(&self.markdown))?;
        let opened =
            blind::open(&self.directory, &self.labels, self.head.as_deref()).map_err(failure)?;
        let bar = bar(opened.cases.len(), "unseen runs");
        let judged = opened.cases.par_iter().map(|case| {
            let gap = measure_gap(&self.directory, case)?;
            bar.inc(1);
            Ok(judge(case, gap))
        });
        let judged: Result<Vec<_>, BlindError> = judged.collect();
        bar.finish_and_clear();
        let score = blind::score(&opened, judged.map_err(failure)?);
        if self.head.is_none() {
            output.message(blind::ORDER_UNPROVED);
        }
        let files = [
            (&self.html, blind::page as fn(&blind::Score) -> String),
            (&self.markdown, blind::markdown),
        ];
        for (path, form) in files {
            if let Some(path) = path {
                outputs.write(path, &form(&score), Form::Markup, output)?;
            }
        }
        if output.json {
            output.document(&score)?;
        } else {
            output.line(&blind::text(&score))?;
        }
        Ok(if score.failed > 0 {
            Status::FellShort
        } else {
            Status::Done
        })
    }
}

/// The labels' file as given, or beside the set.
fn labels_path(directory: &Path, given: Option<&Path>) -> PathBuf {
    given.map_or_else(
        || {
            let mut name = directory.file_name().unwrap_or_default().to_owned();
            name.push(".labels.json");
            directory.with_file_name(name)
        },
        Path::to_owned,
    )
}

fn failure(error: BlindError) -> Failure {
    if error.is_of_the_system() {
        Failure::device(error)
    } else {
        Failure::input(error)
    }
}

/// A flag that Ctrl-C sets, as long as the runtime lives.
fn stop_flag() -> io::Result<(Arc<AtomicBool>, tokio::runtime::Runtime)> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()?;
    let flag = Arc::new(AtomicBool::new(false));
    let signal = runtime.block_on(async { StopSignal::install() })?;
    runtime.spawn({
        let flag = Arc::clone(&flag);
        async move {
            signal.asked().await;
            flag.store(true, Ordering::Relaxed);
        }
    });
    Ok((flag, runtime))
}
