//! The command column is some samples early or late against the counts.
//!
//! A shaft cannot answer before it is commanded. Where it has left its rest, or its steady turning, when the command jumps, the
//! column is late: set before a sample and logged after it, or a row too low in the table. The whole answer tells more than its
//! first count: `K (z - tau (1 - exp(-z / tau)))`, `z = t - delay`, is fitted to the positions after all jumps of a run, each with its own
//! `K`. Where it begins whole samples before the jump and leaves what rounding leaves, the column is late. Where nothing happens for
//! whole samples after the jump, the column is early, or something delays the command. Friction, inertia and a dead zone make no dead time;
//! an inductance, a filter and a slow bus do, so that is no more than a note.
//!
//! A motor that moves before its load does begins sooner than a first-order answer: play and a soft coupling come to a sample
//! early, and no more than 6 % of what is left, or leave more than rounding.

use super::dead_time::dead_time;
use super::finding::{Finding, Kind, Severity};
use super::jump::{Jump, MOST_AFTER, MOST_LATE, jumps};
use super::subject::Subject;
use super::words::time;
use crate::recording::Steps;
use crate::units::ROUNDING_VARIANCE as ROUNDING;

/// Remedy for a late column.
const SET_THEN_PRINT: &str = "a row must hold the command that is in force from its sample on: set it, then print it, or move the column up by a row";

/// The answer is there before the jump where its mean lies so many standard errors above 0. Sound runs, real ones and simulated ones
/// with every effect, reach 3.5 (a pendulum that still swings).
const BEFORE: f64 = 6.0;
/// So large a share of the jumps must show it.
const MOST: f64 = 2.0 / 3.0;
/// A dead time of at least so many samples is one: rounding leaves a quarter of a sample.
const DEAD_SAMPLES: f64 = 0.75;
/// Dead times that are tried, in samples: from this, an answer before the command, up to this, by this step.
const LONGEST_AHEAD: f64 = 3.0;
const LONGEST_DEAD: f64 = 8.0;
const DEAD_STEP: f64 = 0.25;
/// Time constants that are tried, in samples: none, then from half a sample to 100, each half as long again, and between the
/// best one's neighbours to a thousandth.
const NO_TAU: f64 = 0.01;
const SHORTEST_TAU: f64 = 0.5;
const TAU_STEP: f64 = 1.5;
const TAUS: i32 = 14;
const REFINED: usize = 14;
/// The fit with a dead time leaves at most this share (root mean square) of what the best leaves whose dead time is at most
/// `WITHOUT` samples; and the logarithm of their likelihood ratio is at least this, which correlated residuals do not reach.
const LEAVES: f64 = 0.8;
const WITHOUT: f64 = 0.25;
const SURE: f64 = 20.0;
/// Motion before its command is a first-order response if the residual of the fit is at most so many times the quantization error: a soft
/// coupling at its default strength leaves 2.5 times as much.
const FIRST_ORDER: f64 = 1.1;
/// Samples of an answer that are fitted, and jumps of a run.
const FITTED: usize = 40;
const MOST_FITTED: usize = 12;
/// Counts a sample that a shaft at rest may seem to turn against its answer. In a reversal friction changes its sign on the
/// way, which no first-order answer follows.
pub(super) const AT_REST: f64 = 0.05;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    if !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    let Some(step_s) = Steps::of(subject.run).map(|steps| steps.median_s()) else {
        return Vec::new();
    };
    // A position that was summed up from speeds is uncertain by a sample.
    let slack = usize::from(subject.run.is_integrated());
    let jumps = jumps(subject.run, slack, MOST_AFTER);
    let found = late(subject, &jumps, step_s).or_else(|| dead_time(subject, slack, step_s));
    let found = found.or_else(|| {
        let answers = Answers::of(&jumps, step_s)?;
        let ahead = answers.ahead(subject, slack as f64);
        ahead.or_else(|| answers.behind(subject))
    });
    found.into_iter().collect()
}

