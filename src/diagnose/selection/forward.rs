//! Level after level, until what promises most is not there.

use rayon::prelude::*;

use crate::diagnose::fit::{Base, Fit, Model, Most, fit, rounding};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::screening::{Pick, picks};
use crate::diagnose::settings::{
    INVERSE_DECIDES, MOST_EFFECTS, MOST_WANDER, ROUNDING, WITHIN_TOLERANCES,
};
use crate::diagnose::validation::standing;
use crate::recording::Run;

use super::backward::backward;
use super::judged::{Judged, closed};
use super::{Sought, with};

/// All levels.
#[derive(Debug, Clone)]
pub(crate) struct Forward {
    /// The motor refitted, without any effect.
    pub refitted: Fit,
    /// What rounding and the measured starts leave of a right model, a mean square in counts^2.
    pub still: f64,
    /// The best set.
    pub best: Fit,
    pub levels: Vec<Judged>,
    /// Terms of the inverse form, most first.
    pub inverse: Vec<Pick>,
    /// Sets that are not told from the best, which is the first.
    pub sets: Vec<Vec<&'static str>>,
}

/// The whole search over the pieces of these runs; `None` where the motor makes no motion at all.
pub(crate) fn forward(
    runs: &[Run],
    pieces: &Pieces,
    base: &Base,
    progress: &dyn Fn(&str),
) -> Option<Forward> {
    let model = Model::new(base, Vec::new());
    let most = Most::of_start(pieces, &model, base.kind)?;
    let refitted = fit(pieces, &model, base.kind, &[model.start()], most)?;
    // The runs are cut for the motor that they are simulated with.
    let motor = refitted.model.motor(&refitted.x);
    let still = (Pieces::new(runs, &motor).ok())
        .and_then(|own| {
            rounding(
                runs,
                &own,
                (&motor, refitted.around.time_constant_s),
                base.kind,
            )
        })
        // A motor that cannot be simulated so far ahead: rounding of a sample (Widrow).
        .unwrap_or(ROUNDING);
    let mut best = refitted.clone();
    let mut levels: Vec<Judged> = Vec::new();
    let mut sets: Vec<Vec<&'static str>> = Vec::new();
    let mut sought = Sought::Predicting;
    let inverse = picks(pieces);
    let pick = inverse.first().filter(|pick| pick.is_seen());
    while best.model.members.len() < MOST_EFFECTS {
        match sets.first() {
            None => progress("looking for an effect"),
            Some(set) => progress(&format!("looking beside {}", set.join(", "))),
        }
        let Some(level) = super::level(
            pieces,
            base,
            &best,
            sought,
            pick.filter(|_| best.model.members.is_empty()),
        ) else {
            break;
        };
        let Some(presence) = level.presence else {
            break;
        };
        let mut judged = Judged::new(&best, level.fits, presence, still);
        // What was not told from the best before is asked again beside what is kept now.
        if judged.is_kept
            && let Some(before) = levels.iter().rfind(|level| level.is_kept)
        {
            let others = swapped(pieces, base, before, &judged.fits[0]);
            if !others.is_empty() {
                let mut fits = judged.fits;
                fits.extend(others);
                judged = Judged::new(&best, fits, judged.presence, still);
            }
        }
        judged.screened = level.screened;
        let is_kept = judged.is_kept;
        if is_kept {
            (best, sets) = judged.chosen();
        }
        levels.push(judged);
        // What stood for a cause until the cause itself was found goes again.
        let standing: Vec<&Judged> = levels.iter().filter(|level| !level.is_set_aside).collect();
        if is_kept
            && let Some((stand, without)) = backward(pieces, base, &standing, &best, still)
            && let (smaller, smaller_sets) = without.chosen()
            // A search that came by a set goes on from it once.
            && levels.iter().all(|level| level.from.model.ids() != smaller.model.ids())
        {
            let set_aside = levels.iter_mut().filter(|level| !level.is_set_aside);
            set_aside
                .skip(stand)
                .for_each(|level| level.is_set_aside = true);
            (best, sets) = (smaller, smaller_sets);
            levels.push(without);
        }
        sought = match (is_kept, sought) {
            (true, _) => Sought::Predicting,
            (false, Sought::Predicting) => Sought::Scattering,
            (false, Sought::Scattering) => break,
        };
    }
    // What is found in the errors of a motor that no simulation bears out is not kept, where the inverse form has a cause.
    if !is_usable(&best)
        && let Some(decided) = levels
            .first()
            .and_then(|first| by_inverse(first, &inverse, still))
    {
        best = decided.fits[0].clone();
        sets = decided.tied().map(|(fit, _)| fit.model.ids()).collect();
        levels = vec![decided];
    }
    Some(Forward {
        refitted,
        still,
        best,
        levels,
        inverse,
        sets,
    })
}

