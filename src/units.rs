//! Conversions between SI and other units, for input and output.
//!
//! Inside motorlab every number is in SI units.

use std::f64::consts::TAU;

/// Speed in revolutions per minute: `60 / 2 pi` times that in rad/s.
pub fn rpm_from_rad_s(speed_rad_s: f64) -> f64 {
    speed_rad_s * 60.0 / TAU
}

/// Speed in rad/s from revolutions per minute.
pub fn rad_s_from_rpm(speed_rpm: f64) -> f64 {
    speed_rpm * TAU / 60.0
}

/// Angle in rad of one encoder count.
pub fn rad_per_count(counts_per_rev: f64) -> f64 {
    TAU / counts_per_rev
}

/// Variance in counts^2 of quantization to whole counts, uniformly distributed (Widrow and Kollar, Quantization
/// Noise, 2008).
pub const ROUNDING_VARIANCE: f64 = 1.0 / 12.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_turn_a_second_is_sixty_rpm() {
        assert!((rpm_from_rad_s(TAU) - 60.0).abs() < 1e-12);
        assert!((rad_s_from_rpm(60.0) - TAU).abs() < 1e-12);
    }

    #[test]
    fn a_count_of_the_lab_encoder_is_half_a_degree() {
        assert!((rad_per_count(720.0).to_degrees() - 0.5).abs() < 1e-12);
    }
}
