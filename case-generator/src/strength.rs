//! Strength of a hidden effect, and the part of it that re-identified parameters explain.

use crate::motor::{Motor, NOMINAL_SIGMA};
use crate::profile::Profile;
use crate::random_torque::RandomTorque;
use crate::record::{Conditions, record};
use crate::true_motor::TrueMotor;

const NO_RANDOM_TORQUE: RandomTorque = RandomTorque {
    sigma: 0.0,
    time_s: 1.0,
};

/// Encoder reading of a motor without random torque, in nominal counts, over all profiles.
///
/// Sensor effects on whole counts (lost edges, another resolution) are visible in the counts only, so that these are
/// used; both motors of a comparison start at the same fraction of a count.
pub(crate) fn counts_without_noise(
    hidden: &TrueMotor,
    profiles: &[Profile],
    seed: u64,
) -> Vec<f64> {
    let mut all = Vec::new();
    for (k, profile) in profiles.iter().enumerate() {
        let conditions = Conditions {
            random_torque: NO_RANDOM_TORQUE,
            seed: seed.wrapping_add(k as u64),
        };
        all.extend(counts_under_conditions(hidden, profile, conditions));
    }
    all
}

/// [`counts_without_noise`] of one profile under these conditions.
pub(crate) fn counts_under_conditions(
    hidden: &TrueMotor,
    profile: &Profile,
    conditions: Conditions,
) -> Vec<f64> {
    let recording = record(hidden, profile, hidden.motor.counts_per_rev, conditions);
    // The counts have lost or added edges; the angle has the fraction between edges.
    let count_rad = hidden.motor.count_rad();
    let whole = hidden.miss_probability > 0.0
        || hidden.max_edge_rate_hz.is_finite()
        || hidden
            .unmodelled
            .is_some_and(|unmodelled| unmodelled.adds_counts());
    let readings = recording.run.counts.iter().zip(&recording.angle_rad);
    readings
        .map(|(&counts, &angle)| {
            if whole {
                counts as f64
            } else {
                angle / count_rad
            }
        })
        .collect()
}

/// Root mean square of the difference.
pub(crate) fn rms(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
    (sum / a.len().max(1) as f64).sqrt()
}

/// Residual RMS in counts of `with - without` after re-identification of R, K, J, b and Tf, linearly and within their
/// tolerances: `min over x of |d - S x|^2 12 + |x / 0.05|^2`.
pub(crate) fn beyond_refit(
    plain: &TrueMotor,
    profiles: &[Profile],
    seed: u64,
    with: &[f64],
    without: &[f64],
) -> f64 {
    /// Relative step of the sensitivities.
    const PROBE: f64 = 0.02;
    let probes: [fn(&mut Motor); 5] = [
        |m| m.resistance_ohm *= 1.0 + PROBE,
        |m| {
            m.back_emf_v_s_per_rad *= 1.0 + PROBE;
            m.torque_constant_nm_per_a *= 1.0 + PROBE;
        },
        |m| m.inertia_kg_m2 *= 1.0 + PROBE,
        |m| m.viscous_friction_nm_s_per_rad *= 1.0 + PROBE,
        |m| m.coulomb_friction_nm *= 1.0 + PROBE,
    ];
    let sensitivities = probes.map(|probe| {
        let mut changed = plain.clone();
        probe(&mut changed.motor);
        let mut column = counts_without_noise(&changed, profiles, seed);
        for (c, w) in column.iter_mut().zip(without) {
            *c = (*c - w) / PROBE;
        }
        column
    });
    let gap: Vec<f64> = with.iter().zip(without).map(|(a, b)| a - b).collect();
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(x, y)| x * y).sum() };
    let mut normal = [[0.0; 5]; 5];
    let mut right = [0.0; 5];
    for i in 0..5 {
        right[i] = 12.0 * dot(&sensitivities[i], &gap);
        for j in 0..5 {
            normal[i][j] = 12.0 * dot(&sensitivities[i], &sensitivities[j]);
        }
        normal[i][i] += 1.0 / (NOMINAL_SIGMA * NOMINAL_SIGMA);
    }
    let x = solve(normal, right);
    let left: Vec<f64> = (0..gap.len())
        .map(|k| gap[k] - (0..5).map(|i| sensitivities[i][k] * x[i]).sum::<f64>())
        .collect();
    rms(&left, &vec![0.0; left.len()])
}

/// Solves a symmetric positive definite system by Gaussian elimination.
fn solve(mut a: [[f64; 5]; 5], mut b: [f64; 5]) -> [f64; 5] {
    for i in 0..5 {
        for j in i + 1..5 {
            let factor = a[j][i] / a[i][i];
            let pivot = a[i];
            for (below, above) in a[j].iter_mut().zip(pivot).skip(i) {
                *below -= factor * above;
            }
            b[j] -= factor * b[i];
        }
    }
    for i in (0..5).rev() {
        let known: f64 = (i + 1..5).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}
