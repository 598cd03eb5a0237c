//! Sentences of a diagnosis, from its document only.
//!
//! Four parts: the size of the error, its cause, the remaining error, the next step.

mod cause;
mod next;
mod other_means;
mod words;

pub(crate) use next::after_warnings;
use other_means::{is_at_limit, other_means};
use words::percent_interval;
pub(crate) use words::{counts, listed, name, percent, probability, three};

use super::is_parameter_change;
use super::report::{
    CROSS_VALIDATION, Diagnosis, FloorParts, Gap, HELD_OUT_RUNS, NominalSource, ReferenceRuns,
    Verdict,
};
use super::settings::conventions::{LEAST_PRINTED, LEFT_OUT_SHOWN};
use crate::motor::catalogue::ids;

/// The four parts; `asked` is the command of the diagnosis.
pub(crate) fn parts(diagnosis: &Diagnosis, asked: &str) -> [String; 4] {
    [
        size(diagnosis),
        cause::cause(diagnosis),
        remaining(diagnosis),
        next::next(diagnosis, asked),
    ]
}

/// First part: the held-out error of the nested models and the noise floor.
fn size(diagnosis: &Diagnosis) -> String {
    let error = error(diagnosis);
    match &diagnosis.quick {
        Some(quick) => format!("{error} {}", quick.sentence()),
        None => error,
    }
}

/// The repeatability of runs with the same command, if it is at least the error of the nominal model.
fn repeatability_above_error(diagnosis: &Diagnosis) -> Option<f64> {
    let repeats = diagnosis.gap.floor_parts.repeats;
    repeats.filter(|repeats| *repeats >= diagnosis.gap.before && diagnosis.reference.is_none())
}

/// Whether the noise floor is the difference between runs with the same command, or from the reference.
fn is_floor_repeatability(diagnosis: &Diagnosis) -> bool {
    let repeats = diagnosis.gap.floor_parts.repeats;
    repeats.is_some_and(|repeats| repeats >= diagnosis.gap.floor)
}

fn error(diagnosis: &Diagnosis) -> String {
    let gap = &diagnosis.gap;
    let source = match (is_floor_repeatability(diagnosis), &diagnosis.reference) {
        (true, None) => ", the difference between runs with the same command",
        (true, Some(_)) => ", the error of the reference model on its own runs",
        (false, _) => "",
    };
    let floor = format!("{}{source}", counts(gap.floor));
    if diagnosis.verdict == Verdict::NoGap {
        let nominal = counts(gap.before);
        let within = match gap.before <= gap.floor {
            true => "within",
            false => "not significantly above",
        };
        return match is_nominal_fitted(diagnosis) {
            true => format!(
                "RMS error: {nominal} counts with the nominal model (fitted to these runs), {within} the noise floor of {floor}."
            ),
            false => format!(
                "Held-out RMS error: {nominal} counts with the nominal model, {within} the noise floor of {floor}."
            ),
        };
    }
    let refitted = counts(gap.after_parameters);
    let effects = match diagnosis.effects.is_empty() {
        true => String::new(),
        false => {
            let effects = diagnosis.effects.iter();
            let names: Vec<String> = effects.map(|id| name_of_cause(diagnosis, id)).collect();
            format!(
                ", {} with {}",
                counts(gap.after_effect),
                listed(&names, "and")
            )
        }
    };
    let nominal = counts(gap.before);
    match is_nominal_fitted(diagnosis) {
        true if !is_cross_validated(gap) => format!(
            "RMS error on all samples: {nominal} counts with the motor fitted to all of them, {refitted} with the motor fitted to a part of them{effects} (noise floor {floor})."
        ),
        true => format!(
            "RMS error of the fitted motor: {nominal} counts on the data it was fitted to, {refitted} held out{effects} (noise floor {floor})."
        ),
        false => format!(
            "Held-out RMS error: {nominal} counts nominal, {refitted} with re-identified parameters{effects} (noise floor {floor})."
        ),
    }
}

/// Whether the nominal motor was fitted to the runs of the error.
pub(crate) fn is_nominal_fitted(diagnosis: &Diagnosis) -> bool {
    diagnosis.nominal_source == NominalSource::Fit
        && diagnosis.reference.is_none()
        && diagnosis.gap.held_out != HELD_OUT_RUNS
}

/// Whether the errors are of cross-validation, so that each sample is predicted by a fit to others.
pub(crate) fn is_cross_validated(gap: &Gap) -> bool {
    gap.held_out == CROSS_VALIDATION
}

