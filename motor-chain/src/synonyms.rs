//! Synonyms and misspellings of effects and parameters: an unknown name in, the nearest known one out (Jaro-Winkler similarity).

use crate::catalogue::ids;

/// Synonyms of effects and parameters (in the handout's script, in books, at the bench), with the known name. For an
/// ambiguous word the first candidate among the known names is used.
const ALSO_CALLED: &[(&str, &str)] = &[
    ("friction", ids::COULOMB_FRICTION),
    ("friction", "coulomb_friction_nm"),
    ("dry_friction", ids::COULOMB_FRICTION),
    ("damping", ids::VISCOUS_FRICTION),
    ("damping", "viscous_friction_nm_s_per_rad"),
    ("stiction", ids::STATIC_FRICTION),
    ("breakaway", ids::STATIC_FRICTION),
    ("drag", ids::QUADRATIC_DRAG),
    ("fan", ids::QUADRATIC_DRAG),
    ("gravity", ids::GRAVITY_LOAD),
    ("weight", ids::GRAVITY_LOAD),
    ("load", ids::CONSTANT_LOAD),
    ("slack", ids::BACKLASH),
    ("play", ids::BACKLASH),
    ("gear", ids::BACKLASH),
    ("gearbox", ids::BACKLASH),
    ("spring", ids::COMPLIANCE),
    ("elasticity", ids::COMPLIANCE),
    ("flexible", ids::COMPLIANCE),
    ("clutch", ids::SLIPPING_CLUTCH),
    ("slip", ids::SLIPPING_CLUTCH),
    ("delay", ids::TRANSPORT_DELAY),
    ("latency", ids::TRANSPORT_DELAY),
    ("lag", ids::TRANSPORT_DELAY),
    ("dead_time", ids::TRANSPORT_DELAY),
    ("deadtime", ids::TRANSPORT_DELAY),
    ("deadband", ids::DEAD_ZONE),
    ("dead_band", ids::DEAD_ZONE),
    ("threshold", ids::DEAD_ZONE),
    ("driver", ids::VOLTAGE_DROP),
    ("h_bridge", ids::VOLTAGE_DROP),
    ("l298", ids::VOLTAGE_DROP),
    ("battery", ids::SUPPLY_SAG),
    ("saturation", ids::CURRENT_LIMIT),
    ("coast", ids::COAST_AT_ZERO),
    ("freewheel", ids::PWM_FREEWHEEL),
    ("temperature", ids::WINDING_HEATING),
    ("heat", ids::WINDING_HEATING),
    ("heating", ids::WINDING_HEATING),
    ("thermal", ids::WINDING_HEATING),
    ("ripple", ids::TORQUE_RIPPLE),
    ("demagnetization", ids::MAGNET_WEAKENING),
    ("eccentricity", ids::ENCODER_ECCENTRICITY),
    ("resolution", ids::RESOLUTION_ERROR),
    ("missing_counts", ids::MISSED_COUNTS),
    ("lost_counts", ids::MISSED_COUNTS),
    ("filter", ids::SPEED_FILTER),
    ("jitter", ids::SAMPLE_JITTER),
    ("clock", ids::CLOCK_ERROR),
    ("r", "resistance_ohm"),
    ("rm", "resistance_ohm"),
    ("kb", "back_emf_v_s_per_rad"),
    ("ke", "back_emf_v_s_per_rad"),
    ("kt", "torque_constant_nm_per_a"),
    ("b", "viscous_friction_nm_s_per_rad"),
    ("bm", "viscous_friction_nm_s_per_rad"),
    ("l", "inductance_h"),
    ("lm", "inductance_h"),
    ("j", "inertia_kg_m2"),
    ("jm", "inertia_kg_m2"),
    ("tf", "coulomb_friction_nm"),
    ("encoder_counts", "counts_per_rev"),
    ("cpr", "counts_per_rev"),
    ("vsupply", "supply_v"),
    ("v_supply", "supply_v"),
];

