//! Known changes on the bench that an experiment may propose: a disc, a load on an arm, another supply.

use crate::diagnose::report::KnownChange;
use crate::diagnose::settings::{KNOWN_LOAD, OTHER_SUPPLY};
use crate::motor::{KnownDifferences, Motor};

/// What is changed on the bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Change {
    /// Nothing.
    None,
    /// A key of [`KnownDifferences`] has this value.
    Known(&'static str, f64),
}

impl Change {
    pub fn known(self) -> Option<KnownDifferences> {
        let mut known = KnownDifferences::default();
        if let Self::Known(key, value) = self {
            known.set(key, value).ok()?;
        }
        Some(known)
    }

    pub fn supply_v(self) -> Option<f64> {
        match self {
            Self::Known("supply_v", supply_v) => Some(supply_v),
            _ => None,
        }
    }

    pub fn said(self) -> Option<KnownChange> {
        match self {
            Self::None => None,
            Self::Known(key, value) => Some(KnownChange {
                key: key.to_owned(),
                value,
            }),
        }
    }
}

/// The known changes that are tried: as much inertia again, another supply, and a load on an arm unless something hangs there
/// already. Figures are rounded to one digit: they are to be made.
pub(super) fn known_changes(motor: &Motor, supply_v: f64, is_hanging: bool) -> Vec<Change> {
    let p = &motor.parameters;
    let stall_nm = p.torque_constant_nm_per_a * supply_v / p.resistance_ohm;
    let mut changes = vec![
        Change::Known("inertia_added_kg_m2", one_digit(p.inertia_kg_m2)),
        Change::Known("supply_v", OTHER_SUPPLY * supply_v),
    ];
    if !is_hanging {
        let load_nm = one_digit(KNOWN_LOAD * stall_nm);
        changes.push(Change::Known("gravity_torque_nm", load_nm));
    }
    changes
}

fn one_digit(value: f64) -> f64 {
    // By way of text, or it has fifteen digits.
    format!("{value:.0e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_to_be_made_has_one_digit() {
        for (value, short) in [
            (0.002_19, 0.002),
            (0.0945, 0.09),
            (7.6e-6, 8e-6),
            (96.0, 100.0),
        ] {
            assert_eq!(one_digit(value), short);
        }
    }
}
