//! Texts that page and terminal share.

use crate::diagnose::{
    Cause, Diagnosis, EffectClass, HELD_OUT_RUNS, Interval, NominalSource, ReferenceRuns, Settings,
    Verdict,
};
use crate::diagnose::{
    class_of, is_cross_validated, is_nominal_fitted, is_parameter_change, is_undescribed, name,
    no_recording_reason, without_assumed_unit,
};
use crate::motor::CommandKind;
use crate::motor::catalogue::{EffectKind, catalogue};
use crate::report::number::{figure, probability_of};

/// Most names listed in a line.
const NAMED: usize = 5;
/// Most effects whose equation is printed.
const EQUATIONS: usize = 4;
/// Least inclusion probability of effects whose equation and parameters are printed.
pub const DETAILED_FROM: f64 = 0.05;

/// An effect of the catalogue by its id.
pub(super) fn kind(id: &str) -> Option<&'static EffectKind> {
    catalogue().iter().find(|kind| kind.id == id)
}

/// The verdict and the named parts of the sentence; empty parts are left out.
pub fn named_parts(diagnosis: &Diagnosis) -> Vec<(&'static str, String)> {
    let names = ["Verdict", "Error", "Cause", "Unexplained", "Next step"];
    let parts = [verdict_words(diagnosis)]
        .into_iter()
        .chain(diagnosis.parts.iter().cloned());
    let named = names.into_iter().zip(parts);
    named.filter(|(_, part)| !part.is_empty()).collect()
}

/// The verdict, its meaning, and the nominal motor.
fn verdict_words(diagnosis: &Diagnosis) -> String {
    let verdict = diagnosis.verdict;
    let nominal = match (&diagnosis.reference, diagnosis.nominal_source) {
        (Some(_), _) => "fitted to the reference runs",
        (None, NominalSource::Fit) => "fitted to these runs, without effects",
        (None, NominalSource::Handout) => "the lab handout's motor",
        (None, NominalSource::Given) => "the motor file",
    };
    let settings = &diagnosis.settings;
    let is_nearly_all = diagnosis.unexplained.share < settings.unexplained_share;
    let meaning = match verdict {
        Verdict::Parameters if diagnosis.probability < settings.identified => {
            "re-identified parameters remove more than 90\u{a0}% of the squared error, but probably by imitating an effect that is not identified, so they are no measurement"
        }
        Verdict::Ambiguous if is_undescribed(diagnosis) => {
            "effects raise the log score, but none is identified, and nearly all of the held-out error remains"
        }
        Verdict::Parameters if is_nearly_all => {
            "no effect is identified, and re-identified parameters remove more than 90\u{a0}% of the squared error"
        }
        verdict => verdict.meaning(),
    };
    format!("{}: {meaning}. Nominal model: {nominal}.", verdict.id())
}

/// An effect with its description.
pub fn cause_words(id: &str) -> String {
    if is_parameter_change(id) {
        return format!(
            "{id}: a change of {} that its tolerance (prior) does not explain",
            name(id)
        );
    }
    kind(id).map_or_else(|| id.to_owned(), |kind| format!("{id}: {}", kind.summary))
}

/// A set of effects.
pub fn effects_words(ids: &[&str]) -> String {
    match ids {
        [] => "none".to_owned(),
        ids => ids.join(" + "),
    }
}

/// The identified effects, else the most probable ones.
pub(super) fn explained(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let mut ids = diagnosis.effects.clone();
    let probable = (diagnosis.causes.iter()).filter(|cause| cause.inclusion >= DETAILED_FROM);
    for cause in probable {
        if !ids.contains(&cause.effect) {
            ids.push(cause.effect);
        }
    }
    ids.truncate(EQUATIONS);
    ids
}