/// The name of an identified effect; that of a change where the reference has the effect or parameter too.
fn name_of_cause(diagnosis: &Diagnosis, id: &str) -> String {
    let is_in_reference = |then: &ReferenceRuns| {
        then.effects.contains(&id) || id == ids::INDUCTANCE || is_parameter_change(id)
    };
    match diagnosis.reference.as_ref().is_some_and(is_in_reference) {
        true => format!("changed {}", name(id)),
        false => name(id),
    }
}

/// Reference of all shares.
const ABOVE_FLOOR: &str = "the squared error above the noise floor";

/// Third part: size and location of the unexplained error.
fn remaining(diagnosis: &Diagnosis) -> String {
    let unexplained = &diagnosis.unexplained;
    if matches!(diagnosis.verdict, Verdict::NoGap | Verdict::NoChange) {
        return String::new();
    }
    if unexplained.hi95 <= 0.0 {
        return "Unexplained: nothing above the noise floor.".to_owned();
    }
    let of_what = match diagnosis.verdict {
        Verdict::Parameters => "Not explained by re-identified parameters",
        _ => "Unexplained",
    };
    // Shares below the last printed digit.
    if unexplained.hi95 < LEAST_PRINTED {
        return format!(
            "{of_what}: {} of {ABOVE_FLOOR}.",
            percent(unexplained.share.max(0.0))
        );
    }
    // Shares above 100 % compare the fitted data with held-out data.
    let share = match unexplained.share > 1.0 && is_nominal_fitted(diagnosis) {
        true => "Nearly all of the held-out error remains".to_owned(),
        false => format!(
            "{of_what}: {} of {ABOVE_FLOOR} ({})",
            percent(unexplained.share.max(0.0)),
            percent_interval(unexplained.lo95, unexplained.hi95)
        ),
    };
    let regimes = unexplained.regimes.iter();
    let place = (regimes.max_by(|a, b| a.1.total_cmp(b.1)))
        .filter(|_| unexplained.share >= LEAST_PRINTED)
        .map(|(regime, share)| format!("; {} of it {}", percent(*share), regime.words()));
    format!("{share}{}.", place.unwrap_or_default())
}

/// Whether all but an immaterial share of the error is unexplained, although probable effects were tried, or none is
/// probable.
pub(crate) fn is_undescribed(diagnosis: &Diagnosis) -> bool {
    let settings = &diagnosis.settings;
    let was_tried = match diagnosis.verdict {
        Verdict::Ambiguous => {
            (diagnosis.causes.iter()).any(|cause| cause.not_identified(settings).is_some())
        }
        Verdict::OutsideCatalogue => diagnosis.probability >= settings.confident,
        _ => false,
    };
    was_tried && diagnosis.unexplained.share >= 1.0 - settings.unexplained_share
}

/// Why no recording is proposed; `None` where one that separates the remaining sets would be.
pub(crate) fn no_recording_reason(diagnosis: &Diagnosis) -> Option<&'static str> {
    let is_known =
        diagnosis.probability >= diagnosis.settings.confident && diagnosis.classes.is_empty();
    match diagnosis.verdict {
        Verdict::NoGap => Some("the error is not significantly above the noise floor"),
        Verdict::NoChange => Some("these runs agree with the reference"),
        // The predictions of the sets do not hold.
        _ if is_undescribed(diagnosis) => {
            Some("no effect that was tried describes these recordings")
        }
        _ if diagnosis.effects.is_empty() && is_at_limit(diagnosis) => Some(
            "a parameter of a probable effect is at its bound, and the next step is to measure it",
        ),
        Verdict::Effect if is_known => Some("the cause is known"),
        Verdict::Parameters if is_known => Some("the parameters explain the error"),
        _ => None,
    }
}

/// Omitted samples: run, first time and last time in s.
pub(crate) type LeftOut = (String, f64, f64);

/// Intervals in which the drive was off under its command.
fn left_out(intervals: &[LeftOut]) -> String {
    let printed = intervals.iter().take(LEFT_OUT_SHOWN);
    let printed: Vec<String> = printed
        .map(|(run, from_s, to_s)| format!("{} to {} s of {run}", three(*from_s), three(*to_s)))
        .collect();
    let more = match intervals.len().saturating_sub(LEFT_OUT_SHOWN) {
        0 => String::new(),
        more => format!(" ({more} more: motorlab check --verbose)"),
    };
    format!(
        "Left out: {}{more}, where the shaft stands still under a command that turned it before (off_under_command): the drive was off, \
         or the shaft was held.",
        listed(&printed, "and")
    )
}

