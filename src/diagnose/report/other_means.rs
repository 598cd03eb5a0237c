//! Measurements that separate causes which voltage and angle do not.
//!
//! Errors of the supply, of the resolution and of a motor constant have the same response. A voltmeter, or one turn
//! by hand, separates them.

use super::{Diagnosis, Verdict};
use crate::diagnose::classes::members_of;
use crate::motor::catalogue::ids;

/// Measurements for effects that others imitate exactly, or nearly so within tolerances.
const MEANS: [(&str, &str); 14] = [
    (
        ids::SUPPLY_ERROR,
        "measure the driver's supply under load with a voltmeter",
    ),
    (
        ids::VOLTAGE_DROP,
        "measure the motor's terminals while it turns, against the duty commanded",
    ),
    (
        ids::SUPPLY_SAG,
        "measure the supply at rest and at full duty",
    ),
    (
        ids::RESOLUTION_ERROR,
        "turn the shaft ten turns by hand and read the count",
    ),
    (
        ids::MISSED_COUNTS,
        "turn to a mark and back, and read the count there",
    ),
    (
        ids::CLOCK_ERROR,
        "time a long run with a stopwatch, or record the host's time",
    ),
    (
        ids::INERTIA,
        "weigh and measure what turns, or record with a known disc added",
    ),
    (
        ids::COULOMB_FRICTION,
        "measure the torque that just starts it, with a string and a weight",
    ),
    (
        ids::VISCOUS_FRICTION,
        "let it coast with the motor's leads open",
    ),
    (ids::CURRENT_LIMIT, "measure the current at stall"),
    (ids::WINDING_HEATING, "measure the resistance cold and hot"),
    (
        ids::GRAVITY_LOAD,
        "turn the motor's axis upright and record again",
    ),
    (
        ids::ENCODER_ECCENTRICITY,
        "look at the count over one slow turn against a mark",
    ),
    (
        ids::ASYMMETRIC_FRICTION,
        "measure the starting torque both ways",
    ),
];

/// Measurement for an ambiguous verdict without a useful profile; `None` if there is none.
pub fn other_means(diagnosis: &Diagnosis) -> Option<String> {
    if diagnosis.verdict != Verdict::Ambiguous || diagnosis.next_experiment.is_some() {
        return None;
    }
    let likeliest = diagnosis.causes.first()?;
    let class = likeliest.class.map_or(&[][..], members_of);
    let in_play = std::iter::once(&likeliest.effect)
        .chain(class.iter().filter(|id| **id != likeliest.effect));
    let in_play: Vec<&&'static str> = in_play.collect();
    let measured = in_play.iter().filter_map(|id| {
        let (_, what) = MEANS.iter().find(|(known, _)| *known == **id)?;
        Some(format!("{what} ({})", id.replace('_', " ")))
    });
    let means: Vec<String> = measured.collect();
    let names: Vec<String> = in_play.iter().map(|id| id.replace('_', " ")).collect();
    (!means.is_empty()).then(|| {
        format!(
            "No profile within this supply separates {} well. By other means: {}.",
            names.join(", "),
            means.join("; ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::catalogue::catalogue;

    #[test]
    fn every_name_is_one_of_the_catalogue() {
        for (id, _) in MEANS {
            assert!(catalogue().iter().any(|kind| kind.id == id), "{id}");
        }
    }
}
