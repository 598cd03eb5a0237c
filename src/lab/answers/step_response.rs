//! Answers of Part 1.

use super::{Answer, NO_USABLE_RECORDING, not_usable, usable};
use crate::diagnose::{Diagnosis, Verdict};
use crate::lab::damping::Term;
use crate::lab::missing::Missing;
use crate::lab::recorded::Recorded;
use crate::lab::step_response::VISIBLE;
use crate::lab::{Source, StepResponses};
use crate::report::number::{change, figure, percent, probability_of, rpm, rpm_or_unlimited, time};
use crate::units::rpm_from_rad_s;

impl Term {
    /// Name with symbol.
    pub fn words(self) -> &'static str {
        match self {
            Self::BackEmf => "back EMF (Kt Kb / R)",
            Self::Viscous => "viscous friction (b)",
            Self::Coulomb => "Coulomb friction (Tf)",
        }
    }
}

pub(super) fn first_order(part: &StepResponses) -> Answer {
    let order = &part.order;
    let (visible, below_a_count) = (
        order.largest_relative >= VISIBLE,
        order.largest_counts < 1.0,
    );
    let at_most = format!(
        "it differs from the second order by at most {} of the steady speed",
        percent(order.largest_relative)
    );
    let short = match (visible, below_a_count) {
        _ if order.electrical_s == 0.0 => {
            "The motor file has no inductance: the first order is the whole of this motor."
                .to_owned()
        }
        (false, true) => format!(
            "A first-order model is good enough: {at_most}, and by {} counts of position, which the encoder cannot show.",
            figure(order.largest_counts, 2)
        ),
        (false, false) => format!(
            "A first-order model is good enough for the speed: {at_most}. The position differs by up to {} counts, which the encoder shows.",
            figure(order.largest_counts, 3)
        ),
        (true, _) => {
            format!(
                "A first-order model is not good enough: {at_most}. The inductance belongs in the model."
            )
        }
    };
    let mut because = vec![format!(
        "Over the first {}, first and second order (both with viscous friction) differ by at most {} RPM ({} after the step) and by {} RPM RMS: {} and {} of the steady speed.",
        time(part.t_s.last().copied().unwrap_or(0.0)),
        figure(order.largest_rpm, 3),
        time(order.largest_at_s),
        figure(order.rms_rpm, 3),
        percent(order.largest_relative),
        percent(order.rms_relative),
    )];
    if let Some(mechanical_s) = order.mechanical_s {
        because.push(format!(
            "The limit is the ratio of two time constants: the winding's L/R = {} against J R / (R b + Kt Kb) = {}, {}.",
            time(order.electrical_s),
            time(mechanical_s),
            if order.electrical_s > 0.0 {
                format!("{} times as long", figure(mechanical_s / order.electrical_s, 3))
            } else {
                "and the motor file has no inductance at all".to_owned()
            },
        ));
    }
    if let [slow, fast] = part.curves[1].poles[..] {
        because.push(if slow.im != 0.0 {
            format!(
                "The second order has a pair of complex poles, {} \u{b1} {}i per second: it overshoots, which a first order never does.",
                figure(slow.re, 4),
                figure(slow.im.abs(), 4)
            )
        } else {
            let first = part.curves[0].poles.first().map_or(f64::NAN, |pole| pole.re);
            format!(
                "The second order's slow pole is {} per second ({} from the first order's {}); its fast one, {} per second, has died out after {}.",
                figure(slow.re, 4),
                change(slow.re / first - 1.0),
                figure(first, 4),
                figure(fast.re, 4),
                time(-5.0 / fast.re),
            )
        });
    }
    if let Some(limit_h) = order.visible_from_h {
        because.push(format!(
            "The difference would reach {} of the steady speed with an inductance of {} H.",
            percent(VISIBLE),
            figure(limit_h, 3),
        ));
    }
    Answer {
        number: "1.1",
        topic: "Using a first-order model: is it good enough?",
        short,
        because,
    }
}

