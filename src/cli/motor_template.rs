//! Template of a motor file: every key with its unit and the lab handout's value, every effect commented out.

use std::fmt::Write as _;

use crate::effects::{entries, rounded};
use crate::motor::Parameters;
use crate::motor::catalogue::Stage;

/// Description of each key of a motor file, with its unit.
const KEYS: [(&str, &str); Parameters::KEYS.len()] = [
    ("resistance_ohm", "ohm: armature resistance R, motor cold"),
    (
        "back_emf_v_s_per_rad",
        "V s/rad: back-EMF constant Kb, of the shaft that the encoder counts",
    ),
    (
        "torque_constant_nm_per_a",
        "N m/A: torque constant Kt; in these units it equals Kb but for losses of a gear",
    ),
    (
        "viscous_friction_nm_s_per_rad",
        "N m s/rad: friction that grows with speed, b",
    ),
    ("inductance_h", "H: armature inductance L"),
    (
        "inertia_kg_m2",
        "kg m^2: rotor, gear and load together, J, at the shaft that the encoder counts",
    ),
    (
        "coulomb_friction_nm",
        "N m: friction that does not depend on speed, Tf",
    ),
    (
        "counts_per_rev",
        "counts per revolution: lines times 4, times the gear ratio where the encoder sits before the gear",
    ),
    ("supply_v", "V: driver supply, the largest command"),
];

/// Relative tolerance in the examples: the usual one in catalogues of small motors.
const EXAMPLE_TOLERANCE: f64 = 0.1;

pub(super) fn template() -> String {
    let handout = Parameters::default();
    let mut text = String::from(
        "# A motor file of motorlab, in SI units. The numbers are the lab handout's motor: put yours in their place.\n\
         # A key that the file lacks is the handout's, and every command says so.\n\n",
    );
    for (key, what) in KEYS {
        let value = handout.get(key).unwrap_or(0.0);
        let _ = writeln!(text, "# {what}\n{key} = {value:?}");
    }
    text.push_str(
        "\n# How well each number is known: relative, one sigma (0.1: 10 %). A wide tolerance lets a parameter absorb an effect\n\
         # before an effect is named; what stands in no line has a tolerance that is usual for its kind.\n\
         [tolerance]\n",
    );
    for (key, _) in KEYS {
        let _ = writeln!(text, "# {key} = {EXAMPLE_TOLERANCE:?}");
    }
    text.push_str(
        "\n# Effects that are part of the model: take the `# ` away from an effect's lines. A key that is left out has the value\n\
         # that stands here. `motorlab effects ID` says more of each.\n",
    );
    let entries = entries(&handout);
    for stage in Stage::ALL {
        let _ = writeln!(text, "\n# -- {stage} --");
        for entry in entries.iter().filter(|entry| entry.stage == stage) {
            let _ = writeln!(
                text,
                "#\n# # {}\n# [effects.{}]",
                entry.summary, entry.effect
            );
            for number in &entry.parameters {
                let _ = writeln!(text, "# {} = {:?}", number.key, rounded(number.default));
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::Motor;
    use crate::motor::catalogue::catalogue;

    #[test]
    fn the_template_is_read_as_the_handouts_motor() {
        assert_eq!(Motor::from_toml(&template()).unwrap(), Motor::default());
    }

    #[test]
    fn the_template_has_every_key_in_order_and_every_effect_once() {
        assert_eq!(KEYS.map(|(key, _)| key), Parameters::KEYS);
        let text = template();
        let (before, after) = text.split_at(text.find("[tolerance]").unwrap());
        let opened: String = after
            .lines()
            .map(|line| line.strip_prefix("# ").unwrap_or(line).to_owned() + "\n")
            .filter(|line| line.starts_with(['[', '#']) || line.contains(" = "))
            .collect();
        let motor = Motor::from_toml(&format!("{before}{opened}")).unwrap();
        assert_eq!(motor.tolerance.len(), Parameters::KEYS.len());
        assert_eq!(motor.effects.len(), catalogue().len());
    }
}
