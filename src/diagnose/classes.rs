//! Relations between effects: classes that one recording rarely separates, and effects that differ by direction.

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

/// Effects that differ by direction, with the effect that is the same in both.
const BY_DIRECTION: [(&str, Option<&str>); 5] = [
    (ids::ASYMMETRIC_DEAD_ZONE, Some(ids::DEAD_ZONE)),
    (ids::ASYMMETRIC_VOLTAGE_DROP, Some(ids::VOLTAGE_DROP)),
    (ids::ASYMMETRIC_FRICTION, None),
    (ids::ASYMMETRIC_VISCOUS, None),
    (ids::ASYMMETRIC_GAIN, None),
];

pub(crate) fn is_by_direction(id: &str) -> bool {
    BY_DIRECTION.iter().any(|(effect, _)| *effect == id)
}

/// The effect that is the same in both directions, of one that differs by direction.
pub(crate) fn symmetric_of(id: &str) -> Option<&'static str> {
    let found = BY_DIRECTION.iter().find(|(effect, _)| *effect == id);
    found.and_then(|(_, symmetric)| *symmetric)
}

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
    use crate::motor::catalogue::{catalogue, find};

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

    #[test]
    fn every_asymmetric_effect_differs_by_direction() {
        for kind in catalogue() {
            let is_named_so = kind.id.starts_with("asymmetric_");
            assert_eq!(is_by_direction(kind.id), is_named_so, "{}", kind.id);
        }
        for (id, symmetric) in BY_DIRECTION {
            assert_eq!(symmetric_of(id), symmetric);
            assert!(find(id).is_some());
            assert!(symmetric.is_none_or(|id| find(id).is_some()), "{id}");
        }
    }
}
