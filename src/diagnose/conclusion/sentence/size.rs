//! First part: how large the gap is, and against what floor.

use super::Beside;
use crate::diagnose::conclusion::words::{counts, digits, three};
use crate::diagnose::report::{Diagnosis, FloorParts, NominalSource, SeenMotor};
use crate::units::rpm_from_rad_s;

/// What the runs are held against and by how much it misses them.
pub(super) fn size(said: &Diagnosis, beside: &Beside) -> Vec<String> {
    let gap = &said.gap;
    let mut sentences = Vec::new();
    let subject = match (&beside.since, &said.fitted_nominal) {
        (Some(_), _) => "The reference's motor",
        (None, Some(seen)) => {
            sentences.push(fitted(seen));
            "It"
        }
        (None, None) => "The simulation",
    };
    let held = match beside.is_held_out {
        true => " of the runs held out",
        false => "",
    };
    let share = match gap.travel {
        travel if travel > 0.0 => {
            format!(" ({} % of the travel)", digits(100.0 * gap.before / travel))
        }
        _ => String::new(),
    };
    sentences.push(format!(
        "{subject} misses the position{held} by {} counts RMS{share}; {}.",
        counts(gap.before),
        floor(&gap.floor_parts)
    ));
    // What a wandering load leaves is a second floor where it is above the first.
    if gap.wander > gap.floor {
        sentences.push(wander(said, beside));
    }
    sentences
}

/// What no model is asked to explain, with where it comes from.
fn floor(parts: &FloorParts) -> String {
    let largest = parts.largest();
    let floor = counts(largest);
    match parts {
        _ if parts.good_enough == Some(largest) => format!("{floor} is good enough, as asked"),
        _ if parts.repeats == Some(largest) => format!("repeated runs alone differ by {floor}"),
        _ => format!("rounding to whole counts makes {floor}"),
    }
}

/// The motor where nobody says which it is, in what the runs tell.
pub(super) fn fitted(seen: &SeenMotor) -> String {
    let unit = seen.command_unit;
    let load = seen
        .load_per_nm
        .map(|load| format!(" A load of 1 N m takes {} {unit}.", three(load)));
    format!(
        "A plain motor is fitted to the runs: {} RPM per {unit}, time constant {} s, friction {} {unit}.{}",
        three(rpm_from_rad_s(seen.steady_rad_s_per_unit)),
        three(seen.time_constant_s),
        three(seen.friction),
        load.unwrap_or_default()
    )
}

/// Whose numbers the simulation has where no motor file says.
pub(super) fn source(said: &Diagnosis) -> Option<String> {
    match (said.nominal_source, &said.fitted_nominal) {
        (NominalSource::Given, _) => None,
        (NominalSource::Handout, _) => {
            Some("No motor file is given: the simulation is of the lab handout's motor.".to_owned())
        }
        (NominalSource::Fit, seen) => seen.as_ref().map(fitted),
    }
}

/// A load that wanders.
pub(super) fn wander(said: &Diagnosis, beside: &Beside) -> String {
    format!(
        "A load that wanders by {} % of the stall torque makes {} counts, which no model can follow.",
        digits(100.0 * beside.wander_share),
        counts(said.gap.wander)
    )
}
