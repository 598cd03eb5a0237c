//! Voltages, current and torques, before friction and before the torque of the transmission.

use super::{Function, Line, Writer, set};
use crate::export::actuator::constants::of;
use crate::motor::catalogue::ids;

impl Writer<'_> {
    pub(super) fn wave(&self, id: &str, amplitude: &str) -> Option<String> {
        let name = id.replace('#', "_").to_uppercase();
        self.has(id).then(|| {
            format!("{name}_{amplitude} * sin({name}_CYCLES_PER_REV * angle + {name}_PHASE_RAD)")
        })
    }

    pub(super) fn forces(&self) -> Function {
        let mut lines = Vec::new();
        let mut volts = "u".to_owned();
        if self.has(ids::SUPPLY_ERROR) {
            volts += " * SUPPLY_ERROR_GAIN";
        }
        if self.has(ids::ASYMMETRIC_GAIN) {
            volts += " * (1.0 + ASYMMETRIC_GAIN_RATIO * sgn(u))";
        }
        lines.push(set("volts", volts));
        let ripples: Vec<String> = [ids::TORQUE_RIPPLE, "torque_ripple#2"]
            .iter()
            .filter_map(|id| self.wave(id, "AMPLITUDE"))
            .collect();
        let mut factors = Vec::new();
        if self.weakens {
            factors.push("(1.0 - WEAKENING_PER_W * loss)".to_owned());
        }
        if !ripples.is_empty() {
            factors.push(format!("(1.0 + {})", ripples.join(" + ")));
        }
        let times = if factors.is_empty() {
            ""
        } else {
            lines.push(set("factor", factors.join(" * ")));
            " * factor"
        };
        lines.push(set("emf", format!("BACK_EMF_V_S_PER_RAD * speed{times}")));
        self.excess(&mut lines);
        let mut resistance = "RESISTANCE_OHM".to_owned();
        if self.has(ids::WINDING_HEATING) {
            resistance += " * (1.0 + WINDING_HEATING_RESISTANCE_RISE_PER_W * loss)";
        }
        if self.has(ids::SUPPLY_SAG) {
            resistance += " + SUPPLY_SAG_SOURCE_RESISTANCE_OHM * (u / SUPPLY_V) * (u / SUPPLY_V)";
        }
        lines.push(set("resistance", resistance));
        let mut flowing = "current".to_owned();
        if !self.inductive {
            flowing = if self.drops {
                "(high(excess - DROP_FORWARD_V, 0.0) - high(-excess - DROP_BACK_V, 0.0)) / resistance".to_owned()
            } else {
                "excess / resistance".to_owned()
            };
            if self.limited {
                flowing =
                    format!("high(low({flowing}, CURRENT_LIMIT_LIMIT_A), -CURRENT_LIMIT_LIMIT_A)");
            }
        }
        if self.opens {
            flowing = format!("pick((u == 0.0), 0.0, {flowing})");
        }
        lines.push(set("flowing", flowing));
        lines.push(set(
            "torque",
            format!("TORQUE_CONSTANT_NM_PER_A * flowing{times}"),
        ));
        let mut net = "torque".to_owned();
        for wave in [ids::COGGING, "cogging#2"]
            .iter()
            .filter_map(|id| self.wave(id, "TORQUE_NM"))
        {
            net += " + ";
            net += &wave;
        }
        let side = self.sides[self.sides.len() - 1];
        let mut load = "load".to_owned();
        if self.has(ids::GRAVITY_LOAD) {
            load += &format!(
                " - GRAVITY_LOAD_TORQUE_NM * sin({} + GRAVITY_LOAD_PHASE_RAD)",
                side.angle
            );
        }
        if self.has(ids::QUADRATIC_DRAG) {
            load += &format!(
                " - QUADRATIC_DRAG_COEFFICIENT_NM_S2_PER_RAD2 * {0} * mag({0})",
                side.speed
            );
        }
        if self.has(ids::CONSTANT_LOAD) {
            load += " - CONSTANT_LOAD_TORQUE_NM";
        }
        let mut gives: Vec<String> = ["excess", "resistance", "flowing", "torque"]
            .map(String::from)
            .to_vec();
        if self.two() {
            gives.extend([net, load]);
        } else {
            gives.push(format!("{net} + {load}"));
        }
        Function {
            name: "forces",
            comment: "voltage that drives the current, resistance, current, motor torque, torque on each side but for friction",
            parameters: &["y", "u", "load"],
            lines,
            gives,
        }
    }

    pub(super) fn call_forces(&self) -> Line {
        let mut gives = vec!["excess", "resistance", "flowing", "torque"];
        gives.extend(self.sides.iter().map(|side| side.net));
        Line::Call("f", "forces", "y, u, load", gives)
    }

    /// Voltage minus back EMF; a freewheeling bridge drives the mean current of a period.
    pub(super) fn excess(&self, lines: &mut Vec<Line>) {
        if !self.has(ids::PWM_FREEWHEEL) {
            lines.push(set("excess", "volts - emf"));
            return;
        }
        let into_supply = of(self.motor, ids::PWM_FREEWHEEL).is_some_and(|v| v[1] >= 0.5);
        lines.extend([
            set("duty", "mag(u) / SUPPLY_V"),
            set("pulse", "volts * sgn(u) / high(duty, 1e-12)"),
            set("rises", "pulse - emf * sgn(u)"),
            set("falls", if into_supply { "-pulse - emf * sgn(u)" } else { "-emf * sgn(u)" }),
            set("most", "high(rises, 0.0) * (1.0 - exp(-duty * PWM_FREEWHEEL_PERIOD_RATIO))"),
            set("lasts", "log(1.0 - most / low(falls, -1e-12))"),
            set(
                "average",
                "duty * rises + pick((falls < 0.0) & (lasts < (1.0 - duty) * PWM_FREEWHEEL_PERIOD_RATIO), \
                 falls * lasts / PWM_FREEWHEEL_PERIOD_RATIO, (1.0 - duty) * falls)",
            ),
            set(
                "excess",
                "pick((u == 0.0) | (duty >= 1.0), volts - emf, pick((rises <= 0.0), rises, average) * sgn(u))",
            ),
        ]);
    }
}
