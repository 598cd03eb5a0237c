//! One level as it is judged: which rivals are a cause of the gap, and which of them are not told from the best.

use crate::diagnose::fit::{Fit, Most};
use crate::diagnose::settings::{CLOSES, LEAST_GAIN};
use crate::diagnose::validation::{Presence, Tie, standing};

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
    /// Whether that is worth an effect.
    pub matters: bool,
    /// Whether it is there.
    pub is_kept: bool,
    /// Whether the inverse form decides it, not the simulation.
    pub is_inverse: bool,
    /// Members of the set before that it does as well without.
    pub gone: Vec<&'static str>,
    /// Whether a later level was judged in its place.
    pub is_set_aside: bool,
}

impl Judged {
    /// Rivals that add to a set, in any order, where a right model leaves the mean square `still`.
    pub fn new(from: &Fit, mut rivals: Vec<Fit>, presence: Presence, still: f64) -> Self {
        rivals.sort_by(|a, b| b.score().total_cmp(&a.score()));
        // What gains and leaves more of the position than before is no cause of the gap: rivals are those that close some of it.
        let (mut fits, others): (Vec<Fit>, Vec<Fit>) =
            (rivals.into_iter()).partition(|fit| is_a_cause(from, fit, still));
        let is_any = !fits.is_empty();
        let compared = if is_any { &fits } else { &others };
        let mut standings = standing(&compared.iter().chain([from]).collect::<Vec<&Fit>>());
        if let Some(best) = fits.first() {
            let of_none = standings.pop();
            let behind = |fit: &Fit| Tie::apart(best.score() - fit.score());
            standings.extend(others.iter().map(behind));
            standings.extend(of_none);
        }
        fits.extend(others);
        let first = fits.first();
        let closes = first.map_or(0.0, |first| closed(from, first, still));
        let matters = first.is_some_and(|first| matters(from, first, still));
        Self {
            matters,
            is_kept: !presence.is_by_chance() && is_any,
            from: from.clone(),
            fits,
            standings,
            screened: Vec::new(),
            presence,
            closes,
            is_inverse: false,
            gone: Vec::new(),
            is_set_aside: false,
        }
    }

    /// Why it is kept or dropped, in words.
    pub fn why(&self) -> String {
        if self.is_inverse {
            return "no simulation explains the runs: the inverse form decides".to_owned();
        }
        if !self.gone.is_empty() {
            return format!("as much is predicted without {}", self.gone.join(", "));
        }
        if self.is_kept {
            return "more than chance makes, and part of what the gap is".to_owned();
        }
        if self.presence.is_by_chance() {
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

    /// The set that the search goes on from, and those that are not told from it, itself the first.
    pub fn chosen(&self) -> (Fit, Vec<Vec<&'static str>>) {
        let names: Vec<Vec<&'static str>> = self.tied().map(|(fit, _)| fit.model.ids()).collect();
        let sets: Vec<Vec<&'static str>> = (names.iter())
            .filter(|set| simpler_of(set, &names).is_none())
            .cloned()
            .collect();
        let chosen = (self.fits.iter()).find(|fit| sets.first() == Some(&fit.model.ids()));
        (chosen.unwrap_or(&self.fits[0]).clone(), sets)
    }
}

/// Whether what a fit has more than the one before it is a cause of the gap, where a right model leaves the mean square `still`.
fn is_a_cause(before: &Fit, fit: &Fit, still: f64) -> bool {
    let gained = fit.score() - before.score();
    let leaves_no_more = Most::beside(before.mean_square()).allows(fit.mean_square());
    // What frees a bent motor, or scatters and so predicts nothing, leaves no more.
    let unbends = before.prior - fit.prior > LEAST_GAIN && leaves_no_more;
    let scatters = before.around.is_stiller_than(&fit.around) && leaves_no_more;
    let predicts = gained > 0.0 && matters(before, fit, still);
    predicts || gained >= LEAST_GAIN && (unbends || scatters)
}

/// Whether a fit closes what is worth it of what the one before it leaves: a tenth, and no less than a tenth of what rounding leaves. A
/// further effect closes as much as rounding leaves: where the law of the first is a little other, less is left.
fn matters(before: &Fit, fit: &Fit, still: f64) -> bool {
    let closes = closed(before, fit, still);
    let least = if before.model.members.is_empty() {
        CLOSES * still
    } else {
        still
    };
    closes >= CLOSES && closes * (before.mean_square() - still) >= least
}

/// Share of the mean square above what a right model leaves that a fit closes.
pub(super) fn closed(before: &Fit, after: &Fit, still: f64) -> f64 {
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
