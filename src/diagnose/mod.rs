//! Where the gap lies, which effect causes it, how far it shrinks: runs and a motor in, a [`Diagnosis`] out.
//!
//! ```text
//! Runs -> Pieces -> base fit -> levels: screening, fits, presence -> unknown -> conclusion -> next experiment
//! ```
//!
//! One measure: the position error in counts over a piece of a run, from the piece's own measured start. A model is fitted to it
//! (`fit`), whitened by rounding and a load that wanders (`noise`), and scored on pieces that it was not fitted to. Whatever is
//! said to be there gains more than chance makes of recordings simulated from the smaller model (`validation`). What it comes to is
//! `conclusion`'s, what to record next `design`'s.

mod conclusion;
mod design;
mod error;
mod fit;
mod noise;
mod nominal;
mod pieces;
mod report;
#[cfg(test)]
mod samples;
mod screening;
mod selection;
mod settings;
mod validation;

pub use design::{Isolability, Pair, Plan, isolability};
pub use error::DiagnoseError;
pub use nominal::{NominalFit, nominal_fit};
pub use report::{
    BadRecording, Cause, Diagnosis, EffectSet, Evidence, Fitted, FloorParts, Gap, GoodEnough,
    Interval, KnownChange, NextExperiment, NominalSource, Place, PredictedRun, ReferenceRuns,
    Regime, Region, Rival, SHAPE, SeenMotor, Step, Term, Verdict, other_means,
};

pub(crate) use conclusion::sure;
pub(crate) use settings::SURE;

use std::borrow::Cow;

use crate::check::{check, misread_positions};
use crate::motor::Motor;
use crate::recording::Run;
use conclusion::Reference;
use error::usable;
use fit::Base;
use pieces::{Pieces, Thinned, Work};
use selection::forward;
use settings::CLOCK_READING_S;

/// What a diagnosis is asked beyond its runs and its motor.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Runs that nothing is fitted to and nothing is chosen by: the gap is measured on them.
    pub held_out: &'a [Run],
    /// Earlier runs of the same axis, or runs of another of its kind: what is asked is what differs from them.
    pub reference: &'a [Run],
    /// Numbers of runs that are said to repeat each other, beside those that have the same commands; a group each.
    pub repeats: &'a [Vec<usize>],
    /// Below this there is no gap.
    pub good_enough: Option<GoodEnough>,
    /// Whether something fatal was found in the recordings: nothing is said with more than 90 % then.
    pub is_doubtful: bool,
    /// Where the numbers of the motor come from.
    pub nominal_source: NominalSource,
    /// The command line that asks this: what to do next repeats it. None where the runs' names say enough.
    pub asked: Option<&'a str>,
    /// Is told what is being done.
    pub progress: &'a dyn Fn(&str),
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            held_out: &[],
            reference: &[],
            repeats: &[],
            good_enough: None,
            is_doubtful: false,
            nominal_source: NominalSource::Given,
            asked: None,
            progress: &|_| (),
        }
    }
}

