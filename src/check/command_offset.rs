//! Command column shifted against the counts by whole samples.
//!
//! The response after each step of the command is fitted by a first-order model with dead time, `K (z - tau (1 -
//! exp(-z / tau)))`, `z = t - delay`: `delay` and `tau` common to the steps of a run, one gain `K` for each step. A
//! negative delay of whole samples with a residual at quantization level means a late column: the command was set
//! before its sample and logged after it, or is one row too low. A positive delay means an early column, or a dead
//! time in the command path. Friction, inertia and a dead zone cause no dead time; an inductance, a filter and a slow
//! bus do, so that a positive delay is only a note.
//!
//! Play and a soft coupling start up to one sample earlier than a first-order response, but reduce the residual by at
//! most 6 % or leave more than quantization.

use super::dead_time::dead_time;
use super::finding::{Finding, Kind, Severity};
use super::step_response::{MOST_AFTER, MOST_LATE, StepResponse, step_responses};
use super::subject::Subject;
use super::words::time;
use crate::recording::Steps;
use crate::units::ROUNDING_VARIANCE as ROUNDING;

/// Remedy for a late column.
const SET_THEN_PRINT: &str = "a row must hold the command that is in force from its sample on: set it, then print it, or move the column up by a row";

/// Standard errors by which the mean before the step must lie above 0 for a response before the command. Valid runs,
/// recorded and simulated with every effect, reach 3.5 (a pendulum that still oscillates).
const BEFORE: f64 = 6.0;
/// Least share of the steps that must show it.
const MOST: f64 = 2.0 / 3.0;
/// Least dead time in samples: quantization causes an estimate of up to a quarter of a sample.
const DEAD_SAMPLES: f64 = 0.75;
/// Grid of dead times in samples; negative ones are responses before the command.
const LONGEST_AHEAD: f64 = 3.0;
const LONGEST_DEAD: f64 = 8.0;
const DEAD_STEP: f64 = 0.25;
/// Grid of time constants in samples: none, then 0.5 to 100 in a ratio of 1.5, refined to a thousandth between the
/// neighbours of the best.
const NO_TAU: f64 = 0.01;
const SHORTEST_TAU: f64 = 0.5;
const TAU_STEP: f64 = 1.5;
const TAUS: i32 = 14;
const REFINED: usize = 14;
/// With dead time the RMS residual is at most this share of the best one with a dead time up to `WITHOUT` samples,
/// and the log likelihood ratio exceeds this bound, which correlated residuals do not reach.
const LEAVES: f64 = 0.8;
const WITHOUT: f64 = 0.25;
const LEAST_LOG_RATIO: f64 = 20.0;
/// Largest residual of a first-order response, in quantization errors: a soft coupling at its default strength leaves
/// 2.5.
const FIRST_ORDER: f64 = 1.1;
/// Samples fitted after each step, and steps fitted in a run.
const FITTED: usize = 40;
const MOST_FITTED: usize = 12;
/// Largest speed at rest against the response, in counts a sample. After a reversal friction changes its sign during
/// the response, which no first-order model follows.
pub(super) const AT_REST: f64 = 0.05;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    if !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    let Some(step_s) = Steps::of(subject.run).map(|steps| steps.median_s()) else {
        return Vec::new();
    };
    // Positions integrated from speeds are uncertain by one sample.
    let slack = usize::from(subject.run.is_integrated());
    let steps = step_responses(subject.run, slack, MOST_AFTER);
    let found = late(subject, &steps, step_s).or_else(|| dead_time(subject, slack, step_s));
    let found = found.or_else(|| {
        let responses = Responses::of(&steps, step_s)?;
        let ahead = responses.ahead(subject, slack as f64);
        ahead.or_else(|| responses.behind(subject))
    });
    found.into_iter().collect()
}

fn late(subject: &Subject<'_>, steps: &[StepResponse], step_s: f64) -> Option<Finding> {
    let (first, last) = (steps.first()?.at, steps.last()?.at);
    let sum: f64 = steps.iter().map(|step| step.at_step.0).sum();
    let variance: f64 = steps.iter().map(|step| step.at_step.1.powi(2)).sum();
    let over_error = sum / variance.sqrt();
    let ahead = steps.iter().filter(|step| step.at_step.0 > 0.0).count();
    if over_error < BEFORE || (ahead as f64) < MOST * steps.len() as f64 {
        return None;
    }
    let counts_ahead = sum / steps.len() as f64;
    Some(subject.finding(
        Kind::CommandLate,
        Severity::Warning,
        (first.saturating_sub(MOST_LATE), last),
        format!(
            "the shaft moves before the command: at the steps of the command (the first at {:.3} s) it is {counts_ahead:.1} counts ahead already, so the command column is late by a sample of {} or more",
            subject.run.t_s[first],
            time(step_s),
        ),
        [
            ("counts_ahead", counts_ahead),
            ("over_its_error", over_error),
            ("jumps", steps.len() as f64),
        ],
        SET_THEN_PRINT,
    ))
}

/// The step responses of a run, with the residual of the first-order fit for each dead time.
struct Responses<'a> {
    fitted: Vec<&'a StepResponse>,
    /// Dead time in samples and residual in counts^2.
    of_each: Vec<(f64, f64)>,
    samples: usize,
    step_s: f64,
}

