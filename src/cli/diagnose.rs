//! `motorlab diagnose`: error budget, causes with probabilities, next experiment.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::diagnose_text::{explain, nominal_fit_words, show};
use super::findings::print_findings;
use super::foreign::{read_runs, refuse_unused};
use super::import_flags::Flags;
use super::known::With;
use super::motor_choice::MotorChoice;
use super::numbers::good_enough;
use super::output_file::{Force, Form};
use super::progress::{set_share, spinner};
use super::threads::Threads;
use super::{Failure, Output, Status};
use crate::check::{Finding, check_training, is_fatal};
use crate::diagnose::{
    BadRecording, GoodEnough, NominalSource, Options, Role, RunFacts, Settings, WithRuns, diagnose,
    nominal_fit,
};
use crate::hint::In;
use crate::motor::{Motor, read_motor};
use crate::plain::{quoted, shown};
use crate::recording::Run;
use crate::report::diagnosis::{bad_recording_page, page_held_out};

/// Diagnose the error between recording and simulation: how large, by which effects, what is unexplained, what to record next.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab diagnose step3.csv reversing.csv --motor motor.toml\n  motorlab diagnose run.csv --model-out diagnosed.toml --html why.html\n  motorlab diagnose a.csv b.csv --hold-out c.csv --motor motor.toml --json\n  motorlab diagnose run.csv --nominal fit\n  motorlab diagnose bare.csv disc.csv --with disc.csv:inertia_added_kg_m2=0.001\n  motorlab diagnose run.csv --good-enough 1% --explain\n  motorlab diagnose today.csv --reference march1.csv march2.csv --motor motor.toml\n  motorlab diagnose a.csv b.csv c.csv --repeats a.csv,b.csv"
)]
pub struct Diagnose {
    /// Run files of the same motor: other sample times and profiles determine more parameters. A log of another program is imported on the way.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Held-out runs: nothing is fitted to them and nothing is chosen by them; the error budget is measured on them.
    #[arg(long, value_name = "RUN", num_args = 1..)]
    hold_out: Vec<PathBuf>,
    /// Earlier runs of the same axis, or runs of another rig of its kind: the diagnosis is of what has changed since, with the motor
    /// identified from them in place of the motor file's.
    #[arg(long, value_name = "RUN", num_args = 1..)]
    reference: Vec<PathBuf>,
    /// Runs that repeat each other, beside those that have the same commands: their differences are part of the noise floor. May be given again.
    #[arg(long, value_name = "RUN,RUN", value_parser = repeating)]
    repeats: Vec<Repeating>,
    /// The nominal model: the motor file, or a fit of the model without effects to these runs. [default: the motor file;
    /// without one, fit for imported runs and text boards, else the lab handout's motor]
    #[arg(long, value_enum)]
    nominal: Option<Nominal>,
    #[command(flatten)]
    motor: MotorChoice,
    #[command(flatten)]
    with: With,
    /// Position error that is good enough: counts, or a share of the travel as in 1%; a part of the noise floor.
    #[arg(long, value_name = "COUNTS|SHARE%", value_parser = good_enough)]
    good_enough: Option<GoodEnough>,
    /// A quick answer from a tenth of the samples: whole segments, with every run and every command level among them. The errors are those
    /// of all samples; sentence, page and document say that the answer is quick.
    #[arg(long)]
    quick: bool,
    /// Print how the verdict came about: the steps of the search, all sets with their scores, the effective observations.
    #[arg(long)]
    explain: bool,
    /// A motor file whose set of effects is fitted in any case, from its values: what would this cause explain? May be given again.
    #[arg(long, value_name = "MOTOR.toml")]
    propose: Vec<PathBuf>,
    /// Numbers of the method that differ from their defaults, as TOML; docs/method/diagnosis.md lists them.
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Diagnose recordings with a fatal finding too (motorlab check); the diagnosis is marked.
    #[arg(long)]
    despite_findings: bool,
    /// Write the motor file of the verdict, for the commands simulate and compare.
    #[arg(long, value_name = "FILE")]
    model_out: Option<PathBuf>,
    /// Write everything as one HTML file that needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    log: Flags,
}

fn settings(path: &Path) -> Result<Settings, Failure> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::input(In::new(shown(path), error)))?;
    toml::from_str(&text).map_err(|error| {
        Failure::wrong(
            format!("{}: {}", shown(path), error.to_string().trim_end()),
            "docs/method/diagnosis.md links to the list of settings; without --settings the defaults hold",
        )
    })
}

/// Source of the nominal model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Nominal {
    /// The motor file, or the lab handout's motor.
    File,
    /// The model without effects, fitted to the runs: for a motor without known parameters.
    Fit,
}

