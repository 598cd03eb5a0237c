//! The mode that follows from a state, and the derivatives in it.

use super::{Function, LOAD, Line, MOTOR, Writer, set};

impl Writer<'_> {
    /// The mode that follows from a state.
    pub(super) fn mode(&self, m: &[&'static str]) -> Function {
        let mut lines = vec![self.call_forces()];
        self.levels(&mut lines);
        if self.halts() {
            self.flow(&mut lines);
        }
        if self.welds() {
            self.joint(&mut lines);
        } else {
            if self.gap {
                lines.push(set("touch", "contact"));
            }
            self.link(&mut lines);
            for side in &self.sides {
                let net = self.net_with_link(side);
                lines.push(set(side.slip, self.slip(side, &net)));
            }
        }
        if self.preslides {
            for side in &self.sides {
                lines.push(set(side.from[0], side.angle));
                lines.push(set(side.from[1], side.friction));
                lines.push(set(side.from[2], self.steady(side)));
            }
        }
        Function {
            name: "mode",
            comment: "the mode that holds from a state on: directions of slip (0 sticks), whether current flows, what touches",
            parameters: &["y", "u", "load"],
            lines,
            gives: m.iter().map(|name| (*name).to_owned()).collect(),
        }
    }

    /// Whether current flows, and against which drop.
    pub(super) fn flow(&self, lines: &mut Vec<Line>) {
        let mut flows = Vec::new();
        if self.drops {
            lines.push(set(
                "way",
                "pick((flowing == 0.0), pick((excess > DROP_FORWARD_V), 1.0, pick((excess < -DROP_BACK_V), -1.0, 0.0)), sgn(flowing))",
            ));
            flows.push("mag(way)".to_owned());
        } else {
            lines.push(set("way", "sgn(flowing)"));
        }
        if self.limited {
            let drop = if self.drops {
                " - pick((way < 0.0), DROP_BACK_V, DROP_FORWARD_V)"
            } else {
                ""
            };
            flows.push(format!(
                "pick((mag(flowing) >= CURRENT_LIMIT_LIMIT_A) & (excess * way{drop} - resistance * CURRENT_LIMIT_LIMIT_A > 0.0), 0.0, 1.0)"
            ));
        }
        if self.opens {
            flows.push("pick((u == 0.0), 0.0, 1.0)".to_owned());
        }
        lines.push(set("flows", flows.join(" * ")));
    }

    pub(super) fn rates(&self, y: &[&'static str]) -> Function {
        let mut lines = vec![self.call_forces()];
        self.friction(&mut lines);
        self.link(&mut lines);
        if self.welds() {
            self.carried(&mut lines);
        }
        let inertias = if self.two() {
            ["MOTOR_INERTIA_KG_M2", "LOAD_INERTIA_KG_M2"]
        } else {
            ["INERTIA_KG_M2", ""]
        };
        let gives = y.iter().map(|name| {
            let side = if name.starts_with("load_") {
                &LOAD
            } else {
                &MOTOR
            };
            match *name {
                "angle" | "load_angle" => format!("mag({}) * {}", side.slip, side.speed),
                "speed" | "load_speed" => {
                    let inertia = inertias[usize::from(*name == "load_speed")];
                    let net = self.net_with_link(side);
                    let alone = format!("({net} - {} - {}) / {inertia}", side.viscous, side.rubs);
                    if self.welds() {
                        format!(
                            "mag({}) * pick((joined > 0.0), together, {alone})",
                            side.slip
                        )
                    } else {
                        format!("mag({}) * {alone}", side.slip)
                    }
                }
                "current" => {
                    let drop = if self.drops {
                        " - pick((way < 0.0), DROP_BACK_V, DROP_FORWARD_V) * way"
                    } else {
                        ""
                    };
                    let rate = format!("(excess{drop} - resistance * current) / INDUCTANCE_H");
                    if self.halts() {
                        format!("flows * {rate}")
                    } else {
                        rate
                    }
                }
                "loss" => "(flowing * flowing * RESISTANCE_OHM - loss) / HEATING_TIME_CONSTANT_S"
                    .to_owned(),
                name => format!("0.0 * {name}"),
            }
        });
        Function {
            name: "rates",
            comment: "rate of change of the state",
            parameters: &["y", "m"],
            gives: gives.collect(),
            lines,
        }
    }
}
