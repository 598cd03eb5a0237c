//! What an effect promises before any fit of it, and how closely it is looked at for that.
//!
//! A regression on short horizons says by how many squares an effect may leave less than the fit so far. What it
//! promises far less than another is not what is missing next: it is looked at in passing, or not beside this set. Where
//! the command answers to the motion, as on an axis that its controller holds, no regression tells, and all are looked at.

use super::periodic::is_scanned;
use super::search::Start;
use crate::motor::effects::catalogue;

/// Squares that a further effect must promise to be fitted beside a set that leaves nothing (the prior of one more effect
/// is worth seven), and those of one whose order is scanned for: some hundred orders promise that by chance.
const LEAST: f64 = 3.0;
const LEAST_SCANNED: f64 = 16.0;
/// Share of the highest promise from which on an effect is fitted beside others; the same where it would have to do as well
/// as one that is known; and from which on the fits of one whose order is scanned for, ten times as many, are made.
const SHARE: f64 = 0.05;
const SHARE_OF_KNOWN: f64 = 0.3;
const SCANNED_SHARE: f64 = 0.2;

/// Where fits of an effect may start, best first.
pub(super) struct Prospect {
    /// The effect's index in the catalogue.
    pub index: usize,
    /// The starts.
    pub starts: Vec<Start>,
    /// By how many squares less the effect may leave than the fit so far, on short horizons or on the fit's own: each
    /// start with the magnitude, as a factor of what it does there, that suits it best. Infinite where no regression tells.
    pub promise: f64,
}

impl Prospect {
    fn is_scanned(&self) -> bool {
        is_scanned(catalogue()[self.index].id)
    }
}

/// How closely an effect is looked at.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// Not at all.
    None,
    /// A step from every start, and a few more.
    Short,
    /// From the beginning of the runs on, with the order held first.
    Long,
}

/// What effects are tried for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Round {
    /// To explain the runs alone.
    Alone,
    /// To explain what a set leaves.
    Beside,
    /// To explain what a set leaves better than one that is known to explain it.
    Instead,
}

/// What has to be promised to be looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bar {
    /// Most squares that one of the effects promises.
    highest: f64,
    /// What they are tried for.
    round: Round,
    /// Whether the set beside which they are tried leaves nothing to explain.
    is_good: bool,
    /// Whether the axis is held by its controller.
    is_held: bool,
}

impl Bar {
    /// For these effects.
    pub fn of(prospects: &[Prospect], round: Round, is_good: bool, is_held: bool) -> Self {
        let promises = prospects.iter().map(|new| new.promise);
        Self {
            highest: promises.filter(|x| x.is_finite()).fold(0.0, f64::max),
            round,
            is_good,
            is_held,
        }
    }

    /// How closely to look at one of them.
    pub fn look_at(&self, new: &Prospect) -> Look {
        let (share, scanned_share) = match self.round {
            _ if self.is_held => (0.0, 0.0),
            Round::Instead => (SHARE_OF_KNOWN, SHARE_OF_KNOWN),
            _ => (SHARE, SCANNED_SHARE),
        };
        let is_promising = |least: f64, share: f64| {
            new.promise >= share * self.highest && (new.promise >= least || !self.is_good)
        };
        // Whether a resolution suits, or a clock that the host's does not bear out, no slope tells: but neither is what
        // takes off as much as a known effect.
        let is_told = self.round == Round::Instead
            || !matches!(
                catalogue()[new.index].id,
                "clock_error" | "resolution_error"
            );
        if new.is_scanned() && is_promising(LEAST_SCANNED, scanned_share) {
            Look::Long
        } else if self.round == Round::Alone
            || !is_told
            || (!new.is_scanned() && is_promising(LEAST, share))
        {
            Look::Short
        } else {
            Look::None
        }
    }
}
