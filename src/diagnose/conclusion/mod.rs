//! What it comes to: probabilities, verdict, where, how far.

mod causes;
mod floor;
mod intervals;
mod place;
mod reference;
mod rungs;
#[cfg(test)]
mod samples;
mod sentence;
mod since;
mod steps;
mod verdict;
mod weights;
mod words;

use super::design::next_experiment;
use super::error::name_of;
use super::fit::{Base, Fit, Left, score_at};
use super::pieces::{Pieces, Thinned};
use super::report::{Diagnosis, GoodEnough, NominalSource, Place, SHAPE, SeenMotor, Step, Verdict};
use super::selection::Forward;
use super::settings::{FEW_PIECES, LEAST_GAIN, SURE, WITHIN_TOLERANCES};
use super::validation::Unknown;
use crate::motor::fit::ParameterId;
use crate::recording::Run;
use floor::Floor;
use sentence::Beside;
use since::Since;
use verdict::Asked;

pub(crate) use reference::Reference;
pub(crate) use steps::steps;
use weights::without_any_known;
pub(crate) use weights::{Weights, weights};
pub(crate) use words::sure;

/// What a conclusion rests on.
pub(crate) struct Grounds<'a> {
    pub runs: &'a [Run],
    pub all: &'a Pieces,
    /// Those that were searched.
    pub pieces: &'a Pieces,
    /// Where these are not all.
    pub thinned: Option<&'a Thinned>,
    /// Pieces of runs that nothing was fitted to.
    pub held: Option<&'a Pieces>,
    pub base: &'a Base,
    pub found: &'a Forward,
    pub unknown: &'a Unknown,
    /// Runs that these are held against; the base's motor is theirs then.
    pub reference: Option<&'a Reference>,
    /// Runs that are said to repeat each other, by their numbers.
    pub repeats: &'a [Vec<usize>],
    pub good_enough: Option<GoodEnough>,
    /// Whether something fatal was found in the recordings.
    pub is_doubtful: bool,
    /// Where the nominal motor comes from.
    pub nominal_source: NominalSource,
    /// The command that asks.
    pub asked: String,
    pub steps: Vec<Step>,
}

