//! Counts that pass more slowly in one direction under commands of equal size.
//!
//! A counter that loses edges of one direction and a motor whose driver, brushes or friction differ by direction have
//! the same steady rates; a counter without direction counts up in both. Compared is the largest pair of commands of
//! opposite sign in steady turning, where friction matters least.

use super::edges_lost::{DIFFERS, holds, steady};
use super::finding::{Finding, Kind, Severity};
use super::random_loss::{self, RandomLoss};
use super::subject::Subject;
use super::words::{digits, unit};

/// Least difference of the rates. Real motors reach 6 % (direction-dependent gain of a LEGO motor).
const LOSES: f64 = 0.1;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    if !subject.has("command") || !subject.has("position") {
        return Vec::new();
    }
    if let Some(loss) = random_loss::find(subject) {
        return vec![lost_at_random(subject, &loss)];
    }
    let steady: Vec<(f64, f64, (usize, usize))> = (holds(subject).iter())
        .filter_map(|hold| steady(hold).map(|rate| (hold.command, rate, (hold.from, hold.to))))
        .collect();
    let pairs = steady.iter().filter(|level| level.0 > 0.0).flat_map(|a| {
        let same = |b: &&(f64, f64, _)| (a.0 + b.0).abs() <= DIFFERS * a.0;
        steady.iter().filter(same).map(move |b| (a, b))
    });
    let Some((positive, negative)) = pairs.max_by(|a, b| a.0.0.total_cmp(&b.0.0)) else {
        return Vec::new();
    };
    let run = subject.run;
    let (more, less) = (
        positive.1.abs().max(negative.1.abs()),
        positive.1.abs().min(negative.1.abs()),
    );
    let lost = 1.0 - less / more;
    let at = (
        positive.2.0.min(negative.2.0),
        positive.2.1.max(negative.2.1),
    );
    let evidence = [
        ("command", positive.0),
        ("counts_per_s_positive", positive.1),
        ("counts_per_s_negative", negative.1),
        ("lost_share", lost),
    ];
    let rates = format!(
        "at {} and {} {} there are {} and {} counts/s",
        digits(positive.0, 4),
        digits(negative.0, 4),
        unit(run.command_kind),
        digits(positive.1, 4),
        digits(negative.1, 4),
    );
    if positive.1 > 0.0 && negative.1 > 0.0 {
        return vec![subject.finding(
            Kind::LossInOneDirection,
            Severity::Warning,
            at,
            format!("{rates}: the counts rise in either direction, so the counter knows none"),
            evidence,
            "decode both channels; or take the direction from the command (--unsigned of the import)",
        )];
    }
    if lost < LOSES || positive.1 * negative.1 > 0.0 {
        return Vec::new();
    }
    let direction = if negative.1.abs() < positive.1.abs() {
        "negative"
    } else {
        "positive"
    };
    vec![subject.finding(
        Kind::LossInOneDirection,
        Severity::Note,
        at,
        format!(
            "{rates}: {:.0} % fewer in the {direction} direction. Edges are lost in one direction, or driver or friction differ by direction",
            100.0 * lost,
        ),
        evidence,
        "turn the shaft by hand once forth and once back: a counter that loses none comes back to its count; to a model the rest is `asymmetric_gain` or `asymmetric_friction`",
    )]
}

fn lost_at_random(subject: &Subject<'_>, loss: &RandomLoss) -> Finding {
    let (loses, other) = match loss.sign < 0.0 {
        true => ("negative", "positive"),
        false => ("positive", "negative"),
    };
    subject.finding(
        Kind::LossInOneDirection,
        Severity::Warning,
        subject.whole(),
        format!(
            "{:.0} % fewer counts in the {loses} direction under the same commands, and their variance from row to row is that of edges lost at random ({:.0} %; {other} direction: {:.0} %). Driver and friction do not do that",
            100.0 * loss.share,
            100.0 * loss.by_variance,
            100.0 * loss.other_variance.max(0.0),
        ),
        [
            ("lost_share", loss.share),
            ("lost_share_by_variance", loss.by_variance),
            ("other_direction_by_variance", loss.other_variance),
        ],
        "turn the shaft by hand once forth and once back: a counter that loses none comes back to its count. Count in hardware (a timer's encoder mode), decode both channels, check level and pull-up of channel B",
    )
}
