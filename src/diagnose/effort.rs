//! How much a diagnosis has simulated, and how much it may.
//!
//! A search for what is not in the catalogue has no end of its own: there is always another set to try. So it may have a
//! limit, of work and not of time: what is found must not depend on how busy a machine is. A unit of work is about a nanosecond of
//! one core (`motor::fit`); simulations are some seven tenths of a search. How much is left is asked only where no simulation
//! is under way, so that the answer is the same however many cores there are. Short recordings have none in any case, nor what does
//! not command a voltage: axes of robots, whose recordings have a noise of their own that takes a search to its end to see
//! through; nor the pieces of a long recording that is rough, which are not more than so many.
//!
//! With a limit, what promises little is looked at beside no set but the empty one, three tenths of the pieces of a rough recording
//! and the likeliest single effects tell its noise, and where a first round of growth shows that the catalogue has little to say
//! (`outlook.rs`) no more than a third effect, or the one beside a noise by itself, is tried after it. Then,
//!
//! | spent | from there on |
//! | --- | --- |
//! | [`PLENTY`] | only what promises much is looked at beside a set |
//! | [`HALF`] | before anything else is tried, a recording that is rough is taken for one; third effects are those that came next in the round before |
//! | [`EARLY`] | beside a set that leaves something no looking again and no pairs at once, on whole runs, and else the effects of the best set alone looked for again; on pieces of a rough recording nothing beside a single effect, and those looked at from their likeliest starts alone |
//! | [`LATE`] | on whole runs no third effect |
//! | what the outlook is worth, [`MOST`] at most | nothing more is tried, but on whole runs beside a set that leaves nothing; from [`MOST`] on a round's leaders are fitted on long horizons once |
//! | [`ALL`] | nothing more is tried, single effects are not looked for again, fewer sets tell which effects are there beside something unknown, and what predicts kept data is refitted from its own horizons on |

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Units of work that a diagnosis may spend on as many samples; in proportion where there are more.
const LIMIT: f64 = 1.25e9;
const SAMPLES: f64 = 6500.0;
/// Fewer samples have no limit.
const FEW: usize = 4000;
/// Shares of the limit, see above.
const PLENTY: f64 = 0.3;
const HALF: f64 = 0.5;
const EARLY: f64 = 0.6;
const LATE: f64 = 0.8;
pub(super) const MOST: f64 = 0.85;
pub(super) const ALL: f64 = 1.0;

/// Work done, and its limit.
#[derive(Debug, Default)]
pub(super) struct Effort {
    spent: AtomicU64,
    /// `None` where there is none.
    limit: Option<f64>,
    /// Whether something was left out for want of work.
    was_cut: AtomicBool,
}

impl Effort {
    /// For a diagnosis of so many samples: of a few none, since each simulation of them is short, and since what is recorded
    /// once only, of a motor that nobody can run again, is worth a search to its end.
    pub fn limited_for(samples: usize) -> Self {
        Self {
            limit: (samples >= FEW).then(|| LIMIT * (samples as f64 / SAMPLES).max(1.0)),
            ..Self::default()
        }
    }

    /// Adds what a simulation took.
    pub fn spend(&self, work: u64) {
        self.spent.fetch_add(work, Ordering::Relaxed);
    }

    /// Whether another part of a search may begin that is worth this share of the limit. Where not, the search is one that was cut
    /// short.
    pub fn is_left(&self, share: f64) -> bool {
        let is_left = self.share() < share;
        if !is_left {
            self.cut();
        }
        is_left
    }

    /// Whether the search may go to its end.
    pub fn is_unlimited(&self) -> bool {
        self.limit.is_none()
    }

    /// Whether what promises little may be looked at too.
    pub fn is_plenty(&self) -> bool {
        self.share() < PLENTY
    }

    /// Whether what seldom leads anywhere may be tried too.
    pub fn is_early(&self) -> bool {
        self.share() < EARLY
    }

    /// Whether it is too late for a third effect.
    pub fn is_late(&self) -> bool {
        self.share() >= LATE
    }

    /// Whether it is time to ask if a recording is rough.
    pub fn is_half(&self) -> bool {
        self.share() >= HALF
    }

    /// Keeps what is to be tried, and notes where something was left out.
    pub fn retain(&self, tried: &mut Vec<usize>, is_kept: impl Fn(&usize) -> bool) {
        let before = tried.len();
        tried.retain(is_kept);
        if tried.len() < before {
            self.cut();
        }
    }

    /// Notes that something was left out.
    pub fn cut(&self) {
        self.was_cut.store(true, Ordering::Relaxed);
    }

    /// Whether something was left out.
    pub fn was_cut(&self) -> bool {
        self.was_cut.load(Ordering::Relaxed)
    }

    /// Share of the limit that was spent.
    fn share(&self) -> f64 {
        let spent = self.spent.load(Ordering::Relaxed) as f64;
        self.limit.map_or(0.0, |limit| spent / limit)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::rank::rank;
    use super::super::samples::{motor_with, problem, ready, recording};
    use super::*;

    /// What is spent and what is found are the same on one core and on three, and with a limit less is tried.
    #[test]
    fn a_limit_ends_a_search_at_the_same_place_on_any_number_of_cores() {
        let there = [
            ("gravity_load", &[0.03, 0.4][..]),
            ("torque_ripple", &[0.2, 9.0, 1.0]),
            ("stribeck", &[0.03, 0.5]),
        ];
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&there)));
        let ranked = |threads: usize, limit: Option<f64>| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(|| {
                let effort = Arc::new(Effort {
                    limit,
                    ..Effort::default()
                });
                let problem = problem(&nominal, &runs).with_effort(&effort);
                let ranking = rank(&problem, &|_| {}).expect("it can be simulated");
                let weights: Vec<(Vec<usize>, f64)> = ranking
                    .candidates
                    .iter()
                    .map(|c| (c.effects.clone(), c.log_weight))
                    .collect();
                let spent = effort.spent.load(Ordering::Relaxed);
                (spent, effort.was_cut(), weights)
            })
        };
        let limit = Some(5e8);
        let one = ranked(1, limit);
        assert_eq!(one, ranked(3, limit));
        let (spent, was_cut, weights) = one;
        let in_full = ranked(2, None);
        assert!(was_cut && !in_full.1);
        assert!(spent < in_full.0 && weights.len() < in_full.2.len());
        assert!(weights[0].1 <= in_full.2[0].1);
    }
}
