//! Which effects of the catalogue are weighed against each other: those that this diagnosis was tuned and published with.
//!
//! The catalogue grows; a rival more changes every probability, and the published tables would no longer be those of
//! this program. What is not here is simulated, and named by nothing. Ranges and parameters are those of the tables too: what the
//! catalogue says of them by now, with [`TUNED`] in place of what has changed.

use std::sync::LazyLock;

use crate::motor::catalogue::{self, EffectKind, EffectParameter, Prior, Scale};

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

/// Id, key, range in multiples of a scale, prior.
type Tuned = (&'static str, &'static str, (f64, f64), Scale, Prior);

/// Ranges that this diagnosis was tuned with, where the catalogue has others.
const TUNED: [Tuned; 8] = [
    (
        "transport_delay",
        "delay_s",
        (0.1, 3.0),
        Scale::SampleTime,
        Prior::Uniform,
    ),
    (
        "dead_zone",
        "threshold_v",
        (0.2, 1.5),
        Scale::Absolute,
        Prior::Uniform,
    ),
    (
        "voltage_drop",
        "drop_v",
        (0.1, 1.5),
        Scale::Absolute,
        Prior::LogUniform,
    ),
    (
        "supply_sag",
        "source_resistance_ohm",
        (0.5, 10.0),
        Scale::Absolute,
        Prior::LogUniform,
    ),
    (
        "inductance",
        "inductance_h",
        (1e-3, 30e-3),
        Scale::Resistance,
        Prior::LogUniform,
    ),
    (
        "stribeck",
        "stribeck_speed_rad_s",
        (0.1, 2.0),
        Scale::Absolute,
        Prior::LogUniform,
    ),
    (
        "gravity_load",
        "torque_nm",
        (0.3, 5.0),
        Scale::CoulombTorque,
        Prior::LogUniform,
    ),
    (
        "compliance",
        "frequency_hz",
        (1.0, 50.0),
        Scale::Absolute,
        Prior::LogUniform,
    ),
];

/// A parameter that the catalogue has had only since: friction splits as inertia does here.
const LATER: &str = "load_friction_weight";

/// The catalogue, with the ranges that this diagnosis was tuned with.
pub(super) fn catalogue() -> &'static [EffectKind] {
    static KINDS: LazyLock<Vec<EffectKind>> =
        LazyLock::new(|| catalogue::catalogue().iter().map(tuned).collect());
    &KINDS
}

/// The effect with this id, and its place in the catalogue.
pub(super) fn find(id: &str) -> Option<(usize, &'static EffectKind)> {
    let mut kinds = catalogue().iter().enumerate();
    kinds.find(|(_, kind)| kind.id == id)
}

fn tuned(kind: &EffectKind) -> EffectKind {
    let known = kind.parameters.iter().filter(|p| p.key != LATER);
    let parameters: Vec<EffectParameter> = known
        .map(|parameter| {
            let at = |row: &&(&str, &str, (f64, f64), Scale, Prior)| {
                (row.0, row.1) == (kind.id, parameter.key)
            };
            match TUNED.iter().find(at) {
                Some(&(_, _, (lo, hi), scale, prior)) => EffectParameter {
                    lo,
                    hi,
                    scale,
                    prior,
                    or_up_to: None,
                    at_most: f64::MAX,
                    ..*parameter
                },
                None => *parameter,
            }
        })
        .collect();
    EffectKind {
        // Made once for the whole run of the program.
        parameters: Vec::leak(parameters),
        ..*kind
    }
}

/// How many rivals there are.
pub(super) const COUNT: usize = RIVALS.len();

/// Their places in the catalogue, in its order.
pub(super) fn rivals() -> impl Iterator<Item = usize> {
    (0..catalogue().len()).filter(|&index| RIVALS.contains(&catalogue()[index].id))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rival_is_in_the_catalogue() {
        assert!(RIVALS.iter().all(|id| find(id).is_some()));
        for (id, key, ..) in TUNED {
            let (_, kind) = find(id).expect("in the catalogue");
            assert!(kind.parameters.iter().any(|p| p.key == key), "{id} {key}");
        }
        assert_eq!(rivals().count(), COUNT);
    }
}
