//! Sine and cosine of large angles, for torques periodic in the angle, which need both at every stage of a step.
//!
//! `x = n pi/2 + r`, `|r| <= pi/4`, with `pi/2` in three parts so that `n` times the first two is exact (W. J. Cody,
//! W. Waite: Software Manual for the Elementary Functions, 1980); Taylor's series of `r` to full precision,
//!
//! `sin r = r - r^3/3! + ... - r^15/15!`, `cos r = 1 - r^2/2! + ... + r^16/16!`.
//!
//! Both are within one or two rounding errors, and identical on all processors.

use std::f64::consts::FRAC_2_PI;

/// `pi/2`: its first 33 bits, the next 33, the rest.
const PARTS: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];
/// Larger angles in rad use the standard library: `n` must fit 20 bits.
const LARGEST_RAD: f64 = 1e6;
/// Adding and subtracting it rounds to an integer, which is in the last bits in between.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// Coefficients after the 1 of `1 - z/3! ...`, `z = r^2`, from `z` on; and those of the cosine from `z^2` on.
const SINE: [f64; 7] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
const COSINE: [f64; 7] = [
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// Sine and cosine of an angle in rad.
#[inline(always)]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    let is_near = x.abs() < LARGEST_RAD;
    if !is_near {
        return x.sin_cos();
    }
    let rounded = x * FRAC_2_PI + ROUNDING;
    let (n, quarter) = (rounded - ROUNDING, rounded.to_bits());
    let r = ((x - n * PARTS[0]) - n * PARTS[1]) - n * PARTS[2];
    let z = r * r;
    let sine = r + r * (z * polynomial(&SINE, z));
    let cosine = (1.0 - 0.5 * z) + z * z * polynomial(&COSINE, z);
    let (s, c) = if quarter & 1 == 0 {
        (sine, cosine)
    } else {
        (cosine, sine)
    };
    // Bit 1 of the quadrant is the sign of the sine, of the next quadrant that of the cosine.
    let turned = |value: f64, quarter: u64| f64::from_bits(value.to_bits() ^ ((quarter & 2) << 62));
    (turned(s, quarter), turned(c, quarter.wrapping_add(1)))
}

/// `c0 + c1 z + ... + c6 z^6`, in two independent halves.
#[inline(always)]
fn polynomial(c: &[f64; 7], z: f64) -> f64 {
    let z2 = z * z;
    let low = (c[0] + c[1] * z) + z2 * (c[2] + c[3] * z);
    let high = (c[4] + c[5] * z) + z2 * c[6];
    low + (z2 * z2) * high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sine_is_the_standard_librarys_within_two_rounding_errors() {
        let mut largest = 0.0_f64;
        let far = (-20_000..20_000).map(|k| f64::from(k) * 49.993);
        let near = (-200_000..200_000).map(|k| f64::from(k) * 1.7e-3);
        let quarters = (-2000..2000).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4);
        for x in far.chain(near).chain(quarters).chain([0.0, 1e-300, 1e7]) {
            let ((s, c), (sine, cosine)) = (sin_cos(x), x.sin_cos());
            largest = largest.max((s - sine).abs()).max((c - cosine).abs());
        }
        assert!(largest <= 2.0 * f64::EPSILON, "{largest:e}");
        assert!(sin_cos(f64::NAN).0.is_nan() && sin_cos(f64::INFINITY).1.is_nan());
    }
}