/// What a level kept last, beside each of those that were not told from the best of the level before.
fn swapped(pieces: &Pieces, base: &Base, before: &Judged, best: &Fit) -> Vec<Fit> {
    let Some(new) = best.model.members.last() else {
        return Vec::new();
    };
    let has = |fit: &Fit, ids: &[&str]| ids.iter().all(|id| fit.model.ids().contains(id));
    let others = before.tied().map(|(fit, _)| fit);
    let others = others.filter(|fit| !has(best, &fit.model.ids()) && !has(fit, &[new.id()]));
    let others: Vec<&Fit> = others.collect();
    let beside = others.into_par_iter().filter_map(|other| {
        let model = Model::new(base, with(other, new.clone()));
        let of_best = model.start_from(&best.model, &best.x);
        let of_both = model.taken_from(of_best.clone(), &other.model, &other.x);
        let starts = [of_both, of_best, model.start()];
        let most = Most::beside(other.mean_square());
        fit(pieces, &model, base.kind, &starts, most)
    });
    beside.collect()
}

/// Whether a simulation bears a recording out: with no load that shakes as no bench does, and with a motor as the file may have it.
fn is_usable(best: &Fit) -> bool {
    best.noise.strength <= MOST_WANDER && best.model.bent(&best.x) <= WITHIN_TOLERANCES
}

/// A level as the inverse form decides it: kept are the effects that it points at, and those that it does not tell from them. None where
/// it is not sure, or where none of them can be simulated.
fn by_inverse(level: &Judged, picks: &[Pick], still: f64) -> Option<Judged> {
    let best = picks
        .first()
        .filter(|pick| pick.gain >= INVERSE_DECIDES && pick.is_seen())?;
    let tied = picks.iter().filter(|pick| best.is_tied_with(pick));
    let ids: Vec<&str> = tied.flat_map(|pick| pick.form.ids()).copied().collect();
    let is_meant = |fit: &&Fit| matches!(&fit.model.ids()[..], [id] if ids.contains(id));
    let fits: Vec<Fit> = level.fits.iter().filter(is_meant).cloned().collect();
    let rivals: Vec<&Fit> = fits.iter().collect();
    if rivals.is_empty() {
        return None;
    }
    let mut standings = standing(&rivals);
    standings
        .iter_mut()
        .for_each(|standing| standing.is_tied = true);
    Some(Judged {
        from: level.from.clone(),
        closes: closed(&level.from, &fits[0], still),
        matters: true,
        fits,
        standings,
        screened: level.screened.clone(),
        presence: level.presence.clone(),
        is_kept: true,
        is_inverse: true,
        gone: Vec::new(),
        is_set_aside: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::{base_of, fitted, member, motor_with, present, recording};
    use crate::motor::Motor;

    /// A constant load and a friction by direction are not told apart by many recordings: beside what is found next, neither is forgotten.
    #[test]
    fn what_was_not_told_apart_is_asked_again_beside_the_next() {
        let motor = motor_with(&[("constant_load", &[0.01]), ("dead_zone", &[1.3])]);
        let pieces = Pieces::new(&[recording(&motor, 1000)], &Motor::default()).expect("a run");
        let base = base_of(&pieces);
        let fitted = |members: &[_]| fitted(&pieces, &base, members);
        let (load, friction) = (
            member("constant_load", 0.01),
            member("asymmetric_friction", 0.2),
        );
        let rivals = vec![fitted(std::slice::from_ref(&load)), fitted(&[friction])];
        let mut before = Judged::new(&fitted(&[]), rivals, present(), ROUNDING);
        let standings = before.standings.iter_mut();
        standings.for_each(|tie| tie.is_tied = true);
        let best = fitted(&[load, member("dead_zone", 1.3)]);
        let others = swapped(&pieces, &base, &before, &best);
        let names: Vec<Vec<&str>> = others.iter().map(|fit| fit.model.ids()).collect();
        assert_eq!(names, [["asymmetric_friction", "dead_zone"]]);
    }
}