/// A dead time that fits, compared with all dead times of the other kind.
struct Found {
    dead: f64,
    rms_counts: f64,
    log_ratio: f64,
}

impl<'a> Responses<'a> {
    fn of(steps: &'a [StepResponse], step_s: f64) -> Option<Self> {
        let fitted: Vec<&StepResponse> = steps
            .iter()
            .filter(|step| step.speed_counts_s * step_s >= -AT_REST)
            .take(MOST_FITTED)
            .collect();
        let samples = fitted.iter().map(|step| fitted_part(step).count()).sum();
        let tried = ((LONGEST_AHEAD + LONGEST_DEAD) / DEAD_STEP) as usize;
        let of_each = (0..=tried)
            .map(|k| k as f64 * DEAD_STEP - LONGEST_AHEAD)
            .map(|dead| (dead, best_residual(&fitted, dead, step_s)))
            .collect();
        (!fitted.is_empty()).then_some(Self {
            fitted,
            of_each,
            samples,
            step_s,
        })
    }

    /// The best dead time, if it is significantly better than every one of the `others`.
    fn significant(&self, others: impl Fn(f64) -> bool) -> Option<Found> {
        let &(dead, best) = self.of_each.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let without = (self.of_each.iter().filter(|(dead, _)| others(*dead)))
            .map(|(_, left)| *left)
            .fold(f64::INFINITY, f64::min);
        let samples = self.samples as f64;
        let log_ratio = samples * (without / best.max(ROUNDING * samples)).ln();
        let is_significant = best.sqrt() <= LEAVES * without.sqrt() && log_ratio >= LEAST_LOG_RATIO;
        is_significant.then_some(Found {
            dead,
            rms_counts: (best / samples).sqrt(),
            log_ratio,
        })
    }

    fn ahead(&self, subject: &Subject<'_>, slack: f64) -> Option<Finding> {
        let found = self.significant(|dead| dead >= -WITHOUT)?;
        let lead = -found.dead;
        if lead < DEAD_SAMPLES + slack || found.rms_counts > FIRST_ORDER * ROUNDING.sqrt() {
            return None;
        }
        Some(subject.finding(
            Kind::CommandLate,
            Severity::Warning,
            self.rows(),
            format!(
                "the shaft moves {} ({}) before the command, so the command column is late",
                samples(lead),
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

    fn behind(&self, subject: &Subject<'_>) -> Option<Finding> {
        let found = self.significant(|dead| dead.abs() <= WITHOUT)?;
        let dead = found.dead;
        if dead < DEAD_SAMPLES {
            return None;
        }
        Some(subject.finding(
            Kind::CommandEarly,
            Severity::Note,
            self.rows(),
            format!(
                "the shaft starts {} ({}) later than the command",
                samples(dead),
                time(dead * self.step_s),
            ),
            [
                ("dead_time_s", dead * self.step_s),
                ("dead_time_samples", dead),
                ("jumps", self.fitted.len() as f64),
                ("log_likelihood_ratio", found.log_ratio),
            ],
            "if the log has the command a row too early, shift that column by a row; else the response is delayed by a communication bus (effect transport_delay), a filter (speed_filter) or the winding (inductance)",
        ))
    }

    fn rows(&self) -> (usize, usize) {
        let ends = self.fitted.first().zip(self.fitted.last());
        ends.map_or((0, 0), |(first, last)| (first.at, last.at))
    }
}

/// A number of samples with its noun.
fn samples(number: f64) -> String {
    match number == 1.0 {
        true => "one sample".to_owned(),
        false => format!("{number} samples"),
    }
}

/// The part of a step response that is fitted: the samples before the step and the first ones after it.
pub(super) fn fitted_part(step: &StepResponse) -> impl Iterator<Item = &(f64, f64)> {
    step.response.iter().take(MOST_LATE - 1 + FITTED)
}

/// Residual in counts^2 with the best time constant for this dead time: grid search, then golden-section search
/// (Press et al., Numerical Recipes, 2007, section 10.2).
fn best_residual(steps: &[&StepResponse], dead: f64, step_s: f64) -> f64 {
    let of = |ln_tau: f64| residual(steps, dead, ln_tau.exp(), step_s);
    let tried = (0..TAUS).map(|k| SHORTEST_TAU.ln() + f64::from(k) * TAU_STEP.ln());
    let best = tried.map(|ln_tau| (ln_tau, of(ln_tau)));
    let (middle, coarse) = best
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((SHORTEST_TAU.ln(), f64::INFINITY));
    let fine = golden((middle, coarse), TAU_STEP.ln(), of);
    fine.min(residual(steps, dead, NO_TAU, step_s))
}

/// Minimum of a function within `width` of the best known point, by golden-section search.
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
fn residual(steps: &[&StepResponse], dead: f64, tau: f64, step_s: f64) -> f64 {
    let shape = |t_s: f64| {
        let z = (t_s / step_s - dead).max(0.0);
        z - tau * (1.0 - (-z / tau).exp())
    };
    let of_one = |step: &&StepResponse| {
        let (mut ff, mut fy, mut yy) = (0.0, 0.0, 0.0);
        for &(t_s, y) in fitted_part(step) {
            let f = shape(t_s);
            (ff, fy, yy) = (ff + f * f, fy + f * y, yy + y * y);
        }
        if ff > 0.0 { yy - fy * fy / ff } else { yy }
    };
    steps.iter().map(of_one).sum()
}