impl Diagnose {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        let paths = || {
            (self.runs.iter())
                .chain(&self.hold_out)
                .chain(&self.reference)
        };
        let outputs = (self.force).outputs("diagnose", paths().chain(self.motor.file()));
        outputs.check(self.html.iter().chain(&self.model_out))?;
        let mut motor = self.motor.motor_without_message(output)?;
        self.with.refuse_others(paths().map(PathBuf::as_path))?;
        self.refuse_fitted_twice()?;
        let repeats = self.repeating()?;
        let mut runs = self.read(&self.runs, output)?;
        // Held-out motion does not make runs without motion usable.
        let held_from = runs.len();
        runs.extend(self.read(&self.hold_out, output)?);
        let reference_from = runs.len();
        runs.extend(self.read(&self.reference, output)?);
        refuse_unused(&self.log, &runs, output)?;
        refuse_copies(&runs[..held_from], &runs[held_from..reference_from])?;
        if held_from != self.runs.len() && !repeats.is_empty() {
            return Err(Failure::wrong(
                "--repeats names files, and a log among them holds several runs",
                "`motorlab import LOG` makes a run file of each; give those to --repeats",
            ));
        }
        let training = [0..held_from, reference_from..runs.len()];
        let given = self.motor.is_given().then_some(&motor);
        let findings = print_findings(check_training(&runs, &training, given), output);
        let reference = runs.split_off(reference_from);
        let held_out = runs.split_off(held_from);
        let facts = RunFacts::of([
            (Role::Diagnosed, &runs),
            (Role::HoldOut, &held_out),
            (Role::Reference, &reference),
        ]);
        let is_bad = is_fatal(&findings);
        if is_bad && !self.despite_findings {
            if let Some(path) = &self.html {
                let page = bad_recording_page(&findings, &runs);
                outputs.write(path, &page, Form::Markup, output)?;
            }
            if let Some(path) = &self.model_out {
                output.message(&format!("{}: not written, nothing is fitted", shown(path)));
            }
            return bad_recording(findings, &facts, output);
        }
        let settings =
            (self.settings.as_deref()).map_or_else(|| Ok(Settings::default()), settings)?;
        // With reference runs, the motor file or its fit applies to the reference.
        let first = if reference.is_empty() {
            &runs
        } else {
            &reference
        };
        let mut nominal_source = match self.motor.is_given() {
            true => NominalSource::Given,
            false => NominalSource::Handout,
        };
        if self.is_fitted(first) {
            let fit = nominal_fit(first, &motor, &settings).map_err(Failure::input)?;
            output.message(&nominal_fit_words(&fit));
            if !fit.is_given {
                nominal_source = NominalSource::Fit;
            }
            motor = fit.motor;
        } else if reference.is_empty() || self.motor.is_given() {
            self.motor.print_default(output);
        } else {
            output.message("no --motor: the nominal model is fitted to the reference runs, with R and Kt of the lab handout's motor");
        }
        let proposed: Vec<Motor> = (self.propose.iter())
            .map(|path| read_motor(path).map_err(Failure::input))
            .collect::<Result<_, _>>()?;
        let spinner = spinner();
        let progress = |what: &str| spinner.set_message(what.to_owned());
        let done = |share: f64| set_share(&spinner, share);
        let options = Options {
            held_out: &held_out,
            reference: &reference,
            repeats: &repeats,
            good_enough: self.good_enough,
            is_doubtful: is_bad,
            nominal_source,
            asked: Some(&output.asked),
            proposed: &proposed,
            settings,
            progress: &progress,
            done: &done,
            quick: self.quick,
        };
        let found = diagnose(&runs, &motor, &options);
        spinner.finish_and_clear();
        let mut diagnosis = found.map_err(Failure::input)?;
        diagnosis.set_findings(findings);
        let known = &diagnosis.identifiable;
        // With a voltage command, torques are known only from the motor file or a known load.
        diagnosis.model.resistance_assumed =
            known.si.is_none() && known.electrical_time_constant_s.is_some();
        diagnosis.rewrite_next(|next| self.next_after(next));
        if let Some(path) = &self.model_out {
            outputs.write(path, &diagnosis.model.to_toml(), Form::Toml, output)?;
        }
        if let Some(path) = &self.html {
            let title = match reference.is_empty() {
                true => format!("Diagnosis of the sim-to-real gap ({})", self.motor.words()),
                false => "Diagnosis of the change since the reference".to_owned(),
            };
            let page =
                page_held_out(&diagnosis, &runs, &held_out, &title).map_err(Failure::input)?;
            outputs.write(path, &page, Form::Markup, output)?;
        }
        if output.json {
            output.document(&WithRuns::new(&diagnosis, &facts))?;
        } else {
            let recorded = if held_out.is_empty() {
                &runs
            } else {
                &held_out
            };
            show(&diagnosis, recorded, output)?;
            if self.explain {
                explain(&diagnosis, output)?;
            }
            if self.html.is_none() {
                output.message("a page with the pictures: add --html diagnosis.html");
            }
        }
        Ok(Status::Done)
    }
}

