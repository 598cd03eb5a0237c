//! Velocity estimate from counts, for recorder and simulator.
//!
//! Finite difference `velocity[k] = (counts[k] - counts[k-1]) * 2 pi / (counts_per_rev * sample_time_s * n)`, with
//! `n` the number of elapsed samples (1, or more after a loss). It is that of the lab's microcontroller: delayed by
//! half a sample, with a resolution of one count (`2 pi / (counts_per_rev * sample_time_s)`, 0.29 rad/s at 0.03 s and
//! 2.9 rad/s at 0.003 s).

use crate::units::rad_per_count;

/// Speed in rad/s over one interval: `delta_counts` in `elapsed_samples` samples of `sample_time_s`.
pub fn velocity_rad_s(
    delta_counts: f64,
    elapsed_samples: u64,
    counts_per_rev: f64,
    sample_time_s: f64,
) -> f64 {
    delta_counts * rad_per_count(counts_per_rev) / (sample_time_s * elapsed_samples as f64)
}

/// Speeds of a run in rad/s; `None` for the first row, and where `seq` does not advance.
///
/// `seq` are the device's sample numbers; without them every row counts as one sample.
pub fn difference_velocities(
    counts: &[i64],
    seq: Option<&[u64]>,
    counts_per_rev: f64,
    sample_time_s: f64,
) -> Vec<Option<f64>> {
    let step = |k: usize| -> Option<f64> {
        let before = k.checked_sub(1)?;
        let elapsed = match seq {
            Some(seq) => seq[k].checked_sub(seq[before]).filter(|&n| n > 0)?,
            None => 1,
        };
        let delta = counts[k] as f64 - counts[before] as f64;
        Some(velocity_rad_s(
            delta,
            elapsed,
            counts_per_rev,
            sample_time_s,
        ))
    };
    (0..counts.len()).map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_count_is_the_resolution_of_the_handout() {
        // Lab handout: 2 pi / (720 TS), 0.29 rad/s at 0.03 s and 2.9 rad/s at 0.003 s.
        assert!((velocity_rad_s(1.0, 1, 720.0, 0.03) - 0.290_888_208_665_721_6).abs() < 1e-12);
        assert!((velocity_rad_s(1.0, 1, 720.0, 0.003) - 2.908_882_086_657_216).abs() < 1e-12);
    }

    #[test]
    fn a_loss_divides_by_the_elapsed_samples() {
        let v = difference_velocities(&[0, 2, 8], Some(&[0, 1, 4]), 720.0, 0.03);
        assert_eq!(v[0], None);
        assert_eq!(v[1], v[2]);
    }
}
