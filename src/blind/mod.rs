//! Blind tests: verdicts on cases whose cause is withheld.
//!
//! ```text
//! make/seal -> DIR/manifest.json (hash of every file, salted commitment to every label) + cases
//!           -> LABELS (labels and salts; kept elsewhere until the verdicts are in)
//! run       -> DIR/verdicts/*.json + DIR/verdicts.log (a chain of hashes with times)
//! score     -> DIR/opened.json (when the labels were opened, and the head of the chain then)
//! ```
//!
//! A commitment is `SHA-256(salt LF case LF label)`, the salt 32 random bytes in hex, so that a guessed
//! label cannot be tried against the manifest. Entry k of the chain is
//! `SHA-256(head of k-1 LF case LF hash of the verdict's file LF time)`: whoever has written down the
//! last head has written down every verdict. [`open`] checks all of it and refuses otherwise.

mod bounded;
mod calibration;
mod claim;
mod diagnoser;
mod diagnosis_document;
mod error;
mod files;
mod judge;
mod ledger;
mod make;
mod opening;
mod page;
mod run;
mod score;
mod seal;
mod share;
mod text;
mod truth;
mod unseen;

pub use calibration::{Coverage, Probabilities, ReliabilityRow};
pub use claim::Word;
pub use diagnoser::{Diagnoser, Program, Verdict};
pub use error::BlindError;
pub use judge::{Bearing, Judgement, ParameterCheck, judge};
pub use ledger::{Entry, Ledger};
pub use make::{BREADTH, FIRST_UNTOUCHED_SEED, Recipe, drawn_seed, make};
pub use opening::{Opened, OpenedCase, open};
pub use page::page;
pub use run::{Progress, run};
pub use score::{
    Confusion, EffectRow, Gap, OutsideCases, Score, SetFacts, Standing, StrengthRow, Ties, Time,
    score,
};
pub use seal::{Labels, Manifest, NewCase, SealedCase, SealedLabel, add_cases, commitment};
pub use share::Share;
pub use text::{ORDER_UNPROVED, markdown, text};
pub use truth::{BadLabel, TrueEffect, Truth, TruthKind};
pub use unseen::{GapCheck, measure_gap};
