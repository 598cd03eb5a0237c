//! The search as the document tells it: a step a level, and the look for something unknown.

use crate::diagnose::report::{Gap, INVERSE_FORM, PREDICTION, Rival, Step, Term};
use crate::diagnose::selection::{Forward, Judged};
use crate::diagnose::validation::Unknown;

/// The inverse form, the levels of a search, and the look for something unknown.
pub(crate) fn steps(found: &Forward, unknown: &Unknown) -> Vec<Step> {
    let mut steps: Vec<Step> = inverse_form(found).into_iter().collect();
    let levels = found.levels.iter().enumerate();
    steps.extend(levels.map(|(k, level)| step(k + 1, level)));
    let (is_there, chance) = (unknown.is_there(), unknown.chance());
    let as_much = unknown
        .by_chance
        .iter()
        .filter(|gain| **gain >= unknown.gain);
    steps.push(Step {
        name: "unknown".to_owned(),
        from: found.best.model.ids(),
        left_counts: found.best.mean_square().sqrt(),
        rivals: Vec::new(),
        screened: Vec::new(),
        terms: Vec::new(),
        gain: unknown.gain,
        chance,
        p_value: (as_much.count() + 1) as f64 / (unknown.by_chance.len() + 1) as f64,
        closes: 0.0,
        is_kept: is_there,
        why: match is_there {
            true => {
                "a torque of many shapes, or the piece predicted worst, is beyond chance".to_owned()
            }
            false => "a torque of many shapes gains no more than chance makes".to_owned(),
        },
    });
    steps
}

/// What each term of the inverse form takes; none where too little moves for it.
fn inverse_form(found: &Forward) -> Option<Step> {
    let best = found.inverse.first()?;
    let is_deciding = found.levels.iter().any(|level| level.is_inverse);
    let why = if is_deciding {
        "no simulation explains the runs, so that this form decides"
    } else if best.is_seen() {
        "the effects of the best are fitted from the motor that it has found"
    } else {
        "no term stands out of its own error"
    };
    let terms = found.inverse.iter().map(|pick| Term {
        effects: pick.form.ids().to_vec(),
        order: pick.order(),
        gain: pick.gain,
        error: pick.error,
        is_tied: best.is_tied_with(pick),
    });
    Some(Step {
        name: INVERSE_FORM.to_owned(),
        from: Vec::new(),
        left_counts: found.refitted.mean_square().sqrt(),
        rivals: Vec::new(),
        screened: Vec::new(),
        terms: terms.collect(),
        gain: 0.0,
        chance: 0.0,
        p_value: 1.0,
        closes: best.gain.max(0.0),
        is_kept: is_deciding,
        why: why.to_owned(),
    })
}

/// What is kept, asked once more: whether it predicts what was not fitted. None where nothing is kept.
pub(super) fn prediction(found: &Forward, gap: &Gap, borne_out: f64) -> Option<Step> {
    let from = found.best.model.ids();
    (!from.is_empty()).then(|| Step {
        name: PREDICTION.to_owned(),
        from,
        left_counts: gap.after_effect,
        rivals: Vec::new(),
        screened: Vec::new(),
        terms: Vec::new(),
        gain: 0.0,
        chance: 0.0,
        p_value: 1.0 - borne_out,
        closes: 1.0 - (gap.after_effect / gap.after_parameters.max(f64::MIN_POSITIVE)).powi(2),
        is_kept: borne_out >= 0.5,
        why: format!(
            "on pieces not fitted it leaves no more than other numbers alone with probability {borne_out:.2}"
        ),
    })
}

/// A level as a part of the table.
fn step(number: usize, level: &Judged) -> Step {
    let standings = level.fits.iter().zip(&level.standings);
    Step {
        name: format!("level {number}"),
        from: level.from.model.ids(),
        left_counts: level.from.mean_square().sqrt(),
        rivals: standings
            .map(|(fit, standing)| Rival {
                effects: fit.model.ids(),
                gains: fit.score() - level.from.score(),
                behind: standing.behind,
                error: standing.error,
                is_tied: standing.is_tied,
                left_counts: fit.mean_square().sqrt(),
                wander: fit.noise.strength,
            })
            .collect(),
        screened: level.screened.clone(),
        terms: Vec::new(),
        gain: level.presence.gain,
        chance: level.presence.by_chance.last().copied().unwrap_or(0.0),
        p_value: level.presence.p_value(),
        closes: level.closes,
        is_kept: level.is_kept,
        why: level.why(),
    }
}