/// Motion before the jump.
fn late(subject: &Subject<'_>, jumps: &[Jump], step_s: f64) -> Option<Finding> {
    let (first, last) = (jumps.first()?.at, jumps.last()?.at);
    let sum: f64 = jumps.iter().map(|jump| jump.ahead.0).sum();
    let variance: f64 = jumps.iter().map(|jump| jump.ahead.1.powi(2)).sum();
    let over_error = sum / variance.sqrt();
    let ahead = jumps.iter().filter(|jump| jump.ahead.0 > 0.0).count();
    if over_error < BEFORE || (ahead as f64) < MOST * jumps.len() as f64 {
        return None;
    }
    let counts_ahead = sum / jumps.len() as f64;
    Some(subject.finding(
        Kind::CommandLate,
        Severity::Warning,
        (first.saturating_sub(MOST_LATE), last),
        format!(
            "the shaft answers before it is commanded: when the command jumps (first at {:.3} s) it is {counts_ahead:.1} counts ahead already, so the command's column is late by a sample of {} or more",
            subject.run.t_s[first],
            time(step_s),
        ),
        [
            ("counts_ahead", counts_ahead),
            ("over_its_error", over_error),
            ("jumps", jumps.len() as f64),
        ],
        SET_THEN_PRINT,
    ))
}

/// The answers of a run and what a first-order answer leaves of them after each dead time.
struct Answers<'a> {
    fitted: Vec<&'a Jump>,
    /// Dead time in samples, and what is left in counts^2.
    of_each: Vec<(f64, f64)>,
    samples: usize,
    step_s: f64,
}

/// A dead time that the answers have, against every one that is not of its kind.
struct Found {
    dead: f64,
    rms_counts: f64,
    log_ratio: f64,
}

impl<'a> Answers<'a> {
    fn of(jumps: &'a [Jump], step_s: f64) -> Option<Self> {
        let fitted: Vec<&Jump> = jumps
            .iter()
            .filter(|jump| jump.speed_counts_s * step_s >= -AT_REST)
            .take(MOST_FITTED)
            .collect();
        let samples = fitted.iter().map(|jump| looked_at(jump).count()).sum();
        let tried = ((LONGEST_AHEAD + LONGEST_DEAD) / DEAD_STEP) as usize;
        let of_each = (0..=tried)
            .map(|k| k as f64 * DEAD_STEP - LONGEST_AHEAD)
            .map(|dead| (dead, best_left(&fitted, dead, step_s)))
            .collect();
        (!fitted.is_empty()).then_some(Self {
            fitted,
            of_each,
            samples,
            step_s,
        })
    }

    /// The best dead time of all, where it is surely not one of the `others`.
    fn sure(&self, others: impl Fn(f64) -> bool) -> Option<Found> {
        let &(dead, best) = self.of_each.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let without = (self.of_each.iter().filter(|(dead, _)| others(*dead)))
            .map(|(_, left)| *left)
            .fold(f64::INFINITY, f64::min);
        let samples = self.samples as f64;
        let log_ratio = samples * (without / best.max(ROUNDING * samples)).ln();
        let is_sure = best.sqrt() <= LEAVES * without.sqrt() && log_ratio >= SURE;
        is_sure.then_some(Found {
            dead,
            rms_counts: (best / samples).sqrt(),
            log_ratio,
        })
    }

    /// An answer that begins before its command.
    fn ahead(&self, subject: &Subject<'_>, slack: f64) -> Option<Finding> {
        let found = self.sure(|dead| dead >= -WITHOUT)?;
        let lead = -found.dead;
        if lead < DEAD_SAMPLES + slack || found.rms_counts > FIRST_ORDER * ROUNDING.sqrt() {
            return None;
        }
        Some(subject.finding(
            Kind::CommandLate,
            Severity::Warning,
            self.rows(),
            format!(
                "the shaft answers {lead} samples ({}) before it is commanded, so the command's column is late",
                time(lead * self.step_s),
            ),
            [
                ("lead_s", lead * self.step_s),
                ("lead_samples", lead),
                ("jumps", self.fitted.len() as f64),
                ("log_likelihood_ratio", found.log_ratio),
            ],
            SET_THEN_PRINT,
        ))
    }

