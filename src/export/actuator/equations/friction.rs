//! Friction: breakaway levels, steady sliding, presliding, directions of slip.

use super::{BREAKAWAY, Line, Side, Writer, set};
use crate::export::actuator::constants::{folded, of};
use crate::motor::catalogue::ids;

impl Writer<'_> {
    pub(super) fn share(&self, side: &Side) -> String {
        if self.two() {
            format!(" * {}", side.share)
        } else {
            String::new()
        }
    }

    /// Breakaway level of a side in direction `s`.
    pub(super) fn breakaway(&self, side: &Side, s: &str) -> String {
        let p = folded(self.motor);
        let holds =
            of(self.motor, ids::STATIC_FRICTION).is_some_and(|v| v[0] > p.coulomb_friction_nm);
        let mut level = if holds {
            "STATIC_FRICTION_TORQUE_NM"
        } else {
            "COULOMB_FRICTION_NM"
        }
        .to_owned();
        if self.has(ids::ASYMMETRIC_FRICTION) {
            level += &format!(" * (1.0 {s} ASYMMETRIC_FRICTION_RATIO)");
        }
        if self.has(ids::STRIBECK) {
            level += " + STRIBECK_EXTRA_TORQUE_NM";
        }
        if self.has(ids::LOAD_FRICTION) {
            level += &format!(
                " + high(LOAD_FRICTION_DRIVING_FRACTION, pick(({s}torque >= 0.0), LOAD_FRICTION_DRIVING_FRACTION, \
                 LOAD_FRICTION_DRIVEN_FRACTION)) * mag(torque)"
            );
        }
        format!("({level}){}", self.share(side))
    }

    /// Friction of a side in steady sliding, in the direction of `slip`.
    pub(super) fn steady(&self, side: &Side) -> String {
        let s = side.slip;
        let mut level = "COULOMB_FRICTION_NM".to_owned();
        if self.has(ids::ASYMMETRIC_FRICTION) {
            level += &format!(" * (1.0 + ASYMMETRIC_FRICTION_RATIO * {s})");
        }
        if self.has(ids::STRIBECK) {
            let ratio = format!("({} / STRIBECK_STRIBECK_SPEED_RAD_S)", side.speed);
            level += &format!(" + STRIBECK_EXTRA_TORQUE_NM * exp(-{ratio} * {ratio})");
        }
        if self.has(ids::LOAD_FRICTION) {
            level += &format!(
                " + pick(({s} * torque >= 0.0), LOAD_FRICTION_DRIVING_FRACTION, LOAD_FRICTION_DRIVEN_FRACTION) * mag(torque)"
            );
        }
        format!("({level}){} * {s}", self.share(side))
    }

    /// Dry and viscous friction of each side, from its direction of slip.
    pub(super) fn friction(&self, lines: &mut Vec<Line>) {
        for side in &self.sides {
            lines.push(set(side.steady, self.steady(side)));
            if self.preslides {
                let [angle, friction, steady] = side.from;
                let (now, s, share) = (side.steady, side.slip, self.share(side));
                let (x, decay, lag) = match side.angle {
                    "angle" => ("x", "decay", "lag"),
                    _ => ("load_x", "load_decay", "load_lag"),
                };
                let mean = format!("(0.5 * ({now} + {steady}))");
                let moved = format!(
                    "({} - {angle}) * {s} / PRESLIDING_BREAK_IN_ANGLE_RAD",
                    side.angle
                );
                let dry = format!("COULOMB_FRICTION_NM{share} * {s}");
                lines.extend([
                    set(x, format!("{moved} * pick(({mean} == 0.0) | ({dry} == 0.0), 1.0, {dry} / pick(({mean} == 0.0), 1.0, {mean}))")),
                    set(decay, format!("exp(-high({x}, 0.0))")),
                    set(lag, format!("pick(({x} < 1e-5), 1.0 - 0.5 * {x}, (1.0 - {decay}) / high({x}, 1e-5))")),
                    set(
                        side.rubs,
                        format!("{now} - ({steady} - {friction}) * {decay} - ({now} - {steady}) * {lag}"),
                    ),
                ]);
            } else {
                lines.push(set(side.rubs, side.steady));
            }
            let mut viscous = "VISCOUS_FRICTION_NM_S_PER_RAD".to_owned();
            if self.has(ids::ASYMMETRIC_VISCOUS) {
                viscous += &format!(" * (1.0 + ASYMMETRIC_VISCOUS_RATIO * {})", side.slip);
            }
            lines.push(set(
                side.viscous,
                format!("{viscous}{} * {}", self.share(side), side.speed),
            ));
        }
    }

    pub(super) fn levels(&self, lines: &mut Vec<Line>) {
        for side in &self.sides {
            lines.push(set(side.levels[0], self.breakaway(side, "+")));
            lines.push(set(side.levels[1], self.breakaway(side, "-")));
        }
    }

    /// Direction in which a side begins to slip; 0 if it sticks.
    pub(super) fn slip(&self, side: &Side, net: &str) -> String {
        let (speed, friction) = (side.speed, side.friction);
        let leaves = if self.preslides {
            format!("pick(({net} == {friction}), sgn(excess), sgn({net} - {friction}))")
        } else {
            let [up, down] = side.levels;
            format!(
                "pick(({net} > {up} * {BREAKAWAY}), 1.0, pick(({net} < -{down} * {BREAKAWAY}), -1.0, 0.0))"
            )
        };
        format!("pick(({speed} == 0.0), {leaves}, sgn({speed}))")
    }
}
