//! Level after level, until what promises most is not there.

use crate::diagnose::fit::Fit;
use crate::diagnose::fit::{Base, Model, Most, fit, rounding};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::screening::{Pick, picks};
use crate::diagnose::settings::{
    CHANCE, CLOSES, INVERSE_DECIDES, LEAST_GAIN, MOST_EFFECTS, MOST_WANDER, ROUNDING,
    WITHIN_TOLERANCES,
};
use crate::diagnose::validation::{Presence, Tie, standing};
use crate::recording::Run;

use super::Sought;

/// One level as it was judged.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    /// What it adds to.
    pub from: Fit,
    /// Rivals of one more effect, best first.
    pub fits: Vec<Fit>,
    /// How each stands to the first; the last is that of `from`.
    pub standings: Vec<Tie>,
    /// What each effect promised before it was fitted, in nats.
    pub screened: Vec<(&'static str, f64)>,
    pub presence: Presence,
    /// Share of the mean square above rounding that the first closes.
    pub closes: f64,
    /// Whether it is there.
    pub is_kept: bool,
    /// Whether the inverse form decides it, not the simulation.
    pub is_inverse: bool,
}

impl Judged {
    /// Why it is kept or dropped, in words.
    pub fn why(&self) -> String {
        if self.is_inverse {
            return "no simulation explains the runs: the inverse form decides".to_owned();
        }
        if self.is_kept {
            return "more than chance makes, and part of what the gap is".to_owned();
        }
        if self.presence.p_value() > CHANCE {
            return "chance makes as much".to_owned();
        }
        format!(
            "nothing predicts better and closes {:.0} % of the gap",
            100.0 * CLOSES
        )
    }

    /// Rivals that are not told from the first, which is one of them.
    pub fn tied(&self) -> impl Iterator<Item = (&Fit, &Tie)> {
        let pairs = self.fits.iter().zip(&self.standings);
        pairs.filter(|(_, standing)| standing.is_tied)
    }
}

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
        // What gains and leaves more of the position than before is no cause of the gap: rivals are those that close some of it.
        let is_eligible = |fit: &Fit| is_a_cause(&best, fit, still);
        let (mut fits, others): (Vec<Fit>, Vec<Fit>) =
            level.fits.into_iter().partition(is_eligible);
        let is_any = !fits.is_empty();
        let standings = if is_any {
            let rivals: Vec<&Fit> = fits.iter().chain(std::iter::once(&best)).collect();
            let mut standings = standing(&rivals);
            let of_none = standings.pop();
            let score = fits[0].score();
            standings.extend(others.iter().map(|fit| Tie::apart(score - fit.score())));
            standings.extend(of_none);
            standings
        } else {
            standing(
                &others
                    .iter()
                    .chain(std::iter::once(&best))
                    .collect::<Vec<&Fit>>(),
            )
        };
        fits.extend(others);
        let closes = fits
            .first()
            .map_or(0.0, |first| closed(&best, first, still));
        let is_kept = presence.p_value() <= CHANCE && is_any;
        let judged = Judged {
            from: best.clone(),
            fits,
            standings,
            screened: level.screened,
            presence,
            closes,
            is_kept,
            is_inverse: false,
        };
        if is_kept {
            let names: Vec<Vec<&'static str>> =
                judged.tied().map(|(fit, _)| fit.model.ids()).collect();
            sets = names
                .iter()
                .filter(|set| simpler_of(set, &names).is_none())
                .cloned()
                .collect();
            let chosen = (judged.fits.iter()).find(|fit| sets.first() == Some(&fit.model.ids()));
            best = chosen.unwrap_or(&judged.fits[0]).clone();
        }
        levels.push(judged);
        // What was found in the place of what scatters goes again: the search begins anew with that.
        if is_kept
            && sought == Sought::Scattering
            && levels.len() > 1
            && is_enough_alone(pieces, base, &best, still)
        {
            best = refitted.clone();
            sets.clear();
            levels.clear();
            continue;
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

/// Whether what scatters, the last of a set, predicts as well without the others, and leaves no more.
fn is_enough_alone(pieces: &Pieces, base: &Base, best: &Fit, still: f64) -> bool {
    let last = best.model.members.last().cloned();
    let model = Model::new(base, last.into_iter().collect());
    let starts = [model.start_from(&best.model, &best.x), model.start()];
    let most = Most::beside(best.mean_square());
    let alone = fit(pieces, &model, base.kind, &starts, most);
    alone.is_some_and(|alone| {
        alone.score() + LEAST_GAIN >= best.score() && closed(&alone, best, still) < CLOSES
    })
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
        fits,
        standings,
        screened: level.screened.clone(),
        presence: level.presence.clone(),
        is_kept: true,
        is_inverse: true,
    })
}

/// Whether what a fit has more than the one before it is a cause of the gap, where a right model leaves the mean square `still`.
fn is_a_cause(before: &Fit, fit: &Fit, still: f64) -> bool {
    let gained = fit.score() - before.score();
    let closes = closed(before, fit, still);
    let above = |fit: &Fit| fit.mean_square() - still;
    let leaves_no_more = above(fit) <= above(before).max(0.0) + still;
    // What frees a bent motor leaves no more than that, but for rounding.
    let unbends = before.prior - fit.prior > LEAST_GAIN && leaves_no_more;
    // It closes a tenth of what rounding leaves; a further one as much as that: where the law of the first is a little other, less is
    // left.
    let least = if before.model.members.is_empty() {
        CLOSES * still
    } else {
        still
    };
    let matters = closes * above(before) >= least;
    // What scatters is not predicted: it is told by how it does. It leaves no more, either.
    let scatters = before.around.is_stiller_than(&fit.around) && leaves_no_more;
    let predicts = gained > 0.0 && closes >= CLOSES && matters;
    predicts || gained >= LEAST_GAIN && (unbends || scatters)
}

/// Share of the mean square above what a right model leaves that a fit closes.
fn closed(before: &Fit, after: &Fit, still: f64) -> f64 {
    let above = before.mean_square() - still;
    if above <= 0.0 {
        return 0.0;
    }
    (above - (after.mean_square() - still)) / above
}

/// The set among these that has the plain effect where this one has the same by direction: what holds for both directions alike.
pub(crate) fn simpler_of(
    set: &[&'static str],
    sets: &[Vec<&'static str>],
) -> Option<Vec<&'static str>> {
    set.iter().find_map(|id| {
        let plain = id.strip_prefix("asymmetric_")?;
        let mut simpler: Vec<&str> = set
            .iter()
            .map(|other| if other == id { plain } else { other })
            .collect();
        simpler.sort_unstable();
        sets.iter().find(|other| **other == simpler).cloned()
    })
}
