//! Texts that page and terminal share.

use crate::diagnose::{
    BudgetStep, Cause, Diagnosis, EffectClass, Gap, Interval, MotorFileValues, NominalSource,
    ReferenceRuns, Settings, without_assumed_unit,
};
use crate::diagnose::{LEAST_PRINTED, Verdict, class_of};
use crate::motor::CommandKind;
use crate::motor::catalogue::{EffectKind, catalogue};
use crate::report::number::{figure, percent, probability, probability_of};
use crate::report::{Bar, Bars, Scale};

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
    format!(
        "{}: {}. Nominal model: {nominal}.",
        verdict.id(),
        verdict.meaning()
    )
}

/// An effect with its description.
pub fn cause_words(id: &str) -> String {
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
pub fn of_reference(reference: &ReferenceRuns) -> String {
    let effects = match reference.effects.as_slice() {
        [] => "no effect beside the motor file's own".to_owned(),
        effects => effects.join(" + "),
    };
    format!(
        "Reference: {}. Its model has {effects}; residual RMS {} counts.",
        reference.runs.join(", "),
        figure(reference.rms_counts, 3)
    )
}

/// Whether a further recording is optional, since the sentence proposes another step.
pub fn is_optional(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict == Verdict::Parameters
        && diagnosis.probability >= Settings::default().identified
}

/// The first few names, and the number of the others.
pub fn few_words(names: &[String]) -> String {
    let named = names[..names.len().min(NAMED)].iter();
    let named = named.map(|name| if name == "none" { "no effect" } else { name });
    let named = named.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(NAMED) {
        0 => named,
        others => format!("{named} and {others} more"),
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

/// The prediction error of all figures, and how data were held out.
pub fn measured(gap: &Gap) -> String {
    let parts = gap.floor_parts;
    let part = |name: &str, counts: Option<f64>| {
        counts.map(|counts| format!("{name} {}", figure(counts, 3)))
    };
    let parts = [
        part("quantization", Some(parts.rounding)),
        part("random load and random effects", parts.random),
        part("repeatability", parts.repeats),
        part("good enough", parts.good_enough),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!(
        "Prediction error of the position over segments of {} s (median), {}. Held out: {}. Noise floor {} counts ({}).",
        figure(gap.horizon_s, 3),
        match gap.travel {
            0.0 => "of which more than half are at standstill".to_owned(),
            travel => format!(
                "in which the shaft travels {} counts (median)",
                figure(travel, 4)
            ),
        },
        gap.held_out,
        figure(gap.floor, 3),
        parts.join(", ")
    )
}

/// The same models on the training data.
pub fn fitted_words(gap: &Gap) -> String {
    let fitted = gap.fitted;
    format!(
        "On the fitted data: {} counts nominal, {} with re-identified parameters, {} with effects.",
        figure(fitted.before, 3),
        figure(fitted.after_parameters, 3),
        figure(fitted.after_effect, 3)
    )
}

/// Order of the sets, and what their RMS does not say.
pub fn sets_note(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.scoring.score {
        "likelihood" => {
            "Sorted by log score, not by RMS: the likelihood weights each residual by its expected variance (quantization and random load torque), so the RMS of a larger set may exceed that of a smaller one."
        }
        _ => {
            "Sorted by log score: the logarithm of the RMS of independent observations, less a penalty for every parameter."
        }
    }
}

/// The class of an effect; where these runs do not separate its members, the probability that one of them is present.
/// `None` without a class.
pub fn class_of_cause(cause: &Cause) -> Option<String> {
    let class = class_of(cause.effect)?;
    Some(match cause.class_probability {
        Some(p) => format!("one of class {class}: {}", probability(p)),
        None => format!("class {class}"),
    })
}

/// A step of the error budget.
pub fn step_words(step: &BudgetStep) -> &'static str {
    match step.step {
        "parameters" => "re-identified parameters",
        step => step,
    }
}

/// A 95 % interval of a share.
pub fn share_interval(lo95: f64, hi95: f64) -> String {
    let [lo95, hi95] = [lo95, hi95].map(share);
    format!("{} to {hi95}", lo95.trim_end_matches("\u{a0}%"))
}

/// A share in percent; smaller ones than a tenth of a percent have no figure.
fn share(share: f64) -> String {
    match share.abs() {
        size if size < 1e-5 => percent(0.0),
        size if size < LEAST_PRINTED && share > 0.0 => "< 0.1\u{a0}%".to_owned(),
        _ => percent(share),
    }
}

/// Column names of [`budget_rows`]; the last one only if a step has alternatives.
pub const BUDGET_COLUMNS: [&str; 5] = [
    "step",
    "RMS error after it (counts)",
    "share",
    "95\u{a0}% interval",
    "alternatives (inclusion probability)",
];

/// A figure of a share, which is not defined where the nominal model is within the noise floor.
fn shares(diagnosis: &Diagnosis, of: impl Fn() -> String) -> String {
    match diagnosis.verdict {
        Verdict::NoGap => "\u{2013}".to_owned(),
        _ => of(),
    }
}

/// The error budget, a row per step.
pub fn budget_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let has_alternatives = (diagnosis.budget.iter()).any(|step| !step.alternatives.is_empty());
    let row = |step: &BudgetStep| {
        let alternatives = step.alternatives.iter();
        let alternatives: Vec<String> = alternatives
            .map(|one| format!("{} ({})", one.effect, probability(one.probability)))
            .collect();
        let mut row = vec![
            step_words(step).to_owned(),
            figure(step.rms_counts, 3),
            shares(diagnosis, || share(step.share)),
            shares(diagnosis, || share_interval(step.lo95, step.hi95)),
        ];
        if has_alternatives {
            row.push(match alternatives.is_empty() {
                true => "\u{2013}".to_owned(),
                false => alternatives.join(", "),
            });
        }
        row
    };
    diagnosis.budget.iter().map(row).collect()
}

/// Reference of the shares in the budget.
pub fn budget_note(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.verdict {
        Verdict::NoGap => {
            "No shares: the error of the nominal model is not significantly above the noise floor."
        }
        _ => BUDGET_NOTE,
    }
}

const BUDGET_NOTE: &str = "Share: part of the nominal model's held-out squared error above the noise floor that a step removes, negative where it adds error; unexplained: the part that remains.";

/// The error budget as a bar chart.
pub fn budget_bars(diagnosis: &Diagnosis) -> Bars {
    let has_shares = diagnosis.verdict != Verdict::NoGap;
    let bar = |step: &BudgetStep| Bar {
        name: step_words(step).to_owned(),
        value: if has_shares { step.share } else { 0.0 },
        text: shares(diagnosis, || {
            let interval = share_interval(step.lo95, step.hi95);
            format!("{} (95\u{a0}% {interval})", share(step.share))
        }),
        interval: has_shares.then_some((step.lo95, step.hi95)),
        colour: match step.step {
            "nominal" => 6,
            "parameters" => 4,
            "unexplained" => 2,
            _ => 1,
        },
    };
    Bars {
        title: "Error budget".to_owned(),
        scale: Scale(1.0),
        bars: diagnosis.budget.iter().map(bar).collect(),
    }
}

/// The models in the figures, from the nominal one on.
pub(super) fn models(diagnosis: &Diagnosis) -> Vec<String> {
    let nominal = match diagnosis.reference {
        Some(_) => "reference model",
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
        true => "not fitted".to_owned(),
        false => format!(
            "{} to {}",
            figure(interval.lo95, 4),
            figure(interval.hi95, 4)
        ),
    }
}

/// Name of the column of the motor file's values.
pub const MOTOR_FILE_COLUMN: &str = "motor file";

/// Parameters that voltage and counts determine: name, value, and the motor file's value if one was given.
pub fn identifiable_rows(diagnosis: &Diagnosis) -> Vec<(&'static str, Interval, Option<f64>)> {
    let found = &diagnosis.identifiable;
    let file = found.motor_file;
    let given = |of: fn(&MotorFileValues) -> f64| file.as_ref().map(of);
    let (gain, friction) = match diagnosis.command_kind {
        CommandKind::Voltage => ("steady speed per volt", "Coulomb friction as a voltage"),
        CommandKind::Current => ("steady speed per ampere", "Coulomb friction as a current"),
        CommandKind::Torque => ("steady speed per newton metre", "Coulomb friction"),
    };
    let mut rows = vec![
        (
            gain,
            found.speed_per_volt,
            given(|file| file.speed_per_volt),
        ),
        (
            "mechanical time constant",
            found.time_constant_s,
            given(|file| file.time_constant_s),
        ),
        (friction, found.friction_v, given(|file| file.friction_v)),
    ];
    // Not identified if it was held at its assumed value.
    let electrical = found.electrical_time_constant_s;
    let electrical = electrical.filter(|one| diagnosis.has_torque() || one.lo95 < one.hi95);
    if let Some(electrical) = electrical {
        let given = file.and_then(|file| file.electrical_time_constant_s);
        rows.push(("electrical time constant L/R", electrical, given));
    }
    rows
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

/// Source of figures in N m and kg m^2, or why there are none.
pub fn torque_words(diagnosis: &Diagnosis) -> String {
    if diagnosis.command_kind == CommandKind::Torque {
        return "The command is a torque, so that torques are known in N m.".to_owned();
    }
    if !diagnosis.has_torque() {
        return match diagnosis.command_kind {
            CommandKind::Voltage => "Resistance and torque constant are not known: friction and loads are in V, inductance as L/R. For torques measure the resistance with an ohmmeter, write the motor with `--model-out diagnosed.toml`, then `motorlab motor diagnosed.toml --resistance OHM`.",
            _ => "The torque constant is not known: friction and loads are in units of the command.",
        }
        .to_owned();
    }
    let ratio = match diagnosis.command_kind {
        CommandKind::Voltage => "R/Kt",
        _ => "1/Kt",
    };
    match diagnosis.identifiable.si {
        Some(known) => format!(
            "Torques in N m are known from the {}: {ratio} = {} {} per N m.",
            known.source.replace('_', " "),
            figure(known.command_per_nm, 4),
            diagnosis.identifiable.friction_v.unit
        ),
        None => "Resistance and torque constant are not identifiable from these recordings: values in N m and kg m^2 are computed with the nominal motor's, and change in proportion to them.".to_owned(),
    }
}
