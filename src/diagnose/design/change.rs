//! Known changes on the bench that an experiment may propose: a disc, another supply.

use crate::diagnose::report::KnownChange;
use crate::motor::{KnownDifferences, Motor};

/// Candidate changes: a disc that doubles the inertia, rounded to one digit because it has to be made, and another
/// supply.
pub(super) fn known_changes(motor: &Motor, supply_share: f64) -> [KnownChange; 2] {
    let p = &motor.parameters;
    let changes = [
        ("inertia_added_kg_m2", one_digit(p.inertia_kg_m2)),
        ("supply_v", supply_share * p.supply_v),
    ];
    changes.map(|(key, value)| KnownChange {
        key: key.to_owned(),
        value,
    })
}

/// A change in the form of simulations; `None` without one.
pub(super) fn differences(change: Option<&KnownChange>) -> Option<KnownDifferences> {
    let mut known = KnownDifferences::default();
    if let Some(KnownChange { key, value }) = change {
        known.set(key, *value).ok()?;
    }
    Some(known)
}

fn one_digit(value: f64) -> f64 {
    // Rounding by way of text, to avoid fifteen digits.
    format!("{value:.0e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proposed_changes_have_one_digit_and_are_known_differences() {
        for (value, short) in [
            (0.002_19, 0.002),
            (0.0945, 0.09),
            (7.6e-6, 8e-6),
            (96.0, 100.0),
        ] {
            assert_eq!(one_digit(value), short);
        }
        for change in known_changes(&Motor::default(), 0.5) {
            let known = differences(Some(&change)).expect("a key of the known differences");
            assert_eq!(known.has_torque(), change.key != "supply_v");
        }
    }
}
