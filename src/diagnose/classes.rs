//! Classes of effects that one recording rarely separates.

use crate::motor::catalogue::ids;

/// Class ids with their members.
const CLASSES: [(&str, &[&str]); 6] = [
    (
        "direction_offset",
        &[
            ids::ASYMMETRIC_FRICTION,
            ids::CONSTANT_LOAD,
            ids::ASYMMETRIC_VOLTAGE_DROP,
            ids::ASYMMETRIC_DEAD_ZONE,
        ],
    ),
    (
        "direction_gain",
        &[ids::ASYMMETRIC_VISCOUS, ids::ASYMMETRIC_GAIN],
    ),
    (
        "large_command",
        &[
            ids::SUPPLY_SAG,
            ids::CURRENT_LIMIT,
            ids::WINDING_HEATING,
            ids::QUADRATIC_DRAG,
        ],
    ),
    (
        "start",
        &[ids::STATIC_FRICTION, ids::STRIBECK, ids::DEAD_ZONE],
    ),
    (
        "lag",
        &[
            ids::TRANSPORT_DELAY,
            ids::SPEED_FILTER,
            ids::INDUCTANCE,
            ids::COMMAND_OFFSET,
        ],
    ),
    ("driving", &[ids::LOAD_FRICTION, ids::VOLTAGE_DROP]),
];

pub(crate) fn class_of(id: &str) -> Option<&'static str> {
    let found = CLASSES.iter().find(|(_, members)| members.contains(&id));
    found.map(|(class, _)| *class)
}

pub(crate) fn members_of(class: &str) -> &'static [&'static str] {
    let found = CLASSES.iter().find(|(id, _)| *id == class);
    found.map_or(&[], |(_, members)| members)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::catalogue::find;

    #[test]
    fn every_member_is_an_effect_of_one_class() {
        for (class, members) in CLASSES {
            for id in members {
                assert!(find(id).is_some(), "{id}");
                assert_eq!(class_of(id), Some(class));
            }
            assert_eq!(members_of(class), members);
        }
    }
}
