//! The experiment in which an effect is visible at its default strength, and the effects that no experiment
//! identifies.

use crate::motor::catalogue::ids;
use serde::Serialize;

use crate::motor::catalogue::EffectKind;

/// A planned recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Experiment {
    /// A built-in profile, as for `capture --profile`.
    pub profile: &'static str,
    /// Duration in s.
    pub duration_s: f64,
    /// Sample time in s.
    pub sample_time_s: f64,
}

/// Levels and reversals of several sizes with rests between, 15 s: most effects are visible in it.
const USUAL: Experiment = at_3_ms("reversing", 15.0);

/// Effects with another experiment.
const OTHERS: [(&str, Experiment); 9] = [
    // Slow passage through the dead zone.
    (ids::DEAD_ZONE, at_3_ms("ramp@0.5", 15.0)),
    (ids::ASYMMETRIC_DEAD_ZONE, at_3_ms("ramp@0.5", 15.0)),
    // Low speed with frequent starts and stops.
    (ids::STRIBECK, at_3_ms("ramp@0.5", 15.0)),
    (ids::STATIC_FRICTION, at_3_ms("ramp@0.3", 20.0)),
    // Slow reversals: the play is a large share of the travel.
    (ids::BACKLASH, at_3_ms("ramp@0.4", 20.0)),
    // Heating takes tens of seconds.
    (ids::WINDING_HEATING, at_3_ms("brakes", 60.0)),
    (ids::MAGNET_WEAKENING, at_3_ms("brakes", 60.0)),
    // Only the hardest reversals make it slip.
    (ids::SLIPPING_CLUTCH, at_3_ms("square", 15.0)),
    // The travel in half a sample is largest at top speed.
    (ids::SAMPLE_JITTER, at_3_ms("square", 15.0)),
];

/// Effects with the same response as a change of parameters of the motor file.
const UNIDENTIFIABLE: [(&str, &str); 6] = [
    (
        ids::SUPPLY_ERROR,
        "other motor constants, inertia and friction in that ratio do the same",
    ),
    (
        ids::COULOMB_FRICTION,
        "it is another value of coulomb_friction_nm",
    ),
    (
        ids::VISCOUS_FRICTION,
        "more back EMF slows the motor by as much at every speed",
    ),
    (ids::INERTIA, "it is another value of inertia_kg_m2"),
    (
        ids::RESOLUTION_ERROR,
        "other motor constants and inertia in that ratio do the same",
    ),
    (
        ids::CLOCK_ERROR,
        "another speed and another time constant do the same; only the host's time stamps tell",
    ),
];

const fn at_3_ms(profile: &'static str, duration_s: f64) -> Experiment {
    Experiment {
        profile,
        duration_s,
        sample_time_s: 0.003,
    }
}

/// The experiment in which this effect is visible at its default strength.
pub fn experiment(kind: &EffectKind) -> Experiment {
    let own = OTHERS.iter().find(|(id, _)| *id == kind.id);
    own.map_or(USUAL, |(_, experiment)| *experiment)
}

/// Why no experiment with voltage input and counts output separates this effect from parameters of the motor file;
/// `None` if one does.
pub fn not_identifiable(kind: &EffectKind) -> Option<&'static str> {
    let found = UNIDENTIFIABLE.iter().find(|(id, _)| *id == kind.id);
    found.map(|(_, why)| *why)
}

#[cfg(test)]
pub(super) fn ids() -> impl Iterator<Item = &'static str> {
    let others = OTHERS.iter().map(|(id, _)| *id);
    others.chain(UNIDENTIFIABLE.iter().map(|(id, _)| *id))
}
