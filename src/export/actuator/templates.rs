//! The files: a template per language, filled with the motor's constants and equations.

use super::constants::{Constant, constants, output_inertia};
use super::equations::Equations;
use super::language::{Language, names};
use super::{NotPart, divided};
use crate::motor::Motor;
use crate::motor::catalogue::ids;

/// Language of an actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A C function.
    C,
    /// A Python function.
    Python,
    /// A function of MATLAB, Simulink and Octave.
    Octave,
    /// A class for Isaac Lab, on torch.
    IsaacLab,
    /// A Python module for MuJoCo's callback.
    Mujoco,
}

impl Target {
    fn language(self) -> Language {
        match self {
            Self::C => Language::C,
            Self::Octave => Language::Matlab,
            Self::Python | Self::IsaacLab | Self::Mujoco => Language::Python,
        }
    }

    fn template(self) -> String {
        match self {
            Self::C => include_str!("templates/motor.c").to_owned(),
            Self::Octave => include_str!("templates/motor_step.m").to_owned(),
            Self::IsaacLab => include_str!("templates/torch.py").to_owned(),
            Self::Python => include_str!("templates/motor.py").to_owned(),
            Self::Mujoco => concat!(
                include_str!("templates/motor.py"),
                include_str!("templates/mujoco.py")
            )
            .to_owned(),
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::C => {
                "DC motor with its effects in C: motor_start, motor_step; compile with -lm. SI units."
            }
            Self::Python => {
                "DC motor with its effects in plain Python: State, step, joint_torque. SI units."
            }
            Self::Octave => "DC motor with its effects for MATLAB, Simulink and Octave. SI units.",
            Self::IsaacLab => {
                "DC motor with its effects as an actuator of Isaac Lab, on torch. SI units."
            }
            Self::Mujoco => {
                "DC motor with its effects for MuJoCo: install(model) after loading the MJCF file beside it. SI units."
            }
        }
    }

    /// The file of this motor, for steps of `step_s` seconds.
    pub fn file(self, motor: &Motor, step_s: f64) -> String {
        let language = self.language();
        let equations = Equations::of(motor);
        let delay_s = motor
            .effects
            .get(ids::TRANSPORT_DELAY)
            .map_or(0.0, |effect| effect.values[0]);
        let whole = (delay_s / step_s + 1e-9).floor();
        let late_s = Some(delay_s - whole * step_s)
            .filter(|s| *s > 1e-9 * step_s)
            .unwrap_or(0.0);
        let inertia = output_inertia(motor);
        let mut all = constants(motor);
        let mut own = |name: &str, value: f64, unit: &'static str, meaning: &str| {
            all.push(Constant {
                name: name.to_owned(),
                value,
                unit,
                meaning: meaning.to_owned(),
            });
        };
        own(
            "OUTPUT_INERTIA_KG_M2",
            inertia,
            "kg m^2",
            "inertia of the output shaft",
        );
        own("STEP_S", step_s, "s", "time of a step");
        own(
            "DELAY_S",
            delay_s,
            "s",
            "time after which a command reaches the driver",
        );
        own("LATE_S", late_s, "s", "what of it is beyond whole steps");
        let template = self.template();
        let functions: Vec<String> = equations
            .functions
            .iter()
            .map(|function| language.function(function, &equations))
            .collect();
        let functions = functions.join(if language == Language::Python {
            "\n\n"
        } else {
            "\n"
        });
        let used = |name: &str| {
            [functions.as_str(), &equations.command, &template]
                .iter()
                .any(|text| names(text, name))
        };
        let listed: String = (all.iter().filter(|c| used(&c.name)))
            .map(|c| language.constant(c))
            .collect();
        let put: [(&str, String); 14] = [
            ("@HEADER@", self.header(motor)),
            ("@CONSTANTS@", listed),
            ("@FUNCTIONS@", functions),
            ("@COMMAND@", language.expression(&equations.command)),
            ("@STATE@", equations.y.len().to_string()),
            ("@MODE@", equations.m.len().to_string()),
            ("@EVENTS@", equations.guards.to_string()),
            ("@HISTORY@", (whole as usize + 2).to_string()),
            ("@NAMES@", equations.y.join(", ")),
            ("@OUTPUT@", equations.output.to_string()),
            ("@OUTPUT1@", (equations.output + 1).to_string()),
            ("@OUTPUT2@", (equations.output + 2).to_string()),
            ("@ENCODER@", equations.encoder.to_string()),
            ("@ENCODER1@", (equations.encoder + 1).to_string()),
        ];
        put.into_iter()
            .fold(template, |text, (name, value)| text.replace(name, &value))
    }

    /// The header comment: description, effects, effects left out, assumptions.
    fn header(self, motor: &Motor) -> String {
        let (part, not_part) = divided(motor);
        let effects = if part.is_empty() {
            "none".to_owned()
        } else {
            part.join(", ")
        };
        let mut lines = vec![
            self.title().to_owned(),
            format!("Effects in it: {effects}."),
        ];
        lines.extend(motor.assumptions());
        lines.extend(
            not_part
                .iter()
                .map(|NotPart { effect, why }| format!("NOT IN IT: {effect}: {why}.")),
        );
        let lines: Vec<String> = lines
            .iter()
            .map(|line| self.language().comment(line))
            .collect();
        lines.join("\n")
    }
}