/// Notes: closed loop, base parameters outside their tolerance, parameters at a bound, score, source of the nominal
/// motor.
pub(crate) fn note(
    diagnosis: &Diagnosis,
    outside: &[(&'static str, f64)],
    off: &[LeftOut],
    is_doubtful: bool,
) -> String {
    let mut notes: Vec<String> = Vec::new();
    if !off.is_empty() {
        notes.push(left_out(off));
    }
    if diagnosis.scoring.closed_loop {
        notes.push(format!(
            "Closed loop: the command answers to the measured position. Segments are {} s long, so that the prediction error is close to an equation error.",
            three(diagnosis.gap.horizon_s)
        ));
    }
    // A parameter with a candidate's name (inductance, inductance_h) is one that these recordings do not separate.
    let is_candidate = |key: &str| {
        let has_its_name = |id: &&str| {
            key.strip_prefix(*id)
                .is_some_and(|unit| unit.starts_with('_'))
        };
        (diagnosis.classes.iter()).any(|class| class.members.iter().any(has_its_name))
    };
    let outside = outside.iter().filter(|(key, _)| !is_candidate(key));
    let outside: Vec<String> = outside
        .map(|(key, share)| format!("{} is {} times", words_of_key(key), three(*share)))
        .collect();
    if !outside.is_empty() {
        let imitates = diagnosis.effects.is_empty()
            && (diagnosis.causes.iter())
                .any(|cause| cause.not_identified(&diagnosis.settings).is_some())
            && !is_undescribed(diagnosis);
        let whose = match diagnosis.nominal_source {
            NominalSource::Given => "motor file's",
            NominalSource::Handout | NominalSource::Fit => "nominal",
        };
        let why = match (diagnosis.nominal_source, imitates) {
            (NominalSource::Handout, true) => {
                ". These values imitate an effect that is not identified, or the motor is not the handout's (give --motor or --nominal fit): do not use them"
            }
            (_, true) => ". These values imitate an effect that is not identified: do not use them",
            (NominalSource::Given, false) => {
                ": the motor has changed, the file is wrong, or the parameter compensates for a missing effect"
            }
            (_, false) => "",
        };
        let fit = match diagnosis.effects.is_empty() {
            true => "In the fit without effects",
            false => "In the fit with the effect",
        };
        notes.push(format!(
            "{fit}, {} the {whose} value, as improbable under the tolerance as three standard deviations or more{why}.",
            listed(&outside, "and")
        ));
    }
    let scoring = &diagnosis.scoring;
    if scoring.score == "likelihood" && scoring.random_load_share > 0.0 {
        notes.extend(random_load(diagnosis).map(|[other, floor]| {
            format!(
                "The error above quantization is modelled as a random load torque with a standard deviation of {} of the stall torque (estimated); this raises the noise floor from {other} to {floor} counts.",
                percent(scoring.random_load_share)
            )
        }));
    }
    if is_doubtful {
        notes.push(
            "A finding about the recordings is fatal: correct it before using this result."
                .to_owned(),
        );
    }
    notes.join(" ")
}

/// The noise floor without a random load torque and with it, where that is the largest part.
fn random_load(diagnosis: &Diagnosis) -> Option<[String; 2]> {
    let Gap {
        floor, floor_parts, ..
    } = &diagnosis.gap;
    let others = FloorParts {
        random: None,
        ..*floor_parts
    };
    // Beside identified effects the floor has no random load.
    let is_floor = floor_parts.random.is_some_and(|random| random >= *floor);
    let [other, floor] = [others.largest(), *floor].map(counts);
    (is_floor && diagnosis.effects.is_empty() && other != floor).then_some([other, floor])
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// A key of a motor file as words.
pub(crate) fn words_of_key(key: &str) -> String {
    let words = match key {
        "inertia_kg_m2" => "inertia",
        "back_emf_v_s_per_rad" => "the back-EMF constant",
        "coulomb_friction_nm" => "Coulomb friction",
        "viscous_friction_nm_s_per_rad" => "viscous friction",
        "inductance_h" => "inductance",
        "torque_constant_nm_per_a" => "the torque constant",
        other => other,
    };
    words.to_owned()
}
