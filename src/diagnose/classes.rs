//! Classes of effects that one recording seldom separates.

/// Class ids with their members.
const CLASSES: [(&str, &[&str]); 6] = [
    (
        "direction_offset",
        &[
            "asymmetric_friction",
            "constant_load",
            "asymmetric_voltage_drop",
            "asymmetric_dead_zone",
        ],
    ),
    ("direction_gain", &["asymmetric_viscous", "asymmetric_gain"]),
    (
        "large_command",
        &[
            "supply_sag",
            "current_limit",
            "winding_heating",
            "quadratic_drag",
        ],
    ),
    ("start", &["static_friction", "stribeck", "dead_zone"]),
    (
        "lag",
        &[
            "transport_delay",
            "speed_filter",
            "inductance",
            "command_offset",
        ],
    ),
    ("driving", &["load_friction", "voltage_drop"]),
];

/// The class of an effect.
pub(crate) fn class_of(id: &str) -> Option<&'static str> {
    let found = CLASSES.iter().find(|(_, members)| members.contains(&id));
    found.map(|(class, _)| *class)
}

/// Members of a class.
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