/// Source of the nominal model's parameters.
pub(super) fn nominal_words(diagnosis: &Diagnosis) -> &'static str {
    match (&diagnosis.reference, diagnosis.nominal_source) {
        (Some(_), _) => "reference's",
        (None, NominalSource::Fit) => "nominal fit's",
        (None, NominalSource::Handout) => "handout's",
        (None, NominalSource::Given) => "motor file's",
    }
}

/// The reference runs and their model.
pub fn of_reference(diagnosis: &Diagnosis, reference: &ReferenceRuns) -> String {
    let model = match (reference.effects.as_slice(), diagnosis.nominal_source) {
        ([], NominalSource::Given) => "The motor file's model without further effects".to_owned(),
        ([], _) => "The basic motor".to_owned(),
        (effects, _) => format!("The motor with {}", effects.join(" + ")),
    };
    format!(
        "{model}, fitted to the reference ({}), leaves {} counts RMS there.",
        reference.runs.join(", "),
        figure(reference.rms_counts, 3)
    )
}

/// Whether a further recording is optional, since the sentence proposes another step.
pub fn is_optional(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict == Verdict::Parameters
        && diagnosis.probability >= diagnosis.settings.identified
}

/// Why no recording is proposed.
pub fn no_recording(diagnosis: &Diagnosis) -> String {
    let reason = no_recording_reason(diagnosis)
        .unwrap_or("no profile separates the remaining sets of effects");
    format!("No recording is proposed: {reason}.")
}

/// The first few names, and the number of the others.
pub fn few_words(names: &[String]) -> String {
    let named = names[..names.len().min(NAMED)].iter();
    let named = named.map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(NAMED) {
        0 => named,
        others => format!("{named} and {others} more"),
    }
}

/// Sets of effects that a recording would separate, as a list of hypotheses.
pub fn hypotheses(sets: &[String]) -> String {
    let named = sets[..sets.len().min(NAMED)].iter();
    let named = named.map(|set| if set == "none" { "no effect" } else { set });
    let named = named.collect::<Vec<_>>().join("; ");
    match sets.len().saturating_sub(NAMED) {
        0 => named,
        others => format!("{named}; {others} more"),
    }
}

/// A class of effects that the runs do not separate.
pub fn class_words(class: &EffectClass) -> String {
    format!(
        "{} (class {}, {})",
        class.members.join(", "),
        class.class,
        probability_of("", class.probability)
    )
}

