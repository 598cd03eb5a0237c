//! What has changed since reference runs, in plain sentences.

use super::words::{rivals, three};
use crate::diagnose::report::{Cause, Interval};
use crate::motor::catalogue::find;

/// What a diagnosis against a reference says beside its own figures.
#[derive(Debug, Clone, Default)]
pub(crate) struct Since {
    /// How the named effects have changed, a sentence each.
    pub changed: Vec<String>,
    /// Sets that the runs show and that the reference may have had as well.
    pub alike: Vec<Vec<&'static str>>,
}

/// What the runs show that is no change, since the reference may have had it as well.
pub(crate) fn alike(since: &Since) -> Option<String> {
    (!since.alike.is_empty()).then(|| {
        format!(
            "These runs show {}, which the reference may have had as well.",
            rivals(&since.alike)
        )
    })
}

/// A sentence on each named effect: its first number, of those that differ by direction both.
pub(crate) fn changes(effects: &[&'static str], causes: &[Cause]) -> Vec<String> {
    let set = effects.join("+");
    let Some(cause) = causes.iter().find(|cause| cause.effect == set) else {
        return Vec::new();
    };
    let numbers = cause.parameters.iter().filter_map(|(name, number)| {
        let (effect, key) = name.split_once('.').unwrap_or((&set, name));
        let first = find(effect)?.1.parameters.first()?.key;
        match key {
            "positive_v" | "negative_v" => {
                let side = key.trim_end_matches("_v");
                Some(sentence(&format!("{effect} ({side})"), number))
            }
            _ => (key == first).then(|| sentence(effect, number)),
        }
    });
    numbers.collect()
}

/// How one number has changed.
fn sentence(effect: &str, number: &Interval) -> String {
    let effect = effect.replace('_', " ");
    let unit = match number.unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let value = three(number.value);
    match number.reference.filter(|then| *then != 0.0) {
        None => format!("Since the reference {effect} is new, with {value}{unit}."),
        Some(then) => {
            let has = match number.value.abs() > then.abs() {
                true => "grown",
                false => "shrunk",
            };
            let then = three(then);
            format!("Since the reference {effect} has {has} from {then} to {value}{unit}.")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_said_with_both_values() {
        let said = |effect: &str, value: f64, reference: Option<f64>, unit: &'static str| {
            let number = Interval {
                value,
                lo95: value,
                hi95: value,
                unit,
                reference,
            };
            sentence(effect, &number)
        };
        assert_eq!(
            said("coulomb_friction", 0.05123, Some(0.02), "N m"),
            "Since the reference coulomb friction has grown from 0.02 to 0.0512 N m."
        );
        assert_eq!(
            said("supply_error", 0.85, Some(1.0), ""),
            "Since the reference supply error has shrunk from 1 to 0.85."
        );
        for nothing in [None, Some(0.0)] {
            assert_eq!(
                said("backlash", 0.02, nothing, "rad"),
                "Since the reference backlash is new, with 0.02 rad."
            );
        }
    }
}
