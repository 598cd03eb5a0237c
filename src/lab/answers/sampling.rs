//! Answers of Part 2.

use super::Answer;
use crate::lab::sampling::{CLOCK_TICK_S, Sampled, Sampling};
use crate::report::number::{figure, percent, rpm, time};
use crate::units::rpm_from_rad_s;

/// One sentence per sample time.
fn each(part: &Sampling, sentence: impl Fn(&Sampled) -> String) -> Vec<String> {
    part.responses.iter().map(sentence).collect()
}

pub(super) fn plots(part: &Sampling) -> Answer {
    let steps: Vec<String> = each(part, |sampled| {
        format!(
            "in steps of {} at TS\u{a0}=\u{a0}{}\u{a0}s",
            rpm(sampled.figures.one_count_rad_s),
            sampled.sample_time_s
        )
    });
    Answer {
        number: "2.1",
        topic: "Plots of the discretised first-order response at both sample times",
        short: format!(
            "See the two plots: the speed comes {}.",
            steps.join(" and ")
        ),
        because: each(part, |sampled| {
            format!(
                "TS\u{a0}=\u{a0}{}\u{a0}s: {} samples; RMS error against the true speed over the step {}.",
                sampled.sample_time_s,
                sampled.t_s.len(),
                rpm(sampled.figures.error_rad_s)
            )
        }),
    }
}

pub(super) fn quantisation(part: &Sampling) -> Answer {
    let sizes = each(part, |sampled| {
        let figures = &sampled.figures;
        format!(
            "{} rad/s at TS\u{a0}=\u{a0}{}\u{a0}s{}",
            figure(figures.one_count_rad_s, 3),
            sampled.sample_time_s,
            figures
                .one_count_of_steady
                .map_or_else(String::new, |share| format!(
                    " ({} of the steady speed)",
                    percent(share)
                ))
        )
    });
    let short = format!(
        "One count in one sample is 2\u{3c0} / (N TS): {}. The speed comes in steps of that size.",
        sizes.join(", ")
    );
    let because = each(part, |sampled| {
        let figures = &sampled.figures;
        let mut text = format!(
            "TS\u{a0}=\u{a0}{}\u{a0}s: one count is {} rad/s = {}",
            sampled.sample_time_s,
            figure(figures.one_count_rad_s, 4),
            rpm(figures.one_count_rad_s)
        );
        if let (Some(counts), Some(scatter)) = (figures.counts_per_sample, figures.scatter_rad_s) {
            text += &format!(
                ". The steady speed is {} counts a sample, so that the difference shows {} and {} by turns, {} and {}: a scatter of {} RMS",
                figure(counts, 4),
                counts.floor(),
                counts.ceil(),
                rpm(counts.floor() * figures.one_count_rad_s),
                rpm(counts.ceil() * figures.one_count_rad_s),
                rpm(scatter)
            );
        }
        text + "."
    });
    Answer {
        number: "2.a",
        topic: "Effect of quantization on the speed",
        short,
        because,
    }
}

pub(super) fn delay(part: &Sampling) -> Answer {
    let halves: Vec<String> = each(part, |sampled| {
        format!(
            "{} at TS\u{a0}=\u{a0}{}\u{a0}s",
            time(sampled.figures.half_sample_s),
            sampled.sample_time_s
        )
    });
    let mut because = each(part, |sampled| {
        let figures = &sampled.figures;
        format!(
            "TS\u{a0}=\u{a0}{}\u{a0}s: half a sample is {}{}. The delay alone puts the speed off by up to {} during the rise.",
            sampled.sample_time_s,
            time(figures.half_sample_s),
            figures.delay_s.map_or_else(String::new, |delay_s| format!(
                "; on this motor's exponential the difference is {} late",
                time(delay_s)
            )),
            rpm(figures.largest_delay_error_rad_s)
        )
    });
    because.push(
        "The delay block holds the last position for one sample; the difference of the two positions is the mean speed between them, which an evenly rising speed had in the middle of the sample."
            .to_owned(),
    );
    Answer {
        number: "2.b",
        topic: "Delay by sampling and difference",
        short: format!("Half a sample: {}.", halves.join(", ")),
        because,
    }
}

