//! Events that end a mode, and the state afterwards.

use super::{Function, LEAVING_RAD_S, LOAD, MOTOR, Side, Writer, set};
use crate::motor::catalogue::ids;

impl Writer<'_> {
    /// Event functions, which end a mode at 0, and their number.
    pub(super) fn guards(&self) -> (Function, usize) {
        let mut lines = vec![self.call_forces()];
        self.levels(&mut lines);
        self.friction(&mut lines);
        self.link(&mut lines);
        let side_guard = |side: &Side| {
            let net = self.net_with_link(side);
            if self.preslides {
                format!("pick(({0} == 0.0), 1.0, {1} * {0})", side.slip, side.speed)
            } else {
                let [up, down] = side.levels;
                format!(
                    "pick(({0} == 0.0), low({up} - {net}, {down} + {net}), {1} * {0})",
                    side.slip, side.speed
                )
            }
        };
        let mut gives = vec![side_guard(&MOTOR)];
        if self.two() {
            gives.push(side_guard(&LOAD));
        }
        if self.welds() {
            self.carried(&mut lines);
            self.range(&mut lines, "touch");
            let (parts, meets) = if self.clutch {
                (
                    "SLIPPING_CLUTCH_TORQUE_NM - mag(carried)",
                    "(speed - load_speed) * touch",
                )
            } else {
                (
                    "carried * touch",
                    "0.5 * BACKLASH_GAP_RAD - mag(angle - load_angle)",
                )
            };
            gives[0] = format!(
                "pick((joined > 0.0), pick((slip == 0.0), low(highest, greatest) - high(lowest, least), speed * slip), {})",
                gives[0]
            );
            gives[1] = format!("pick((joined > 0.0), 1.0, {})", gives[1]);
            gives.push(format!(
                "pick((joined > 0.0), pick((slip == 0.0), 1.0, {parts}), {meets})"
            ));
        } else if self.gap {
            gives.push(format!(
                "pick((touch != 0.0), touch * ({}), high(0.5 * BACKLASH_GAP_RAD - mag(angle - load_angle), -sgn(angle - load_angle) * ({})))",
                self.push("touch"),
                self.push("sgn(angle - load_angle)")
            ));
        }
        if self.inductive && self.drops {
            gives.push("pick((way == 0.0), 1.0, current * way)".to_owned());
        }
        if self.inductive && self.limited {
            gives
                .push("pick((flows == 0.0), 1.0, CURRENT_LIMIT_LIMIT_A - mag(current))".to_owned());
        }
        let guards = gives.len();
        let function = Function {
            name: "events",
            comment: "event functions, positive within the mode: a side stops or breaks away, flanks or a clutch engage or separate, the current reaches 0 or its limit",
            parameters: &["y", "m"],
            lines,
            gives,
        };
        (function, guards)
    }

    /// The state at the end of a step after event `k` of the mode (-1: none).
    pub(super) fn snap(&self, y: &[&'static str]) -> Function {
        let mut lines = vec![self.call_forces()];
        self.levels(&mut lines);
        self.friction(&mut lines);
        self.link(&mut lines);
        let meets = "(k == 2.0) & (joined == 0.0)";
        if self.welds() {
            self.carried(&mut lines);
            self.range(&mut lines, "touch");
            lines.extend([
                set(
                    "merged",
                    "(MOTOR_INERTIA_KG_M2 * speed + LOAD_INERTIA_KG_M2 * load_speed) / INERTIA_KG_M2",
                ),
                set("leaves", "pick((k == 0.0) & (joined > 0.0) & (slip == 0.0), 1.0, 0.0)"),
                // A flank that would have to pull, or a clutch beyond its capacity, releases.
                set("alone", "pick((least > lowest) | (greatest < highest), 1.0, 0.0)"),
                set(
                    "as_one",
                    format!("pick((slip != 0.0) | (alone > 0.0), 0.0, {LEAVING_RAD_S} * sgn(net + load_net))"),
                ),
            ]);
        }
        let current_guard = self.sides.len() + usize::from(self.touches());
        let gives = y.iter().map(|name| {
            let side = if name.starts_with("load_") { &LOAD } else { &MOTOR };
            match *name {
                "speed" | "load_speed" => {
                    let k = if *name == "speed" { 0.0 } else { 1.0 };
                    let net = self.net_with_link(side);
                    let alone = format!(
                        "pick((k == {k:?}), pick(({} != 0.0), 0.0, {LEAVING_RAD_S} * sgn({net})), {name})",
                        side.slip
                    );
                    if self.welds() {
                        format!("pick((k == 0.0) & (joined > 0.0), as_one, pick({meets}, merged, {alone}))")
                    } else {
                        alone
                    }
                }
                "load_angle" if self.gap && !self.spring => format!(
                    "pick({meets}, angle - 0.5 * BACKLASH_GAP_RAD * sgn(angle - load_angle), load_angle)"
                ),
                "contact" if self.clutch => format!(
                    "pick({meets}, 0.0, pick((k == 2.0) & (joined > 0.0), sgn(carried), \
                     pick((leaves * alone > 0.0), pick((greatest < highest), 1.0, -1.0), touch)))"
                ),
                "contact" => {
                    let held = if self.welds() { "pick((leaves * alone > 0.0), 0.0, touch)" } else { "touch" };
                    format!("pick((k == 2.0), pick((touch == 0.0), sgn(angle - load_angle), 0.0), {held})")
                }
                "current" => {
                    let mut current = "current".to_owned();
                    if self.limited {
                        current = format!("high(low({current}, CURRENT_LIMIT_LIMIT_A), -CURRENT_LIMIT_LIMIT_A)");
                        let k = current_guard + usize::from(self.drops);
                        current = format!("pick((k == {k}.0), sgn(current) * CURRENT_LIMIT_LIMIT_A, {current})");
                    }
                    if self.drops {
                        current = format!("pick((k == {current_guard}.0), 0.0, {current})");
                    }
                    if self.opens {
                        current = format!("pick((u == 0.0), 0.0, {current})");
                    }
                    current
                }
                "friction" | ids::LOAD_FRICTION => {
                    format!("pick(({} == 0.0), {}, {})", side.slip, side.from[1], side.rubs)
                }
                name => name.to_owned(),
            }
        });
        Function {
            name: "snap",
            comment: "the state at the end of a step, changed by event k (-1: none)",
            parameters: &["y", "m", "k"],
            gives: gives.collect(),
            lines,
        }
    }
}
