//! Counts in multiples of 2 or 4, and a position off by a whole factor or a unit against the motor file.

use std::f64::consts::TAU;

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;
use crate::compare::compare;
use crate::motor::Model;
use crate::recording::Run;

/// Fewest changes of the count that must all be multiples: at random one in 2^20 would.
const FEWEST_CHANGES: usize = 20;
/// Fewest changes that differ from the most frequent size, which counts as one: at random one in 2^10 would.
const FEWEST_OTHERS: usize = 10;
/// Tolerance of the ratio of recorded to simulated travel: motors are within 5 %.
const NEAR: f64 = 0.05;
/// Least share of the recorded mean square that the scaled simulation explains.
const EXPLAINED: f64 = 0.98;
/// Least travel in counts, so that quantization is well below the tolerance.
const LEAST_TRAVEL_COUNTS: f64 = 100.0;

/// Largest relative difference of the ratio between thirds of the run; thirds with less than the second share of the
/// motion are skipped.
const SAME: f64 = 0.15;
const STILL: f64 = 0.01;
/// Above this share of changing samples the command may be a controller's.
const CHANGES: f64 = 0.1;

/// Units that are often confused, and the factor that results.
const UNITS: [(f64, &str); 6] = [
    (DEGREES_PER_RAD, "degrees were told as radians"),
    (1.0 / DEGREES_PER_RAD, "radians were told as degrees"),
    (TAU, "radians were told as turns"),
    (1.0 / TAU, "turns were told as radians"),
    (360.0, "degrees were told as turns"),
    (1.0 / 360.0, "turns were told as degrees"),
];
const DEGREES_PER_RAD: f64 = 360.0 / TAU;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    if !subject.has("position") {
        return Vec::new();
    }
    let mut found: Vec<Finding> = multiples(subject).into_iter().collect();
    found.extend(against_the_motor(subject));
    found
}

fn multiples(subject: &Subject<'_>) -> Option<Finding> {
    let steps: Vec<u64> = (subject.run.counts.windows(2))
        .map(|pair| pair[0].abs_diff(pair[1]))
        .filter(|step| *step > 0)
        .collect();
    if steps.len() < FEWEST_CHANGES {
        return None;
    }
    let factor = [4_u64, 2]
        .into_iter()
        .find(|n| steps.iter().all(|step| step % n == 0))?;
    // Steps of one size are steady motion, or slow motion derived from a coarse speed, not a factor.
    let mut sorted = steps.clone();
    sorted.sort_unstable();
    let commonest = sorted.chunk_by(|a, b| a == b).map(<[u64]>::len).max();
    if sorted.len() - commonest.unwrap_or(0) < FEWEST_OTHERS {
        return None;
    }
    Some(subject.finding(
        Kind::CountsScale,
        Severity::Warning,
        subject.whole(),
        format!("every change of the count is a multiple of {factor}: the resolution is coarser than counts_per_rev says"),
        [("factor", factor as f64), ("changes", steps.len() as f64)],
        format!("divide the counts and counts_per_rev by {factor} (scale under [position] of the mapping), or decode all edges"),
    ))
}

/// Least-squares ratio of the recorded position to the simulated one.
fn against_the_motor(subject: &Subject<'_>) -> Option<Finding> {
    let (run, motor) = (subject.run, subject.motor?);
    if !subject.has("command") {
        return None;
    }
    let laid = compare(run, motor, Model::SecondOrder).ok()?;
    let (first, origin) = (
        *run.counts.first()?,
        *laid.simulated_position_counts.first()?,
    );
    let (mut xx, mut xy, mut yy, mut most) = (0.0, 0.0, 0.0, 0.0_f64);
    for (&count, simulated) in run.counts.iter().zip(&laid.simulated_position_counts) {
        let (y, x) = (count.saturating_sub(first) as f64, simulated - origin);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        most = most.max(y.abs());
    }
    if most < LEAST_TRAVEL_COUNTS || xy * xy < EXPLAINED * xx * yy || xx == 0.0 {
        return None;
    }
    let ratio = xy / xx;
    let near = |factor: f64| (ratio / factor - 1.0).abs() < NEAR;
    let evidence = [("recorded_over_simulated_travel", ratio)];
    let simulated: Vec<f64> = (laid.simulated_position_counts.iter())
        .map(|x| x - origin)
        .collect();
    if !is_the_same_throughout(run, &simulated, ratio) {
        return None;
    }
    if let Some((_, what)) = UNITS.into_iter().find(|(factor, _)| near(*factor)) {
        return Some(subject.finding(
            Kind::PositionUnit,
            // A controller's command depends on the position: any mismatch of the motor file would give a ratio.
            match is_held(&run.command) {
                true => Severity::Fatal,
                false => Severity::Warning,
            },
            subject.whole(),
            format!("the shaft turns {ratio:.3} times as far as the motor file says: {what}"),
            evidence,
            "give the unit under [position] of the mapping (--position COL:UNIT of the import)",
        ));
    }
    [2.0, 4.0, 0.5, 0.25]
        .into_iter()
        .find(|factor| near(*factor))?;
    Some(subject.finding(
        Kind::CountsScale,
        Severity::Warning,
        subject.whole(),
        format!("the shaft turns {ratio:.2} times as far as the motor file says"),
        evidence,
        "counts_per_rev may be of one edge where all four are counted, or the other way round: check it in the header or the mapping",
    ))
}

fn is_the_same_throughout(run: &Run, simulated: &[f64], ratio: f64) -> bool {
    let third = run.len().div_ceil(3).max(1);
    let parts: Vec<(f64, f64)> = (run.counts.chunks(third).zip(simulated.chunks(third)))
        .map(|(counts, simulated)| {
            let n = counts.len() as f64;
            let mean_y = counts.iter().map(|&count| count as f64).sum::<f64>() / n;
            let mean_x = simulated.iter().sum::<f64>() / n;
            let pairs = counts.iter().zip(simulated);
            pairs.fold((0.0, 0.0), |(xx, xy), (&count, x)| {
                let (y, x) = (count as f64 - mean_y, x - mean_x);
                (xx + x * x, xy + x * y)
            })
        })
        .collect();
    let all: f64 = parts.iter().map(|part| part.0).sum();
    (parts.iter())
        .filter(|(xx, _)| *xx >= STILL * all)
        .all(|(xx, xy)| (xy / xx / ratio - 1.0).abs() < SAME)
}

/// Whether the command is held between steps, as a planned one; a controller's changes in every sample.
fn is_held(command: &[f64]) -> bool {
    let changes = command.windows(2).filter(|pair| pair[0] != pair[1]).count();
    (changes as f64) < CHANGES * command.len() as f64
}