/// Least Jaro-Winkler similarity of a misspelling: below it, proposals are wrong.
const ALIKE_FROM: f64 = 0.84;

/// The one of `names` meant by `asked`, if any: by synonym, as the only name that contains it, or else as the most
/// similar. A dissimilar name gives none, as a wrong proposal would mislead.
/// alike. A name far from all others is no typing error; a wrong proposal would mislead.
pub fn nearest_name<'a>(asked: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let asked = asked.trim().to_lowercase().replace(['-', ' '], "_");
    let names: Vec<&str> = names.into_iter().collect();
    let same = names.iter().find(|name| **name == asked);
    let called = ALSO_CALLED.iter().filter(|(word, _)| *word == asked);
    let called = || {
        let mut meant = called.map(|(_, name)| *name);
        meant.find_map(|name| names.iter().find(|known| **known == name))
    };
    same.or_else(called)
        .or_else(|| only_with_part(&asked, &names))
        .or_else(|| most_alike(&asked, &names))
        .copied()
}

fn only_with_part<'n, 'a>(asked: &str, names: &'n [&'a str]) -> Option<&'n &'a str> {
    let mut with = names
        .iter()
        .filter(|name| name.split('_').any(|part| part == asked));
    with.next().filter(|_| with.next().is_none())
}

fn most_alike<'n, 'a>(asked: &str, names: &'n [&'a str]) -> Option<&'n &'a str> {
    let alike = names
        .iter()
        .map(|name| (strsim::jaro_winkler(asked, name), name));
    let best = alike.max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(likeness, _)| *likeness >= ALIKE_FROM)
        .map(|(_, name)| name)
}

/// Whether one name is a misspelling of the other.
pub fn is_alike(asked: &str, name: &str) -> bool {
    strsim::jaro_winkler(asked, name) >= ALIKE_FROM
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Parameters;
    use crate::catalogue::{catalogue, find};

    fn effect(asked: &str) -> Option<&'static str> {
        nearest_name(asked, catalogue().iter().map(|kind| kind.id))
    }

    #[test]
    fn every_suggestion_exists() {
        for (word, name) in ALSO_CALLED {
            let is_there = find(name).is_some() || Parameters::KEYS.contains(name);
            assert!(is_there, "{word}: {name}");
            assert!(
                find(word).is_none() && !Parameters::KEYS.contains(word),
                "{word}"
            );
        }
    }

    #[test]
    fn synonyms_and_misspellings_suggest_the_right_term() {
        for (asked, name) in [
            ("friction", "coulomb_friction"),
            ("Backlash", "backlash"),
            ("dead-zone", "dead_zone"),
            ("deadzone", "dead_zone"),
            ("lag", "transport_delay"),
            ("stiction", "static_friction"),
            ("slack", "backlash"),
            ("backlsh", "backlash"),
            ("cog", "cogging"),
            ("eccentricity", "encoder_eccentricity"),
            ("visous_friction", "viscous_friction"),
            ("stribek", "stribeck"),
            ("sag", "supply_sag"),
        ] {
            assert_eq!(effect(asked), Some(name), "{asked}");
        }
        let key = |asked| nearest_name(asked, Parameters::KEYS);
        for (asked, name) in [
            ("Kt", "torque_constant_nm_per_a"),
            ("Rm", "resistance_ohm"),
            ("resistance", "resistance_ohm"),
            ("resistence_ohm", "resistance_ohm"),
            ("supply", "supply_v"),
            ("Vsupply", "supply_v"),
            ("inertia", "inertia_kg_m2"),
            ("friction", "coulomb_friction_nm"),
        ] {
            assert_eq!(key(asked), Some(name), "{asked}");
        }
    }

    #[test]
    fn unrelated_words_suggest_nothing() {
        for asked in ["noise", "motor", "banana", "x", "", "error"] {
            assert_eq!(effect(asked), None, "{asked}");
        }
    }
}
