//! Residual torque: the torque that a model lacks, estimated from its position error.
//!
//! Where recorded and simulated shaft turn in the same direction, their difference `r` in rad obeys the linear part
//! of the motor's equation, `J r'' + (b + Kt Kb / R) r' = T`, with the residual torque `T` (without `Kt Kb / R` where
//! the current or the torque is commanded). `r'` and `r''` are those of a parabola fitted to the neighbouring samples
//! (Savitzky and Golay 1964), at the recorded times.

use crate::motor::Parameters;
use crate::recording::{CommandKind, Run};
use crate::units::rad_per_count;

/// Half width in s of the window of the parabola.
const HALF_S: f64 = 0.045;
/// Fewest samples on either side.
const FEWEST: usize = 2;

/// The residual torque in N m at each sample of a run, from the position error in counts of a model with these
/// parameters; `None` near the ends and where the shaft rests.
pub fn missing_torque(run: &Run, gap_counts: &[f64], parameters: &Parameters) -> Vec<Option<f64>> {
    let p = parameters;
    let damping = p.viscous_friction_nm_s_per_rad
        + match run.command_kind {
            CommandKind::Voltage => {
                p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm
            }
            CommandKind::Current | CommandKind::Torque => 0.0,
        };
    let half = ((HALF_S / run.sample_time_s).round().clamp(0.0, 1000.0) as usize).max(FEWEST);
    let angle = rad_per_count(run.counts_per_rev);
    (0..run.len())
        .map(|k| {
            let from = k.checked_sub(half)?;
            let to = k + half;
            let moved = run.counts.get(to)?.abs_diff(run.counts[from]);
            let gap = gap_counts.get(from..=to)?;
            let (slope, curvature) = parabola(run.t_s.get(from..=to)?, run.t_s[k], gap)?;
            (moved >= 2).then_some(angle * (p.inertia_kg_m2 * curvature + damping * slope))
        })
        .collect()
}

/// First and second derivative at `middle` of the least-squares parabola.
fn parabola(t: &[f64], middle: f64, y: &[f64]) -> Option<(f64, f64)> {
    let span = (t.last()? - t.first()?).max(f64::MIN_POSITIVE);
    let (mut powers, mut sums) = ([0.0; 5], [0.0; 3]);
    for (t, y) in t.iter().zip(y) {
        let x = (t - middle) / span;
        let mut power = 1.0;
        for (k, sum) in powers.iter_mut().enumerate() {
            *sum += power;
            if let Some(sum) = sums.get_mut(k) {
                *sum += power * y;
            }
            power *= x;
        }
    }
    let normal = nalgebra::Matrix3::from_fn(|i, j| powers[i + j]);
    let solved = normal
        .cholesky()?
        .solve(&nalgebra::Vector3::from_column_slice(&sums));
    Some((solved[1] / span, 2.0 * solved[2] / (span * span)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_torque_is_reconstructed() {
        // Closed form: a constant torque T from rest on J and B moves r = T/B (t - (1 - e^(-t B/J)) J/B).
        let parameters = Parameters {
            back_emf_v_s_per_rad: 0.2,
            torque_constant_nm_per_a: 0.5,
            resistance_ohm: 10.0,
            viscous_friction_nm_s_per_rad: 0.01,
            inertia_kg_m2: 0.002,
            ..Parameters::default()
        };
        let (torque, damping, inertia) = (0.03, 0.02, 0.002);
        let t_s: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.003).collect();
        let run = Run {
            sample_time_s: 0.003,
            counts_per_rev: 720.0,
            counts: (0..500).map(|k| 2 * k).collect(),
            command: vec![4.5; 500],
            ..Run::default()
        };
        let gap: Vec<f64> = t_s
            .iter()
            .map(|t| {
                let rate = damping / inertia;
                torque / damping * (t + (-rate * t).exp_m1() / rate) * 720.0 / std::f64::consts::TAU
            })
            .collect();
        let run = Run { t_s, ..run };
        let found = missing_torque(&run, &gap, &parameters);
        assert!(found[0].is_none() && found[499].is_none());
        for torque_nm in found.iter().flatten() {
            assert!((torque_nm / torque - 1.0).abs() < 0.02, "{torque_nm}");
        }
        assert!(found.iter().flatten().count() > 450);
        let resting = Run {
            counts: vec![7; 500],
            ..run
        };
        assert!(
            missing_torque(&resting, &gap, &parameters)
                .iter()
                .all(Option::is_none)
        );
    }
}