    /// A dead time after the command.
    fn behind(&self, subject: &Subject<'_>) -> Option<Finding> {
        let found = self.sure(|dead| dead.abs() <= WITHOUT)?;
        let dead = found.dead;
        if dead < DEAD_SAMPLES {
            return None;
        }
        Some(subject.finding(
            Kind::CommandEarly,
            Severity::Note,
            self.rows(),
            format!(
                "the shaft answers {dead} samples ({}) after the command jumps: the command's column is early, or something delays the command",
                time(dead * self.step_s),
            ),
            [
                ("dead_time_s", dead * self.step_s),
                ("dead_time_samples", dead),
                ("jumps", self.fitted.len() as f64),
                ("log_likelihood_ratio", found.log_ratio),
            ],
            "look for what lies between command and motor: a row that is logged too early, a bus, a filter, an inductance; to a model it is `transport_delay`",
        ))
    }

    /// From the first jump to the last.
    fn rows(&self) -> (usize, usize) {
        let ends = self.fitted.first().zip(self.fitted.last());
        ends.map_or((0, 0), |(first, last)| (first.at, last.at))
    }
}

/// Fit of a jump: the samples before it and the beginning of the answer.
pub(super) fn looked_at(jump: &Jump) -> impl Iterator<Item = &(f64, f64)> {
    jump.answer.iter().take(MOST_LATE - 1 + FITTED)
}

/// Residual of the best time constant after this dead time, in counts^2: the best of those that are tried, and then between its
/// neighbours (golden section: Press et al., Numerical Recipes, 2007, section 10.2).
fn best_left(jumps: &[&Jump], dead: f64, step_s: f64) -> f64 {
    let of = |ln_tau: f64| left(jumps, dead, ln_tau.exp(), step_s);
    let tried = (0..TAUS).map(|k| SHORTEST_TAU.ln() + f64::from(k) * TAU_STEP.ln());
    let best = tried.map(|ln_tau| (ln_tau, of(ln_tau)));
    let (middle, coarse) = best
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((SHORTEST_TAU.ln(), f64::INFINITY));
    let fine = golden((middle, coarse), TAU_STEP.ln(), of);
    fine.min(left(jumps, dead, NO_TAU, step_s))
}

/// The least value of a function within `width` of the best place that is known with its value (golden section).
pub(super) fn golden(best: (f64, f64), width: f64, of: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (best.0 - width, best.0 + width);
    let mut fine = best.1;
    for _ in 0..REFINED {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        let (of_a, of_b) = (of(a), of(b));
        fine = fine.min(of_a).min(of_b);
        if of_a < of_b {
            high = b;
        } else {
            low = a;
        }
    }
    fine
}

/// Residual of a first-order response after a dead time (both in samples), in counts^2.
fn left(jumps: &[&Jump], dead: f64, tau: f64, step_s: f64) -> f64 {
    let shape = |t_s: f64| {
        let z = (t_s / step_s - dead).max(0.0);
        z - tau * (1.0 - (-z / tau).exp())
    };
    let of_jump = |jump: &&Jump| {
        let (mut ff, mut fy, mut yy) = (0.0, 0.0, 0.0);
        for &(t_s, y) in looked_at(jump) {
            let f = shape(t_s);
            (ff, fy, yy) = (ff + f * f, fy + f * y, yy + y * y);
        }
        if ff > 0.0 { yy - fy * fy / ff } else { yy }
    };
    jumps.iter().map(of_jump).sum()
}
