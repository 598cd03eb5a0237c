//! The error budget as table and bars, for page and terminal.

use crate::diagnose::{
    BudgetStep, Diagnosis, LEAST_PRINTED, Verdict, is_cross_validated, is_nominal_fitted,
};
use crate::report::number::{figure, percent, probability};
use crate::report::{Bar, Bars, Scale};

/// The model of a row; where the nominal one was fitted to the same runs, also the data of its error.
fn model_words(diagnosis: &Diagnosis, step: &BudgetStep) -> &'static str {
    let is_fitted = is_nominal_fitted(diagnosis);
    match (step.step, is_fitted, is_cross_validated(&diagnosis.gap)) {
        ("nominal", true, true) => "nominal (fitted data)",
        ("nominal", true, false) => "nominal (fitted to all samples)",
        ("parameters", true, true) => "re-identified parameters (held out)",
        ("parameters", true, false) => "re-identified parameters (fitted to a part)",
        ("parameters", false, _) => "re-identified parameters",
        (step, ..) => step,
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
    "model",
    "RMS error (counts)",
    "share",
    "95\u{a0}% interval",
    "alternatives (inclusion probability)",
];

/// Whether shares are printed: not where the nominal model is within the noise floor, or fitted to the same data.
fn has_shares(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict != Verdict::NoGap && !is_nominal_fitted(diagnosis)
}

/// A figure of a share, if shares are printed.
fn shares(diagnosis: &Diagnosis, of: impl Fn() -> String) -> String {
    match has_shares(diagnosis) {
        false => "\u{2013}".to_owned(),
        true => of(),
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
            model_words(diagnosis, step).to_owned(),
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

/// Reference of the shares in the budget, or why there are none.
pub fn budget_note(diagnosis: &Diagnosis) -> String {
    if has_shares(diagnosis) {
        return "Share: the part of the nominal model's held-out squared error above the noise floor (nominal: 100\u{a0}% by definition) that a row removes beyond the rows above it, negative where it adds error. So an effect's share is what it removes beyond re-identified parameters. Unexplained: the part that remains.".to_owned();
    }
    let mut notes = Vec::new();
    if diagnosis.verdict == Verdict::NoGap {
        notes.push("The error of the nominal model is not significantly above the noise floor.");
    }
    if is_nominal_fitted(diagnosis) {
        notes.push(match is_cross_validated(&diagnosis.gap) {
            true => "The nominal row is the error on the fitted data, the other rows are cross-validated (held out): not comparable.",
            false => "The nominal row is fitted to all samples, the other rows to a part of them: not comparable.",
        });
    }
    format!("Shares are not printed. {}", notes.join(" "))
}

/// The error budget as a bar chart.
pub fn budget_bars(diagnosis: &Diagnosis) -> Bars {
    let has_shares = has_shares(diagnosis);
    let bar = |step: &BudgetStep| Bar {
        name: model_words(diagnosis, step).to_owned(),
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