/// The prediction error of all figures, how data were held out, and the noise floor.
pub fn measured(diagnosis: &Diagnosis) -> String {
    let gap = &diagnosis.gap;
    let parts = gap.floor_parts;
    let part = |name: &str, counts: Option<f64>| {
        counts.map(|counts| format!("{name} {}", figure(counts, 3)))
    };
    let repeats = match &diagnosis.reference {
        Some(then) if parts.repeats == Some(then.rms_counts) => "residual of the reference",
        _ => "repeatability",
    };
    let parts = [
        part("quantization", Some(parts.rounding)),
        part("random load torque and stochastic effects", parts.random),
        part(repeats, parts.repeats),
        part("good enough", parts.good_enough),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!(
        "RMS errors are prediction errors of the position over segments of {} s (median), {}. {}. Noise floor {} counts ({}{}).",
        figure(gap.horizon_s, 3),
        match gap.travel {
            0.0 => "of which more than half are at standstill".to_owned(),
            travel => format!(
                "in which the shaft travels {} counts (median)",
                figure(travel, 4)
            ),
        },
        match (gap.held_out.as_str(), is_cross_validated(gap)) {
            (method, true) => format!("Held-out errors are measured by {method}"),
            (HELD_OUT_RUNS, _) => format!("Held-out errors are measured on {HELD_OUT_RUNS}"),
            (method, false) =>
                format!("Errors are measured on {method}, so they are not strictly held out"),
        },
        figure(gap.floor, 3),
        match parts.len() {
            1 => "",
            _ => "the largest of: ",
        },
        parts.join(", ")
    )
}

/// The same models on the training data.
pub fn fitted_words(diagnosis: &Diagnosis) -> String {
    let fitted = diagnosis.gap.fitted;
    let effects = match diagnosis.effects.is_empty() {
        true => String::new(),
        false => format!(", {} with effects", figure(fitted.after_effect, 3)),
    };
    format!(
        "On the fitted data: {} counts nominal, {} with re-identified parameters{effects}.",
        figure(fitted.before, 3),
        figure(fitted.after_parameters, 3)
    )
}

/// Meaning of the log score, and the probability that follows from it.
pub fn sets_note(diagnosis: &Diagnosis) -> String {
    let score = match diagnosis.scoring.score {
        "likelihood" => {
            "Log score: log evidence; higher is better. Compare sets by it, not by RMS: the fit divides each residual by its expected standard deviation."
        }
        _ => {
            "Log score (scale-free): -N ln(RMS) less a penalty for each parameter, N being the effective number of observations; higher is better."
        }
    };
    let rate = figure(diagnosis.scoring.learning_rate, 3);
    format!(
        "{score} Probability is proportional to exp({rate} log score); {rate} is the learning rate, which tempers the likelihood (docs/method/diagnosis.md)."
    )
}

/// The class of an effect; where these runs do not separate its members, the probability that one of them is present.
/// `None` without a class.
pub fn class_of_cause(cause: &Cause, settings: &Settings) -> Option<String> {
    let class = class_of(cause.effect)?;
    Some(match cause.class_probability {
        Some(p) => {
            let identified = settings.identified;
            let limit = match cause.at_bound && p >= identified && cause.inclusion < identified {
                true => ", a parameter at its bound",
                false => "",
            };
            format!("class {class}: {} together{limit}", probability_of("", p))
        }
        None => format!("class {class}"),
    })
}

/// Meaning of the inclusion probabilities.
pub fn causes_title(diagnosis: &Diagnosis) -> &'static str {
    match is_undescribed(diagnosis) {
        true => {
            "probability relative to the sets that were tried, none of which describes the recordings"
        }
        false => "probability that an effect is present, alone or with others",
    }
}

/// Meaning of a class, and the tolerance of parameter changes, if there are such causes.
pub fn causes_note(diagnosis: &Diagnosis) -> String {
    let causes = || diagnosis.causes.iter();
    let mut notes = Vec::new();
    if causes().any(|cause| class_of(cause.effect).is_some()) {
        notes.push(
            "Class: effects that look alike in most recordings (docs/reference/reading-a-diagnosis.md); P together: the probability that at least one of its effects is present.",
        );
    }
    if causes().any(|cause| is_parameter_change(cause.effect)) {
        notes.push(match diagnosis.reference {
            Some(_) => "Tolerance: what the reference leaves uncertain in a parameter, and 1\u{a0}%.",
            None => "Tolerance: the standard deviation of a parameter's prior, not a bound: the motor file's, or 5\u{a0}% by default. Without a stated tolerance the prior has heavy tails, so that even a severalfold change can be attributed to re-identified parameters.",
        });
    }
    notes.join(" ")
}

/// The models in the figures, from the nominal one on.
pub(super) fn models(diagnosis: &Diagnosis) -> Vec<String> {
    let nominal = match diagnosis.reference {
        Some(_) => "nominal (reference)",
        None => "nominal",
    };
    let mut names = vec![nominal.to_owned(), "re-identified".to_owned()];
    if !diagnosis.effects.is_empty() {
        names.push(format!("with {}", diagnosis.effects.join(" + ")));
    }
    names
}

/// A 95 % interval of a parameter.
pub fn interval_words(interval: &Interval) -> String {
    match interval.lo95 == interval.hi95 {
        true => "fixed".to_owned(),
        false => format!(
            "{} to {}",
            figure(interval.lo95, 4),
            figure(interval.hi95, 4)
        ),
    }
}

