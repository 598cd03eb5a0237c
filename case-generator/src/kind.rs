//! Kinds of cases: one effect, two, none, or one outside the catalogue.

use std::fmt;
use std::str::FromStr;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::effect::{CATALOGUE, LATER};
use crate::unmodelled::OUTSIDE;

/// Hidden effects of a case.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// Nothing.
    None,
    /// One effect of the catalogue.
    Single(&'static str),
    /// Two effects of the catalogue.
    Pair(&'static str, &'static str),
    /// One effect outside the catalogue.
    Outside(&'static str),
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Single(id) | Self::Outside(id) => f.write_str(id),
            Self::Pair(a, b) => write!(f, "{a}+{b}"),
        }
    }
}

/// An unknown kind of case.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownKind(pub String);

impl fmt::Display for UnknownKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "'{}' is no kind of case\nhint: give none, an effect's id (`motorlab effects` lists them), or two ids joined by +",
            self.0
        )
    }
}

impl std::error::Error for UnknownKind {}

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, UnknownKind> {
        let unknown = || UnknownKind(text.to_owned());
        let listed = |list: &[&'static str], id: &str| list.iter().copied().find(|&k| k == id);
        if text == "none" {
            return Ok(Self::None);
        }
        if let Some((a, b)) = text.split_once('+') {
            let a = listed(&CATALOGUE, a).ok_or_else(unknown)?;
            let b = listed(&CATALOGUE, b).ok_or_else(unknown)?;
            return if can_pair(a, b) {
                Ok(Self::Pair(a, b))
            } else {
                Err(unknown())
            };
        }
        listed(&CATALOGUE, text)
            .or_else(|| listed(&LATER, text))
            .map(Self::Single)
            .or_else(|| listed(&OUTSIDE, text).map(Self::Outside))
            .ok_or_else(unknown)
    }
}

/// Whether one motor can have both: different effects, and not both a load on the shaft.
pub(crate) fn can_pair(a: &str, b: &str) -> bool {
    let couples = |id: &str| id == "backlash" || id == "compliance";
    a != b && !(couples(a) && couples(b))
}

/// Composition of a set of cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mix {
    /// Per hundred: 54 single effects, 20 pairs, 10 without effects, 16 outside the catalogue.
    #[default]
    Mixed,
    /// Single effects only, equally often.
    Singles,
    /// Pairs only.
    Pairs,
    /// No effect in any case.
    None,
    /// Outside the catalogue only, equally often.
    Outside,
}

impl FromStr for Mix {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, UnknownKind> {
        match text {
            "mixed" => Ok(Self::Mixed),
            "singles" => Ok(Self::Singles),
            "pairs" => Ok(Self::Pairs),
            "none" => Ok(Self::None),
            "outside" | "unknown" => Ok(Self::Outside),
            other => Err(UnknownKind(other.to_owned())),
        }
    }
}

/// The cases of a set with their seeds and kinds. Effects occur equally often, to within one; the order is shuffled;
/// determined by `seed`.
pub fn plan(cases: usize, seed: u64, mix: Mix) -> Vec<(u64, Kind)> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed ^ 0x706c_616e_0000_0001);
    let share = |percent: usize| (cases * percent + 50) / 100;
    let (singles, pairs, outside) = match mix {
        Mix::Mixed => {
            let (singles, pairs) = (share(54), share(20));
            (singles, pairs, share(16).min(cases - singles - pairs))
        }
        Mix::Singles => (cases, 0, 0),
        Mix::Pairs => (0, cases, 0),
        Mix::None => (0, 0, 0),
        Mix::Outside => (0, 0, cases),
    };
    let mut kinds = Vec::with_capacity(cases);
    let mut dealt = Deck::new(&CATALOGUE);
    kinds.extend((0..singles).map(|_| Kind::Single(dealt.next(&mut rng))));
    while kinds.len() < singles + pairs {
        let (a, b) = (dealt.next(&mut rng), dealt.next(&mut rng));
        if can_pair(a, b) {
            kinds.push(Kind::Pair(a, b));
        }
    }
    let mut odd = Deck::new(&OUTSIDE);
    kinds.extend((0..outside).map(|_| Kind::Outside(odd.next(&mut rng))));
    kinds.resize(cases, Kind::None);
    shuffle(&mut kinds, &mut rng);
    kinds
        .into_iter()
        .map(|kind| (rng.random::<u64>(), kind))
        .collect()
}

/// Deals every name once before any is repeated.
struct Deck {
    names: &'static [&'static str],
    left: Vec<&'static str>,
}

impl Deck {
    fn new(names: &'static [&'static str]) -> Self {
        Self {
            names,
            left: Vec::new(),
        }
    }

    fn next(&mut self, rng: &mut Pcg64Mcg) -> &'static str {
        if self.left.is_empty() {
            self.left.extend(self.names);
            shuffle(&mut self.left, rng);
        }
        self.left.pop().unwrap_or(self.names[0])
    }
}

/// Fisher and Yates.
fn shuffle<T>(items: &mut [T], rng: &mut Pcg64Mcg) {
    for last in (1..items.len()).rev() {
        items.swap(last, rng.random_range(0..=last));
    }
}