pub(super) fn int16(part: &Sampling) -> Answer {
    let mut because = vec![
        "The handout rounds the counts but computes in floating point, so that its simulation never wraps; an int16 on the board does.".to_owned(),
        "Subtracted as int16 (with wrap-around) the difference stays right through a wrap, as long as fewer than 32768 counts pass in one sample.".to_owned(),
    ];
    because.extend(each(part, |sampled| {
        let figures = &sampled.figures;
        format!(
            "TS\u{a0}=\u{a0}{}\u{a0}s: an int16 difference holds up to {}. Converted to a wider type before it is subtracted, the wrap is one false speed of {}.",
            sampled.sample_time_s,
            rpm(figures.largest_int16_speed_rad_s),
            rpm(-figures.wrap_spike_rad_s)
        )
    }));
    Answer {
        number: "2.c",
        topic: "The int16 of the encoder: its range, and when it wraps",
        short: format!(
            "From \u{2212}32768 to 32767 counts: it wraps after {} turns{}.",
            figure(part.int16_turns, 4),
            part.int16_wraps_after_s
                .map_or_else(String::new, |s| format!(
                    ", {} at the steady speed",
                    time(s)
                ))
        ),
        because,
    }
}

pub(super) fn smaller_sample_time(part: &Sampling) -> Answer {
    let error = |ts: f64| {
        let found = part
            .errors_by_sample_time
            .iter()
            .find(|(tried, _)| *tried == ts);
        found.map_or(f64::NAN, |(_, error)| *error)
    };
    let [long, short_ts] = super::super::sampling::SAMPLE_TIMES_S;
    let ratio = error(short_ts) / error(long);
    let short = if ratio > 1.0 {
        format!(
            "The size of a count in the speed grows with 1/TS while the delay shrinks with TS. Here the count dominates: over the step the RMS error is {} at TS\u{a0}=\u{a0}{short_ts}\u{a0}s against {} at TS\u{a0}=\u{a0}{long}\u{a0}s. Take the difference over several samples.",
            rpm(error(short_ts)),
            rpm(error(long)),
        )
    } else {
        format!(
            "For this motor it is not: over the step the RMS error is {} at TS\u{a0}=\u{a0}{short_ts}\u{a0}s against {} at TS\u{a0}=\u{a0}{long}\u{a0}s, because the delay weighs more than the count.",
            rpm(error(short_ts)),
            rpm(error(long)),
        )
    };
    let sweep: Vec<String> = part
        .errors_by_sample_time
        .iter()
        .map(|(ts, error)| format!("{} RPM at {ts}\u{a0}s", figure(rpm_from_rad_s(*error), 3)))
        .collect();
    let mut because = vec![format!(
        "RMS error of the speed over the step by TS: {}. Of these, TS\u{a0}=\u{a0}{}\u{a0}s is best.",
        sweep.join(", "),
        part.best_sample_time_s
    )];
    let best = part
        .spans
        .iter()
        .min_by(|a, b| a.error_rad_s.total_cmp(&b.error_rad_s));
    if let Some(best) = best.filter(|best| best.samples > 1) {
        because.push(format!(
            "Sample at {short_ts} s and take the difference over {} samples: one count is {}, the delay {}, the RMS error over the step {}, and there is a new value every {}.",
            best.samples,
            rpm(best.one_count_rad_s),
            time(best.delay_s),
            rpm(best.error_rad_s),
            time(short_ts)
        ));
    }
    if let (Some(period_s), Some(tick)) = (part.edge_period_s, part.edge_timing_rad_s) {
        because.push(format!(
            "Or time the edges: at the steady speed they come every {}; with a clock of {} \u{b5}s one tick is worth {}.",
            time(period_s),
            figure(1e6 * CLOCK_TICK_S, 1),
            rpm(tick)
        ));
    }
    because.push(
        "Or fit a model to the counts themselves, as motorlab does: a difference throws away where inside its interval each count fell, the position does not.".to_owned(),
    );
    Answer {
        number: "2.d",
        topic: "Why a smaller TS is worse here, and what to do about it",
        short,
        because,
    }
}