/// The value of a parameter that has no interval, in words; `None` for one with an interval.
pub fn discrete_words(key: &str, value: f64) -> Option<&'static str> {
    match (key, value > 0.5) {
        ("encoder_side", true) => Some("on the load's side"),
        ("encoder_side", false) => Some("on the motor's side"),
        _ => None,
    }
}

/// Name of the column of identifiable parameters: the model that has them.
pub fn value_column(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict {
        Verdict::NoGap | Verdict::NoChange => "nominal value".to_owned(),
        _ if diagnosis.effects.is_empty() => "re-identified value".to_owned(),
        _ => format!("value with {}", diagnosis.effects.join(" + ")),
    }
}

/// Name of the column of the motor file's values; `None` without a file, or where the values are the file's.
pub fn motor_file_column(diagnosis: &Diagnosis) -> Option<&'static str> {
    let has_file = diagnosis.identifiable.motor_file.is_some();
    (has_file && diagnosis.verdict != Verdict::NoGap).then_some("motor file")
}

/// Name and unit of the residual: a torque, or the command where no torque is known.
pub(super) fn residual_words(diagnosis: &Diagnosis) -> (&'static str, &'static str) {
    match (diagnosis.has_torque(), diagnosis.command_kind) {
        (true, _) | (_, CommandKind::Torque) => ("torque", "mN m"),
        (_, CommandKind::Voltage) => ("voltage", "mV"),
        (_, CommandKind::Current) => ("current", "mA"),
    }
}

/// The equation of an effect; without units where no torque is known.
pub(super) fn equation(diagnosis: &Diagnosis, kind: &EffectKind) -> String {
    let equation = kind.equation.to_owned();
    if diagnosis.has_torque() {
        return equation;
    }
    let keys = kind.parameters.iter().map(|parameter| parameter.key);
    keys.fold(equation, |text, key| {
        text.replace(key, without_assumed_unit(key))
    })
}

/// Meaning of the intervals beside nominal values, and the source of figures in N m.
pub fn parameters_note(diagnosis: &Diagnosis) -> String {
    let is_fitted = is_nominal_fitted(diagnosis);
    let of_nominal = match diagnosis.verdict {
        Verdict::NoGap | Verdict::NoChange if !is_fitted => {
            "Intervals: the uncertainty around the nominal values that these recordings leave. "
        }
        _ => "",
    };
    format!("{of_nominal}{}", torque_words(diagnosis))
}

/// Source of figures in N m and kg m^2, or why there are none.
fn torque_words(diagnosis: &Diagnosis) -> String {
    if diagnosis.command_kind == CommandKind::Torque {
        return "The command is a torque, so that torques are known in N m.".to_owned();
    }
    if !diagnosis.has_torque() {
        // As in the next step.
        let file = match diagnosis.effects.is_empty() {
            true => "fitted.toml",
            false => "diagnosed.toml",
        };
        return match diagnosis.command_kind {
            CommandKind::Voltage => format!(
                "Resistance and torque constant are not known: friction and loads are in V, inductance as L/R. For torques measure the resistance with an ohmmeter, write the motor file with `--model-out {file}`, then `motorlab motor {file} --resistance OHM`."
            ),
            _ => {
                "The torque constant is not known: friction and loads are in units of the command."
                    .to_owned()
            }
        };
    }
    let ratio = match diagnosis.command_kind {
        CommandKind::Voltage => "R/Kt",
        _ => "1/Kt",
    };
    match diagnosis.identifiable.si {
        Some(known) => format!(
            "Torques in N m follow from the {}: {ratio} = {} {} per N m.",
            known.source.replace('_', " "),
            figure(known.command_per_nm, 4),
            diagnosis.identifiable.friction_v.unit
        ),
        None => "Resistance and torque constant are not identifiable from these recordings: values in N m and kg m^2 are computed with the nominal motor's R and Kt, and are proportional to Kt/R.".to_owned(),
    }
}
