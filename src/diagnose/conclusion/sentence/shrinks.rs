//! Third part: how far the gap shrinks on data kept back.

use super::Beside;
use crate::diagnose::conclusion::words::counts;
use crate::diagnose::report::{Diagnosis, Verdict};
use crate::diagnose::settings::FEW_PIECES;

/// What the model of the verdict leaves, and what other numbers alone leave.
pub(super) fn shrinks(said: &Diagnosis, beside: &Beside) -> Vec<String> {
    let gap = &said.gap;
    let kept = kept(beside);
    let numbers = counts(gap.after_parameters);
    let mut sentences = Vec::new();
    if is_short(beside) {
        sentences.push(
            "These runs are too short to keep pieces back: samples of them take turns.".to_owned(),
        );
    }
    match said.verdict {
        Verdict::NoGap | Verdict::NoChange if beside.is_by_floor => sentences.push(format!(
            "{kept} other numbers leave {numbers} counts: nothing has to shrink."
        )),
        Verdict::NoGap | Verdict::NoChange => sentences.push(format!(
            "{kept} other numbers leave {numbers} counts: no clear gain."
        )),
        Verdict::Parameters if gap.after_parameters >= gap.before => sentences.push(format!(
            "{kept} it does not shrink: other numbers leave {numbers} counts."
        )),
        Verdict::Parameters => {
            sentences.push(format!(
                "{kept} other numbers shrink it to {numbers} counts."
            ));
        }
        Verdict::OutsideCatalogue if gap.after_parameters >= gap.before => sentences.push(format!(
            "{kept} it does not shrink: other numbers leave {numbers} counts."
        )),
        Verdict::OutsideCatalogue => sentences.push(format!(
            "{kept} other numbers shrink it to {numbers} counts, and no known effect further."
        )),
        _ => {
            sentences.extend(beside.inverse_gain.map(|gain| {
                format!(
                    "No simulation explains these runs: motion and command alone show the cause. It takes {:.0} % of what a plain motor leaves there.",
                    100.0 * gain
                )
            }));
            // Where it is not in what is simulated, the gap does not shrink with it.
            if beside.inverse_gain.is_some() && gap.after_effect >= gap.after_parameters {
                sentences.push(format!(
                    "{kept} no simulation with it leaves less than other numbers do: {numbers} counts."
                ));
            } else {
                sentences.push(with_effects(said, beside, kept));
                sentences.push(format!("Other numbers alone leave {numbers}."));
            }
        }
    }
    sentences.extend(of_the_fitted(said, beside));
    sentences
}

/// Whether the runs are few pieces, of which samples are kept back and no piece.
fn is_short(beside: &Beside) -> bool {
    !beside.is_held_out && beside.pieces < FEW_PIECES
}

/// On which data, as a sentence begins.
fn kept(beside: &Beside) -> &'static str {
    match (beside.is_held_out, is_short(beside)) {
        (true, _) => "On the runs held out,",
        (false, true) => "On samples kept back from the fit,",
        (false, false) => "On data kept back from the fit,",
    }
}

/// With the likeliest effects. What is closed is rounded down: what is left must not be hidden.
fn with_effects(said: &Diagnosis, beside: &Beside, kept: &str) -> String {
    let gap = &said.gap;
    let with = match (said.effects.len(), beside.tied.len()) {
        (_, 2..) => "with the likeliest of them",
        (2.., _) => "with them",
        _ => "with it",
    };
    let left = counts(gap.after_effect);
    let closed = (100.0 * gap.closed).floor();
    if closed > 0.0 && gap.after_parameters <= gap.after_effect {
        format!("{kept} the gap shrinks to {left} counts {with}, and as far without.")
    } else if closed > 0.0 {
        format!(
            "{kept} the gap shrinks to {left} counts {with}: {closed:.0} % of what exceeds the floor."
        )
    } else if gap.after_effect < gap.before {
        format!("{kept} the gap shrinks to {left} counts {with}, which may be chance.")
    } else {
        format!("{kept} the gap does not shrink: {left} counts {with}.")
    }
}

/// The same model on the runs that it was fitted to, where others are held out.
fn of_the_fitted(said: &Diagnosis, beside: &Beside) -> Option<String> {
    let fitted = &said.gap.fitted;
    let left = match said.verdict {
        Verdict::NoGap | Verdict::NoChange => fitted.before,
        Verdict::Parameters | Verdict::OutsideCatalogue => fitted.after_parameters,
        _ => fitted.after_effect,
    };
    (beside.is_held_out).then(|| {
        format!(
            "On the runs that were fitted the same model leaves {}.",
            counts(left)
        )
    })
}