/// Everything that a search comes to; none where a model cannot be simulated.
pub(crate) fn conclude(grounds: Grounds<'_>) -> Option<Diagnosis> {
    let Grounds {
        all,
        pieces,
        thinned,
        base,
        found,
        ..
    } = grounds;
    let is_few = pieces.pieces.len() < FEW_PIECES;
    let is_unsure = is_few || grounds.is_doubtful;
    let most_sure = if is_unsure { SURE } else { 1.0 };
    let mut weights = weights(found, grounds.unknown);
    let mut changes = None;
    if let Some(reference) = grounds.reference {
        let mut since = reference.changes(pieces, found, weights);
        weights = std::mem::take(&mut since.weights);
        changes = Some(since);
    }
    let found = changes.as_ref().map_or(found, |changes| &changes.found);
    let best = &found.best;
    let shown = rungs::Shown::new(pieces, base, &found.refitted, best)?;
    if let Some(reference) = grounds.reference {
        let share = reference.share_of_unknown(pieces, &shown.with_effects.predicted);
        weights = weights.with_unknown(share);
    }
    let floor = Floor::of(&grounds);
    let wander = floor::wander(pieces, best);
    // What is held out chooses nothing, the verdict included.
    let searched = rungs::rungs((all, pieces), thinned.map(|_| all), &shown, &floor)?;
    // What the inverse form decides is borne out by its own folds: there no simulation is the measure.
    let is_inverse = found.levels.iter().any(|level| level.is_inverse);
    let (borne_out, prediction) = match is_inverse {
        true => (1.0, None),
        false => {
            let borne_out = searched.borne_out();
            (
                borne_out,
                steps::prediction(found, &searched.gap, borne_out),
            )
        }
    };
    let weights = weights.borne_out(borne_out).at_most(most_sure);
    let refitted = &shown.refitted.left;
    let left_of_all = match thinned {
        Some(_) => Left::of(all, &refitted.motor, refitted.time_constant_s)?,
        None => refitted.shown.clone(),
    };
    let asked = Asked {
        below_floor: [0, 1].map(|rung| searched.below_floor(rung)),
        are_numbers_plausible: found.refitted.model.bent(&found.refitted.x) <= WITHIN_TOLERANCES
            && found.refitted.prior - best.prior <= LEAST_GAIN,
        is_nominal_right: is_nominal_right(pieces, found)?,
        is_one_piece: pieces.pieces.len() < 2,
        borne_out,
        without_any_known: without_any_known(found),
        most_sure,
    };
    let mut said = verdict::verdict(&weights, &found.sets, &searched.gap, asked);
    if grounds.reference.is_some() && matches!(said.verdict, Verdict::NoGap | Verdict::Parameters) {
        said.verdict = Verdict::NoChange;
    }
    let model = shown.motor_said(said.verdict, &searched.gap).clone();
    let mut rungs = match grounds.held {
        Some(held) => rungs::rungs((all, pieces), Some(held), &shown, &floor)?,
        None => searched,
    };
    rungs.gap.wander = wander.min(rungs.gap.beyond_rounding(said.verdict));
    // Where nothing that matters is missing, nobody is asked for more; but few pieces may hide it.
    let share = |set: &[&'static str]| match set {
        [] => weights.none,
        _ => weights.of(&[set.to_vec()]),
    };
    let next_experiment = match said.is_by_floor && !is_few {
        true => None,
        false => next_experiment(grounds.runs, pieces, base, found, &share),
    };
    let mut stages: Vec<Option<String>> =
        found.sets.iter().map(|set| causes::stages(set)).collect();
    stages.dedup();
    let causes = causes::causes(pieces, base, found, &weights);
    let beside = Beside {
        since: (grounds.reference.is_some()).then(|| Since {
            changed: since::changes(&said.effects, &causes),
            alike: changes
                .as_ref()
                .map_or_else(Vec::new, |changes| changes.alike.clone()),
        }),
        tied: found.sets.clone(),
        is_by_direction: causes::tied(found).len() > found.sets.len(),
        bent: bent(best),
        wander_share: best.noise.strength,
        pieces: pieces.pieces.len(),
        all_pieces: all.pieces.len(),
        is_by_floor: said.is_by_floor,
        is_held_out: grounds.held.is_some(),
        is_doubtful: grounds.is_doubtful,
        inverse_gain: found
            .inverse
            .first()
            .filter(|_| is_inverse)
            .map(|pick| pick.gain),
        unknown: weights.unknown,
        asked: grounds.asked,
    };
    let is_fit = grounds.nominal_source == NominalSource::Fit && grounds.reference.is_none();
    let mut diagnosis = Diagnosis {
        shape: SHAPE,
        verdict: said.verdict,
        sentence: String::new(),
        parts: Default::default(),
        probability: said.probability,
        effects: said.effects,
        causes,
        place: Place {
            // Of several that are not told apart, the stage that they share.
            stage: if stages.len() == 1 {
                stages.remove(0)
            } else {
                None
            },
            stage_probabilities: weights.stages(),
            regions: if matches!(said.verdict, Verdict::NoGap | Verdict::NoChange) {
                Vec::new()
            } else {
                place::regions(
                    all,
                    &|run| name_of(run, &grounds.runs[run]),
                    &left_of_all,
                    rungs.gap.floor,
                )
            },
        },
        gap: rungs.gap,
        sets: causes::sets(found, &weights),
        base: causes::base(pieces, best),
        note: String::new(),
        data: Vec::new(),
        next_experiment,
        steps: grounds.steps.into_iter().chain(prediction).collect(),
        elapsed_s: 0.0,
        simulated_samples: 0,
        reference: grounds.reference.map(Reference::report),
        fitted_nominal: (is_fit.then(|| SeenMotor::of(&base.motor, base.kind, base.knows_torque)))
            .flatten(),
        nominal_source: grounds.nominal_source,
        predicted: rungs.predicted,
        command_kind: base.kind,
        nominal: base.motor.clone(),
        model,
        refitted: shown.refitted.left.motor,
    };
    diagnosis.note = sentence::note(&diagnosis, &beside);
    diagnosis.parts = sentence::parts(&diagnosis, &beside);
    diagnosis.sentence = diagnosis.parts.join(" ");
    Some(diagnosis)
}

/// Whether refitting gains nothing over the motor file's own numbers, on pieces not fitted.
fn is_nominal_right(pieces: &Pieces, found: &Forward) -> Option<bool> {
    let refitted = &found.refitted;
    let nominal = score_at(pieces, refitted, refitted.model.mean.as_slice())?;
    Some(refitted.score() - nominal <= LEAST_GAIN)
}

/// Base numbers beyond their tolerances, as shares of the motor file's.
fn bent(fit: &Fit) -> Vec<(&'static str, f64)> {
    let off = fit.model.off(&fit.x);
    let beyond = fit.model.numbers.iter().zip(off).enumerate();
    beyond
        .filter(|(_, (number, off))| {
            matches!(number.id, ParameterId::Nominal(_)) && *off > WITHIN_TOLERANCES
        })
        .map(|(k, (number, _))| (number.id.key(), fit.x[k]))
        .collect()
}