pub(super) fn damping(part: &StepResponses) -> Answer {
    let damping = &part.damping;
    let largest = &damping.shares[0];
    let ignorable: Vec<&str> = damping
        .shares
        .iter()
        .filter(|share| {
            share
                .steady_error
                .is_some_and(|error| error.abs() < VISIBLE)
        })
        .map(|share| share.term.words())
        .collect();
    let moves = damping.steady_rad_s != Some(0.0);
    let short = if moves {
        format!(
            "The dominant damping is {}: it takes {} of the stall torque at steady speed. {}",
            largest.term.words(),
            percent(largest.share),
            if ignorable.is_empty() {
                format!(
                    "No term can be ignored without an error of the steady speed above {}.",
                    percent(VISIBLE)
                )
            } else {
                format!(
                    "To {} of the steady speed, these can be ignored: {}.",
                    percent(VISIBLE),
                    ignorable.join(", ")
                )
            }
        )
    } else {
        "Coulomb friction holds the shaft at this supply: the motor does not turn at all."
            .to_owned()
    };
    let mut because: Vec<String> = damping
        .shares
        .iter()
        .map(|share| {
            format!(
                "{}: {} N m, {} of the stall torque. Left out, the steady speed would be {}{}.",
                capitalised(share.term.words()),
                figure(share.torque_nm, 3),
                percent(share.share),
                rpm_or_unlimited(share.steady_without_rad_s),
                share
                    .steady_error
                    .map_or_else(String::new, |error| format!(" ({})", change(error))),
            )
        })
        .collect();
    because.push(format!(
        "Back EMF and viscous friction grow with the speed and set the time constant; Coulomb friction does neither. It lowers the steady speed by the same {} at any voltage and holds the shaft below R Tf / Kt = {} V, which no linear model shows.",
        rpm(coulomb_loss(part)),
        figure(damping.breakaway_v, 3),
    ));
    Answer {
        number: "1.2",
        topic: "Which damping dominates, and which terms can be ignored?",
        short,
        because,
    }
}

/// Reduction of the steady speed by Coulomb friction, in rad/s.
fn coulomb_loss(part: &StepResponses) -> f64 {
    let steady = |k: usize| part.curves[k].steady_speed_rad_s;
    steady(0)
        .zip(steady(2))
        .map_or(0.0, |(without, with)| without - with)
}

pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

pub(super) fn experiment(runs: &[Recorded], missing: &Missing, source: &Source) -> Answer {
    let usable = usable(runs);
    let because: Vec<String> = usable
        .iter()
        .filter_map(|recorded| {
            let steady = recorded.steady?;
            let predicted: Vec<String> = recorded
                .models
                .iter()
                .filter_map(|model| {
                    let speed = model.steady_rad_s?;
                    let off = speed / steady.speed_rad_s - 1.0;
                    Some(format!("{} {} ({})", model.name, rpm(speed), change(off)))
                })
                .collect();
            Some(format!(
                "{}, TS\u{a0}=\u{a0}{}\u{a0}s: steady at {} \u{b1} {} RPM from {} to {}. Predicted: {}.",
                recorded.name(),
                recorded.sample_time_s,
                rpm(steady.speed_rad_s),
                figure(rpm_from_rad_s(steady.one_count_rad_s), 2),
                time(steady.from_s),
                time(steady.to_s),
                if predicted.is_empty() {
                    "no closed form for this command".to_owned()
                } else {
                    predicted.join("; ")
                },
            ))
        })
        .collect();
    let met = usable
        .iter()
        .filter(|recorded| recorded.is_at_the_floor())
        .count();
    let first = usable.first().copied();
    let short = match first.and_then(Recorded::best) {
        None if runs.is_empty() => "There is no recording to compare with.".to_owned(),
        None => NO_USABLE_RECORDING.to_owned(),
        Some(best) => {
            let verdict = match_words(met, usable.len(), missing.diagnosis());
            let source = match source {
                Source::Recorded => "",
                Source::VirtualBoard(_) => {
                    " The recordings are the virtual board's, not an experiment."
                }
            };
            format!(
                "{verdict}; closest is \u{201c}{}\u{201d}, off by {} counts RMS over the whole run.{source}",
                best.name,
                figure(best.figures.position_rmse_counts, 3)
            )
        }
    };
    Answer {
        number: "1.3",
        topic: "Does the simulated step match the experimental one?",
        short: short + &not_usable(runs),
        because,
    }
}

/// Number of accurately simulated recordings, and the diagnosis where it disagrees.
fn match_words(met: usize, recordings: usize, diagnosis: Option<&Diagnosis>) -> String {
    let found = diagnosis.map(|found| {
        let finds_none = matches!(found.verdict, Verdict::NoGap | Verdict::NoChange);
        (
            finds_none,
            probability_of("no effect is present", found.probability),
        )
    });
    match found {
        Some((false, _)) if met == recordings => {
            "Nearly: every recording is met to about the encoder's rounding, but the diagnosis finds a gap (see 3.a)".to_owned()
        }
        Some((true, p)) if met == 0 => format!(
            "Nearly: no recording is met down to the encoder's rounding, but the diagnosis finds no gap above its noise floor ({p}; see 3.a)"
        ),
        _ if met == recordings => {
            "Yes: every recording is met down to the encoder's rounding".to_owned()
        }
        _ if met == 0 => "No: no recording is met down to the encoder's rounding".to_owned(),
        _ => format!(
            "In part: {met} of {recordings} recordings are met down to the encoder's rounding"
        ),
    }
}