/// Says where the gap between runs and motor lies, which effects cause it and how far it shrinks.
///
/// # Errors
/// No runs, runs that are too short or of different axes, runs or motors that cannot be simulated.
///
/// ```
/// use motorlab::diagnose::{Options, Verdict, diagnose};
/// use motorlab::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};
/// use motorlab::recording::Run;
///
/// let motor = Motor::default();
/// let t_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.01).collect();
/// let command = vec![4.5; 400];
/// let drive = Drive { t_s: &t_s, command: &command, kind: CommandKind::Voltage };
/// let counts = simulate(&motor, &drive, &SimulationOptions::default())?.counts;
/// let run = Run { sample_time_s: 0.01, counts_per_rev: 720.0, t_s, command, counts, ..Run::default() };
/// let diagnosis = diagnose(&[run], &motor, &Options::default())?;
/// assert_eq!(diagnosis.verdict, Verdict::NoGap);
/// println!("{}", diagnosis.sentence);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn diagnose(
    runs: &[Run],
    motor: &Motor,
    options: &Options<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    let begun = std::time::Instant::now();
    let recorded = runs;
    let (runs, held_out, earlier) = (
        &read_right(runs)[..],
        &read_right(options.held_out)[..],
        &read_right(options.reference)[..],
    );
    let (all, mut base) = made_ready(runs, motor)?;
    let thinned = Thinned::new(&all, runs)?;
    let pieces = thinned.as_ref().map_or(&all, |thinned| &thinned.pieces);
    let mut works = vec![all.work.clone()];
    works.extend(thinned.as_ref().map(|thinned| thinned.pieces.work.clone()));
    let mut reference = None;
    if let [first, ..] = earlier {
        usable(&[runs[0].clone(), first.clone()])?;
        let (then, mut then_base) = made_ready(earlier, motor)?;
        // One motor has the same numbers then and now.
        base.knows_torque |= then_base.knows_torque;
        then_base.knows_torque = base.knows_torque;
        (options.progress)("diagnosing the reference");
        let (then, of_then) = match Thinned::new(&then, earlier)? {
            Some(thinned) => (thinned.pieces, thinned.runs),
            None => (then, earlier.to_vec()),
        };
        works.push(then.work.clone());
        let found = forward(&of_then, &then, &then_base, &|_| ()).ok_or(DiagnoseError::NoFit)?;
        let made = Reference::new(&of_then, (then, then_base), &found, pieces);
        let (made, now) = made.ok_or(DiagnoseError::NoFit)?;
        base = now.for_runs_of(&base);
        reference = Some(made);
    }
    let held = match held_out {
        [] => None,
        _ => {
            let both: Vec<Run> = [&runs[..1], held_out].concat();
            usable(&both)?;
            Some(Pieces::new(held_out, motor)?)
        }
    };
    let searched = thinned.as_ref().map_or(runs, |thinned| &thinned.runs);
    let found = forward(searched, pieces, &base, options.progress).ok_or(DiagnoseError::NoFit)?;
    (options.progress)("looking for something unknown");
    let mut unknown = validation::unknown(pieces, &found.best);
    if thinned.is_some() {
        unknown = unknown
            .with_worst_of(&all, &found.best)
            .ok_or(DiagnoseError::NoFit)?;
    }
    (options.progress)("weighing what was found, and what to record next");
    let grounds = conclusion::Grounds {
        runs,
        all: &all,
        pieces,
        thinned: thinned.as_ref(),
        held: held.as_ref(),
        reference: reference.as_ref(),
        base: &base,
        found: &found,
        unknown: &unknown,
        repeats: options.repeats,
        good_enough: options.good_enough,
        is_doubtful: options.is_doubtful,
        nominal_source: options.nominal_source,
        asked: options
            .asked
            .map_or_else(|| report::asked(runs, held_out, earlier), str::to_owned),
        steps: conclusion::steps(&found, &unknown),
    };
    let mut diagnosis = conclusion::conclude(grounds).ok_or(DiagnoseError::NoFit)?;
    diagnosis.data = check(recorded, Some(motor));
    diagnosis.simulated_samples = works.iter().map(Work::samples).sum();
    diagnosis.elapsed_s = begun.elapsed().as_secs_f64();
    Ok(diagnosis)
}

/// Runs without the samples whose position was misread, as `check` lists them.
fn read_right(runs: &[Run]) -> Cow<'_, [Run]> {
    let misread: Vec<Vec<usize>> = runs.iter().map(misread_positions).collect();
    if misread.iter().all(Vec::is_empty) {
        return runs.into();
    }
    let pairs = runs.iter().zip(&misread);
    pairs.map(|(run, samples)| run.without(samples)).collect()
}

/// Runs cut into pieces, and what is the same for all models of them.
fn made_ready(runs: &[Run], motor: &Motor) -> Result<(Pieces, Base), DiagnoseError> {
    let kind = usable(runs)?;
    let pieces = Pieces::new(runs, motor)?;
    let clocks = pieces.runs.iter().filter_map(|run| run.clock);
    let longest = clocks.max_by(|a, b| a.1.total_cmp(&b.1));
    let mut motor = motor.clone();
    motor.parameters.counts_per_rev = runs[0].counts_per_rev;
    motor.parameters.supply_v = runs[0].supply_v.unwrap_or(motor.parameters.supply_v);
    let base = Base {
        motor,
        kind,
        sample_time_s: pieces.runs[0].sample_time_s,
        clock: longest.map(|(error, span_s)| (error, CLOCK_READING_S / span_s)),
        is_host_timed: runs.iter().any(Run::is_host_timed),
        knows_torque: runs.iter().any(|run| run.known.has_torque()),
        then: None,
    };
    Ok((pieces, base))
}

#[cfg(test)]
mod tests {
    use super::samples::{motor_with, recording};
    use super::*;

