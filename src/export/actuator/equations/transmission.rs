//! Torque between motor side and load side, and whether both move together.

use super::{Line, Side, Writer, set};
use crate::motor::catalogue::ids;

impl Writer<'_> {
    /// Torque from the motor side to the load side while they move relative to each other.
    pub(super) fn link(&self, lines: &mut Vec<Line>) {
        if self.clutch {
            lines.push(set("link", "SLIPPING_CLUTCH_TORQUE_NM * touch"));
        } else if self.spring && self.gap {
            lines.push(set(
                "link",
                format!("mag(touch) * ({})", self.push("touch")),
            ));
        } else if self.spring {
            lines.push(set("link", self.push("0.0")));
        } else if self.gap {
            lines.push(set("link", "0.0 * touch"));
        }
    }

    /// Spring torque on this flank.
    pub(super) fn push(&self, flank: &str) -> String {
        let twist = if self.gap {
            format!("(angle - load_angle - 0.5 * BACKLASH_GAP_RAD * {flank})")
        } else {
            "(angle - load_angle)".to_owned()
        };
        format!("SPRING_NM_PER_RAD * {twist} + DAMPER_NM_S_PER_RAD * (speed - load_speed)")
    }

    /// Acceleration of both sides together, and the torque then transmitted.
    pub(super) fn carried(&self, lines: &mut Vec<Line>) {
        lines.extend([
            set(
                "together",
                "(net + load_net - viscous - load_viscous - rubs - load_rubs) / INERTIA_KG_M2",
            ),
            set(
                "carried",
                "LOAD_INERTIA_KG_M2 * together + load_viscous + load_rubs - load_net",
            ),
        ]);
    }

    /// Lowest and highest torque that holds both sides at rest while they touch.
    pub(super) fn range(&self, lines: &mut Vec<Line>, touch: &str) {
        lines.extend([
            set("lowest", "high(net - up, -load_down - load_net)"),
            set("highest", "low(net + down, load_up - load_net)"),
        ]);
        if self.clutch {
            lines.extend([
                set("least", "-SLIPPING_CLUTCH_TORQUE_NM"),
                set("greatest", "SLIPPING_CLUTCH_TORQUE_NM"),
            ]);
        } else {
            lines.extend([
                set("least", format!("pick(({touch} > 0.0), 0.0, lowest)")),
                set("greatest", format!("pick(({touch} < 0.0), 0.0, highest)")),
            ]);
        }
    }

    pub(super) fn net_with_link(&self, side: &Side) -> String {
        match (self.two(), side.net) {
            (false, net) => net.to_owned(),
            (true, "net") => "(net - link)".to_owned(),
            (true, net) => format!("({net} + link)"),
        }
    }

    /// Whether both sides move together, and in which direction: rigid flanks, or a clutch.
    pub(super) fn joint(&self, lines: &mut Vec<Line>) {
        let rests = "(speed == 0.0) & (load_speed == 0.0)";
        let (held, meets) = if self.clutch {
            (format!("pick({rests}, 0.0, contact)"), "(held == 0.0)")
        } else {
            ("contact".to_owned(), "(held != 0.0)")
        };
        lines.push(set("held", held));
        self.range(lines, "held");
        // Together: their common direction from rest, and the torque transmitted in motion.
        let leaves = if self.preslides {
            "pick((net + load_net == friction + load_friction), sgn(excess), sgn(net + load_net - friction - load_friction))"
        } else {
            "pick((net + load_net > (up + load_up) * (1.0 - 1e-9)), 1.0, pick((net + load_net < -(down + load_down) * (1.0 - 1e-9)), -1.0, 0.0))"
        };
        lines.push(set(
            "both",
            format!("pick((speed == 0.0), {leaves}, sgn(speed))"),
        ));
        let as_one: Vec<String> = self
            .sides
            .iter()
            .map(|side| self.steady(side).replace(side.slip, "both"))
            .collect();
        let viscous = if self.has(ids::ASYMMETRIC_VISCOUS) {
            "VISCOUS_FRICTION_NM_S_PER_RAD * (1.0 + ASYMMETRIC_VISCOUS_RATIO * both)"
        } else {
            "VISCOUS_FRICTION_NM_S_PER_RAD"
        };
        let [rubs, load_rubs] = if self.preslides {
            ["friction".to_owned(), ids::LOAD_FRICTION.to_owned()]
        } else {
            [as_one[0].clone(), as_one[1].clone()]
        };
        lines.extend([
            set("rubs", rubs),
            set("load_rubs", load_rubs),
            set(
                "viscous",
                format!("{viscous} * MOTOR_FRICTION_SHARE * speed"),
            ),
            set(
                "load_viscous",
                format!("{viscous} * LOAD_FRICTION_SHARE * speed"),
            ),
        ]);
        self.carried(lines);
        let (parts, apart) = if self.clutch {
            ("(mag(carried) > SLIPPING_CLUTCH_TORQUE_NM)", "sgn(carried)")
        } else {
            ("(carried * held < 0.0)", "0.0")
        };
        // At rest a flank cannot pull, nor a clutch exceed its capacity: a side that needed either moves alone.
        let alone = if self.preslides {
            "0.0 * speed".to_owned()
        } else {
            "pick((speed == 0.0) & (high(lowest, least) > low(highest, greatest)) & ((least > lowest) | (greatest < highest)), 1.0, 0.0)".to_owned()
        };
        let alone_touch = if self.clutch {
            "pick((greatest < highest), 1.0, -1.0)"
        } else {
            "0.0"
        };
        let moves = if self.clutch || self.preslides {
            "(both != 0.0)"
        } else {
            "(speed != 0.0)"
        };
        lines.extend([
            set("alone", alone),
            set("loses", format!("high(alone, pick({moves} & {parts}, 1.0, 0.0))")),
            set("joined", format!("pick({meets}, 1.0 - loses, 0.0)")),
            set(
                "touch",
                format!("pick({meets} & (loses > 0.0), pick((alone > 0.0), {alone_touch}, {apart}), held)"),
            ),
        ]);
        self.link(lines);
        for side in &self.sides {
            let net = self.net_with_link(side);
            lines.push(set(
                side.slip,
                format!("pick((joined > 0.0), both, {})", self.slip(side, &net)),
            ));
        }
    }
}
