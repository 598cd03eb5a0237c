//! Comparison of a device's unit of time with a host's clock.

/// Powers of ten between confused units of time: us, ms and s.
pub(crate) const MISTAKEN: [i32; 4] = [-6, -3, 3, 6];

/// Tolerance of the ratio as a factor: late reads change it by less.
const WITHIN: f64 = 2.0;

/// Power of ten by which the device's seconds are faster than the host's: 0 if they agree, -6, -3, 3 or 6 for another
/// unit; `None` otherwise.
pub(crate) fn power_of_unit(device_per_host: f64) -> Option<i32> {
    let near = |power: &i32| {
        let ratio = device_per_host / 10f64.powi(*power);
        (1.0 / WITHIN..=WITHIN).contains(&ratio)
    };
    [0].into_iter().chain(MISTAKEN).find(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_1000_are_detected_and_others_are_not() {
        for (ratio, power) in [
            (1.0, Some(0)),
            (0.51, Some(0)),
            (1900.0, Some(3)),
            (5.1e-4, Some(-3)),
            (1e6, Some(6)),
            (1.2e-6, Some(-6)),
            (30.0, None),
            (1e9, None),
            (0.0, None),
            (-1000.0, None),
            (f64::NAN, None),
        ] {
            assert_eq!(power_of_unit(ratio), power, "{ratio}");
        }
    }
}
