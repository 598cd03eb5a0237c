//! Which effects of the catalogue are weighed against each other: those that this diagnosis was tuned and published with.
//!
//! The catalogue grows; a rival more changes every probability, and the published tables would no longer be those of
//! this program. What is not here is simulated, and named by nothing.

use crate::motor::catalogue::catalogue;

/// Ids of the rivals, in the catalogue's order.
const RIVALS: [&str; 27] = [
    "transport_delay",
    "dead_zone",
    "voltage_drop",
    "supply_sag",
    "supply_error",
    "current_limit",
    "coast_at_zero",
    "inductance",
    "winding_heating",
    "torque_ripple",
    "coulomb_friction",
    "viscous_friction",
    "inertia",
    "stribeck",
    "asymmetric_friction",
    "presliding",
    "load_friction",
    "quadratic_drag",
    "gravity_load",
    "cogging",
    "backlash",
    "compliance",
    "resolution_error",
    "missed_counts",
    "encoder_eccentricity",
    "sample_jitter",
    "clock_error",
];

/// How many rivals there are.
pub(super) const COUNT: usize = RIVALS.len();

/// Their places in the catalogue, in its order.
pub(super) fn rivals() -> impl Iterator<Item = usize> {
    (0..catalogue().len()).filter(|&index| RIVALS.contains(&catalogue()[index].id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::catalogue::find;

    #[test]
    fn every_rival_is_in_the_catalogue() {
        assert!(RIVALS.iter().all(|id| find(id).is_some()));
        assert_eq!(rivals().count(), COUNT);
    }
}
