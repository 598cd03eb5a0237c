//! What an effect promises before any fit of it.
//!
//! A regression on short horizons says by how many squares an effect may leave less than the fit so far. Where what promises
//! much leaves nothing, what promises a small share of that is not looked at; where it leaves something, everything is, but for
//! third effects of recordings that are not rough.

use super::periodic::is_scanned;
use super::rivals::catalogue;
use super::search::Start;

/// Squares that a further effect must promise to be fitted beside a set that leaves nothing (the prior of one more effect
/// is worth seven), and those of one whose order is scanned for: some hundred orders promise that by chance.
const LEAST: f64 = 3.0;
const LEAST_SCANNED: f64 = 16.0;
/// Shares of the highest promise from which on an effect is looked at first; looks at one whose order is scanned for cost ten
/// times as much.
const SHARE: f64 = 0.05;
const DEAR_SHARE: f64 = 0.2;
/// Share of the promise of an effect that is known to leave nothing, from which on another may stand in its place.
const SHARE_OF_KNOWN: f64 = 0.3;

/// Where fits of an effect may start, best first.
#[derive(Clone)]
pub(super) struct Prospect {
    /// The effect's index in the catalogue.
    pub index: usize,
    /// The starts.
    pub starts: Vec<Start>,
    /// By how many squares less the effect may leave than the fit so far, on short horizons or on the fit's own: each
    /// start with the magnitude, as a factor of what it does there, that suits it best; of noise of its own as it is there, its
    /// determinants included. Infinite where the base has no regression.
    pub promise: f64,
}

impl Prospect {
    /// Whether it is worth a fit beside a set that leaves nothing.
    pub fn is_worth_it(&self) -> bool {
        let least = if self.is_scanned() {
            LEAST_SCANNED
        } else {
            LEAST
        };
        !self.is_told() || self.promise >= least
    }

    /// Whether its order is scanned for.
    pub fn is_scanned(&self) -> bool {
        is_scanned(catalogue()[self.index].id)
    }

    /// Whether it promises enough of the highest promise for a look that costs ten times as much as others.
    pub fn is_worth_scanning(&self, highest: f64) -> bool {
        self.promise >= DEAR_SHARE * highest
    }

    /// Whether a slope tells what the effect can do: not whether a resolution suits, nor a clock that the host's does not
    /// bear out.
    fn is_told(&self) -> bool {
        let id = catalogue()[self.index].id;
        !matches!(id, "clock_error" | "resolution_error")
    }
}

/// Whether an effect is another value of a number of the motor file: whatever it does, the base gives way to most of it by
/// itself, so that little is left to promise. It has one number and costs little.
fn bends(new: &Prospect) -> bool {
    matches!(
        catalogue()[new.index].id,
        "inertia" | "coulomb_friction" | "viscous_friction" | "supply_error"
    )
}

/// Those that are looked at first, and the others. Beside nothing only what costs much waits; where work is no longer plenty
/// everything does that promises less than that.
pub(super) fn by_promise(
    found: Vec<Prospect>,
    is_alone: bool,
    is_plenty: bool,
) -> (Vec<Prospect>, Vec<Prospect>) {
    let share = if is_plenty { SHARE } else { DEAR_SHARE };
    let promises = found.iter().map(|new| new.promise);
    let highest = promises.filter(|x| x.is_finite()).fold(0.0, f64::max);
    found.into_iter().partition(|new| {
        if new.is_scanned() {
            new.is_worth_scanning(highest)
        } else {
            is_alone
                || !new.is_told()
                || (!is_plenty && bends(new))
                || new.promise >= share * highest
        }
    })
}

/// Leaves out what promises much less than the effect `known`.
pub(super) fn keep_rivals(found: &mut Vec<Prospect>, known: usize) {
    let Some(promise) = found
        .iter()
        .find(|new| new.index == known)
        .map(|new| new.promise)
    else {
        return;
    };
    if promise.is_finite() {
        found.retain(|new| !new.is_told() || new.promise >= SHARE_OF_KNOWN * promise);
    }
}