    /// A dead zone is named, its rungs fall on what was fitted, and every probability and share adds up.
    #[test]
    fn a_dead_zone_is_named_and_its_figures_add_up() {
        let run = recording(&motor_with(&[("dead_zone", &[0.9])]), 1500);
        let found = diagnose(&[run], &Motor::default(), &Options::default()).expect("a diagnosis");
        let likeliest = &found.causes[0];
        assert!(likeliest.effect.contains("dead_zone"), "{found}");
        let fitted = found.gap.fitted;
        assert!(fitted.after_parameters <= fitted.before, "{fitted:?}");
        assert!(fitted.after_effect <= fitted.after_parameters, "{fitted:?}");
        assert!(
            fitted.after_effect < 0.5 * fitted.after_parameters,
            "{fitted:?}"
        );
        let sum: f64 = found.causes.iter().map(|cause| cause.probability).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        let stages: f64 = found.place.stage_probabilities.values().sum();
        assert!((stages - 1.0).abs() < 1e-9, "{stages}");
        let shares: f64 = found.place.regions.iter().map(|region| region.share).sum();
        assert!(shares > 0.0 && shares < 1.0 + 1e-9, "{shares}");
    }

    /// What is good enough is no gap, whatever is significant, and the note says what is visible.
    #[test]
    fn what_is_good_enough_is_no_gap() {
        let run = recording(&motor_with(&[("dead_zone", &[0.9])]), 1500);
        let options = Options {
            good_enough: Some(GoodEnough::Share(0.5)),
            ..Options::default()
        };
        let found = diagnose(&[run], &Motor::default(), &options).expect("a diagnosis");
        assert_eq!(found.verdict, Verdict::NoGap);
        assert!(found.effects.is_empty());
        assert!(found.note.contains("dead zone"), "{}", found.note);
        assert!((found.gap.floor - 0.5 * found.gap.travel).abs() < 1e-9);
    }

    /// Where nothing is missing the motor stays as it is, whatever a fit would make of rounding.
    #[test]
    fn the_motor_is_the_one_that_the_verdict_says() {
        let options = Options::default();
        let of = |truth: &Motor| {
            let run = recording(truth, 1500);
            diagnose(&[run], &Motor::default(), &options).expect("a diagnosis")
        };
        let right = of(&Motor::default());
        assert_eq!(right.verdict, Verdict::NoGap);
        assert_eq!(right.model, right.nominal);
        let found = of(&motor_with(&[("dead_zone", &[0.9])]));
        assert!(found.model.effects.get("dead_zone").is_some(), "{found}");
    }

    /// Failed reads are listed and left out: what is said is what is said without them.
    #[test]
    fn failed_reads_change_nothing() {
        let sound = recording(&motor_with(&[("dead_zone", &[0.9])]), 1500);
        let mut failed = sound.clone();
        [200, 700, 1100]
            .iter()
            .for_each(|k| failed.counts[*k] = -2047);
        let without = sound.without(&[200, 700, 1100]);
        let of = |run: Run| diagnose(&[run], &Motor::default(), &Options::default());
        let (failed, without) = (of(failed).expect("one"), of(without).expect("one"));
        assert_eq!(failed.gap, without.gap);
        assert_eq!(failed.causes[0].effect, without.causes[0].effect);
        let is_listed = |found: &Diagnosis| {
            (found.data.iter()).any(|finding| finding.id == crate::check::Kind::MisreadPosition)
        };
        assert!(is_listed(&failed) && !is_listed(&without));
    }

    /// Held-out runs are measured on, and nothing is fitted to them: other held-out runs leave the numbers that were fitted alone.
    #[test]
    fn held_out_runs_are_only_measured() {
        let truth = motor_with(&[("dead_zone", &[0.9])]);
        let named = [recording(&truth, 1000)];
        let same = [recording(&truth, 700)];
        let other = [recording(&Motor::default(), 700)];
        let of = |held_out: &[Run]| {
            let options = Options {
                held_out,
                good_enough: Some(GoodEnough::Counts(1.0)),
                ..Options::default()
            };
            diagnose(&named, &Motor::default(), &options).expect("a diagnosis")
        };
        let (same, other) = (of(&same), of(&other));
        assert_eq!(same.gap.fitted, other.gap.fitted);
        let said = |found: &Diagnosis| (found.verdict, found.probability, found.effects.clone());
        assert_eq!(said(&same), said(&other));
        assert!(
            same.gap.before > 2.0 * same.gap.after_effect,
            "{:?}",
            same.gap
        );
        // The nominal model is right there, and what was fitted elsewhere is not.
        assert!(
            other.gap.before < 0.5 * other.gap.after_effect,
            "{:?}",
            other.gap
        );
    }
}