impl Diagnose {
    /// The next step, unless this call has just done the proposed one.
    fn next_after(&self, next: &str) -> Option<String> {
        let before = &next[..next.find("Next, ")?];
        let path = match (&self.model_out, &self.html) {
            (Some(path), _) if next.contains(" --model-out ") => path,
            (_, Some(_)) if next.contains(" --html ") => {
                return Some(format!(
                    "{before}Next, see on the page where the error lies, and the recorded and simulated curves."
                ));
            }
            _ => return None,
        };
        Some(format!(
            "{before}Next, simulate with the motor that was written: `motorlab simulate --motor {}`.",
            quoted(&path.to_string_lossy())
        ))
    }

    /// A run that is fitted cannot be held out as well.
    fn refuse_fitted_twice(&self) -> Result<(), Failure> {
        let place = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
        let fitted: Vec<PathBuf> = self.runs.iter().map(place).collect();
        let twice = self
            .hold_out
            .iter()
            .find(|path| fitted.contains(&place(path)));
        match twice {
            None => Ok(()),
            Some(path) => Err(Failure::wrong(
                format!(
                    "--hold-out {}: it is diagnosed too, so it would not test the fit",
                    shown(path)
                ),
                format!(
                    "hold out another run, or leave {} out of the runs that are diagnosed",
                    shown(path)
                ),
            )),
        }
    }

    /// Reads run files and logs; notes go to standard error.
    fn read(&self, paths: &[PathBuf], output: &Output) -> Result<Vec<Run>, Failure> {
        let mut runs = Vec::new();
        for path in paths {
            for (mut run, notes) in read_runs(path, &self.log, output)? {
                self.with.apply(path, &mut run)?;
                for note in notes {
                    output.message(&format!("{}: {note}", shown(path)));
                }
                runs.push(run);
            }
        }
        Ok(runs)
    }

    /// Indices of the runs declared as repetitions.
    fn repeating(&self) -> Result<Vec<Vec<usize>>, Failure> {
        let number = |path: &PathBuf| {
            let found = self.runs.iter().position(|run| run == path);
            found.ok_or_else(|| {
                Failure::wrong(
                    format!(
                        "--repeats {}: not among the runs that are diagnosed",
                        shown(path)
                    ),
                    format!(
                        "name it as the run itself, such as {}",
                        shown(&self.runs[0])
                    ),
                )
            })
        };
        let groups = self
            .repeats
            .iter()
            .map(|group| group.0.iter().map(number).collect());
        groups.collect()
    }

    /// Whether the nominal motor is fitted to the runs: on request, or for a foreign log without a motor file.
    fn is_fitted(&self, runs: &[Run]) -> bool {
        match self.nominal {
            Some(nominal) => nominal == Nominal::Fit,
            None => !self.motor.is_given() && runs.iter().any(Run::is_foreign),
        }
    }
}

/// Runs declared as repetitions.
#[derive(Debug, Clone)]
struct Repeating(Vec<PathBuf>);

fn repeating(text: &str) -> Result<Repeating, String> {
    let paths: Vec<PathBuf> = (text.split(',').filter(|path| !path.is_empty()))
        .map(PathBuf::from)
        .collect();
    match paths.len() {
        0 | 1 => Err(
            "expected two runs or more\nhint: with a comma between, as in --repeats a.csv,b.csv"
                .to_owned(),
        ),
        _ => Ok(Repeating(paths)),
    }
}

/// Ends a diagnosis before the fit because of a fatal finding.
fn bad_recording(
    findings: Vec<Finding>,
    facts: &[RunFacts],
    output: &Output,
) -> Result<Status, Failure> {
    let document = BadRecording::of(findings);
    if output.json {
        output.document(&WithRuns::new(&document, facts))?;
    } else {
        output.line(&document.sentence)?;
    }
    Ok(Status::FellShort)
}

/// Copies of a fitted run cannot be held out either, whatever their name.
fn refuse_copies(fitted: &[Run], held_out: &[Run]) -> Result<(), Failure> {
    let is_copy = |a: &Run, b: &Run| {
        let n = a.len().min(b.len());
        let moves = a.counts[..n].iter().any(|count| *count != a.counts[0]);
        moves && a.counts[..n] == b.counts[..n] && a.command[..n] == b.command[..n]
    };
    let named = |run: &Run| {
        run.path
            .as_deref()
            .map_or_else(String::new, |path| shown(path).to_string())
    };
    for held in held_out {
        if let Some(same) = fitted.iter().find(|run| is_copy(run, held)) {
            return Err(Failure::wrong(
                format!(
                    "--hold-out {}: it has the counts and commands of {}, so it would not test the fit",
                    named(held),
                    named(same)
                ),
                "hold out another recording",
            ));
        }
    }
    Ok(())
}
