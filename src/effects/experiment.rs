//! The experiment that shows an effect at its default strength, and the effects that no experiment identifies.

use crate::motor::catalogue::ids;
use serde::Serialize;

use crate::motor::catalogue::EffectKind;

/// A recording to be made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Experiment {
    /// A built-in profile, as `capture --profile` takes it.
    pub profile: &'static str,
    /// How long in s.
    pub duration_s: f64,
    /// Sample time in s.
    pub sample_time_s: f64,
}

/// Levels and reversals of several sizes with rests between, in a quarter of a minute: most effects show in it.
const USUAL: Experiment = at_3_ms("reversing", 15.0);

/// Effects that show better elsewhere.
const OTHERS: [(&str, Experiment); 9] = [
    // Its levels have to pass through the dead zone slowly.
    (ids::DEAD_ZONE, at_3_ms("ramp@0.5", 15.0)),
    (ids::ASYMMETRIC_DEAD_ZONE, at_3_ms("ramp@0.5", 15.0)),
    // A shaft that hardly turns, and starts and stops often.
    (ids::STRIBECK, at_3_ms("ramp@0.5", 15.0)),
    (ids::STATIC_FRICTION, at_3_ms("ramp@0.3", 20.0)),
    // Slow reversals: the play is a large share of the way.
    (ids::BACKLASH, at_3_ms("ramp@0.4", 20.0)),
    // Heat takes tens of seconds.
    (ids::WINDING_HEATING, at_3_ms("brakes", 60.0)),
    (ids::MAGNET_WEAKENING, at_3_ms("brakes", 60.0)),
    // Only the hardest reversals make it slip.
    (ids::SLIPPING_CLUTCH, at_3_ms("square", 15.0)),
    // Half a sample's travel is most at top speed.
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

/// The experiment that shows this effect at its default strength.
pub fn experiment(kind: &EffectKind) -> Experiment {
    let own = OTHERS.iter().find(|(id, _)| *id == kind.id);
    own.map_or(USUAL, |(_, experiment)| *experiment)
}

/// Why no experiment with voltage in and counts out separates this effect from parameters of the motor file; `None`
/// where one does.
pub fn not_identifiable(kind: &EffectKind) -> Option<&'static str> {
    let found = UNIDENTIFIABLE.iter().find(|(id, _)| *id == kind.id);
    found.map(|(_, why)| *why)
}

/// Every id that has a row here.
#[cfg(test)]
pub(super) fn ids() -> impl Iterator<Item = &'static str> {
    let others = OTHERS.iter().map(|(id, _)| *id);
    others.chain(UNIDENTIFIABLE.iter().map(|(id, _)| *id))
}
