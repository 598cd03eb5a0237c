//! Which sets are in play after a search.

use super::separation_of;
use crate::diagnose::fit::Fit;
use crate::diagnose::pieces::Pieces;
use crate::diagnose::selection::Forward;
use crate::diagnose::settings::{
    FOLDS, IN_PLAY_NATS, IN_PLAY_SHARE, LEAST_GAIN, MOST_IN_PLAY, TIE,
};

/// Why a set is in play, the strongest reason first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Reason {
    /// It is the best.
    Best,
    /// The search did not tell it from the best.
    Tied,
    /// It is not implausible.
    Plausible,
    /// It gains, though chance makes as much; or pieces are too few to judge by.
    Gains,
    /// It is near, and these runs do not separate it from the best.
    Near,
}

/// The sets that are still in play, the best first, and how many of them the search itself leaves open; each set has a share of
/// the probability.
pub(super) fn in_play<'a>(
    pieces: &Pieces,
    found: &'a Forward,
    share_of: &dyn Fn(&[&'static str]) -> f64,
) -> (Vec<&'a Fit>, usize) {
    let share = |fit: &Fit| share_of(&fit.model.ids());
    let best = &found.best;
    // Each with what it adds to.
    let mut all: Vec<(&Fit, Option<&Fit>)> = vec![(best, None)];
    let of_levels = (found.levels.iter())
        .flat_map(|level| level.fits.iter().map(|fit| (fit, Some(&level.from))));
    for (fit, from) in std::iter::once((&found.refitted, None)).chain(of_levels) {
        let is_new = |(one, _): &(&Fit, Option<&Fit>)| one.model.ids() != fit.model.ids();
        if all.iter().all(is_new) {
            all.push((fit, from));
        }
    }
    let likeliest = all.iter().map(|(fit, _)| share(fit)).fold(0.0, f64::max);
    // With fewer pieces than folds, what is kept back is another regime: only the fit itself says something.
    let are_few = pieces.pieces.len() < FOLDS;
    let worth = |fit: &Fit| {
        if are_few { -fit.cost() } else { fit.score() }
    };
    let reason = |fit: &Fit, from: Option<&Fit>| {
        let behind = worth(best) - worth(fit);
        let is_plausible = share(fit) >= IN_PLAY_SHARE * likeliest && behind <= IN_PLAY_NATS;
        if fit.model.ids() == best.model.ids() {
            Some(Reason::Best)
        } else if found.sets.contains(&fit.model.ids()) {
            Some(Reason::Tied)
        } else if is_within(best, fit) {
            let has_more = fit.model.members.len() > best.model.members.len();
            if has_more && is_plausible {
                Some(Reason::Plausible)
            } else {
                (behind <= -LEAST_GAIN).then_some(Reason::Gains)
            }
        } else if is_plausible {
            Some(Reason::Plausible)
        } else if are_few && from.is_some_and(|from| worth(fit) >= worth(from) + LEAST_GAIN) {
            Some(Reason::Gains)
        } else {
            let is_near = behind <= IN_PLAY_NATS && separation_of(pieces, best, fit) < TIE;
            is_near.then_some(Reason::Near)
        }
    };
    let mut sets: Vec<(Reason, &Fit)> = (all.into_iter())
        .filter_map(|(fit, from)| Some((reason(fit, from)?, fit)))
        .collect();
    sets.sort_by(|(a, one), (b, other)| {
        let by_share = share(other).total_cmp(&share(one));
        a.cmp(b)
            .then(by_share)
            .then(worth(other).total_cmp(&worth(one)))
    });
    sets.truncate(MOST_IN_PLAY);
    let is_open = |(reason, _): &&(Reason, &Fit)| *reason <= Reason::Plausible;
    let open = sets.iter().filter(is_open).count();
    (sets.into_iter().map(|(_, fit)| fit).collect(), open)
}

/// Whether a fit has all effects of another and more, or one by direction in the place of the plain one: for some of its numbers it
/// is the other.
pub(super) fn is_within(small: &Fit, large: &Fit) -> bool {
    let (small, large) = (small.model.ids(), large.model.ids());
    let has = |id: &&str| {
        let mut others = large.iter();
        others.any(|other| other == id || other.strip_prefix("asymmetric_") == Some(id))
    };
    small != large && small.iter().all(has)
}
