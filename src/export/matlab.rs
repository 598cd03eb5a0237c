//! `Motor_Parameters.m`: the lab handout's parameter script for MATLAB and Octave.
//!
//! Effects are in a struct `effects` with their equations; the handout's Simulink diagram has no block for them.

use std::fmt::Write;

use super::{EQUATIONS, PARAMETERS};
use crate::motor::Motor;

/// File name that the handout's script loads.
pub const FILE_NAME: &str = "Motor_Parameters.m";

/// The script. Values read back as the same double.
pub fn script(motor: &Motor) -> String {
    let mut out = String::from("% Motor_Parameters.m: DC motor, SI units\n");
    for line in motor.assumptions() {
        let _ = writeln!(out, "% {line}");
    }
    for equation in EQUATIONS {
        let _ = writeln!(out, "%   {equation}");
    }
    for named in PARAMETERS {
        let value = named.value(&motor.parameters);
        let assigned = format!("{} = {value:?};", named.handout);
        let _ = writeln!(
            out,
            "{assigned:<24} % {}, {}: {}",
            named.unit, named.symbol, named.meaning
        );
    }
    out.push_str("RADSEC2RPM = 60/(2*pi);   % RPM of one rad/s\n");
    out.push_str("COUNTS2RAD = 2*pi/encoder_counts;   % rad of one count\n");
    out.push_str("effects = struct();\n");
    for effect in motor.effects.iter() {
        let kind = effect.kind();
        let _ = writeln!(
            out,
            "\n% {} ({} stage), not in the handout's diagram: {}\n%   {}",
            kind.id, kind.stage, kind.summary, kind.equation
        );
        for (parameter, value) in effect.parameters() {
            let unit = if parameter.unit.is_empty() {
                "1"
            } else {
                parameter.unit
            };
            let _ = writeln!(
                out,
                "effects.{}.{} = {value:?};   % {unit}",
                kind.id, parameter.key
            );
        }
    }
    out
}
