//! Effects that repeat with the angle: all orders at once, by regression on the recorded angle (a simulated angle loses phase after
//! some counts of error).

use crate::motor::catalogue::ids;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::candidates::{Candidate, Shape};
use crate::diagnose::fit::Fit;
use crate::diagnose::model::{Base, Member};
use crate::diagnose::score::fitted_time_constant_s;
use crate::diagnose::segments::{Segment, Segments};
use crate::motor::CommandKind;
use crate::motor::catalogue::{EffectKind, catalogue};

/// Values of an effect with these coefficients of sine and cosine, of which a coefficient of 1 is `per_unit` of its amplitude.
pub(super) fn with_wave(member: &Member, per_unit: f64, (sine, cosine): (f64, f64)) -> Member {
    let mut member = member.clone();
    let turned = if per_unit < 0.0 { PI } else { 0.0 };
    member.values[0] = sine.hypot(cosine) * per_unit.abs();
    let last = member.values.len() - 1;
    member.values[last] = (cosine.atan2(sine) + turned).rem_euclid(TAU);
    member
}

/// Orders of the angle that an effect may have.
fn orders(kind: &EffectKind) -> Vec<usize> {
    match kind.parameters.iter().find(|p| p.key == "cycles_per_rev") {
        Some(order) => (order.lo.ceil() as usize..=order.hi as usize).collect(),
        None => vec![1],
    }
}

/// Candidates of one effect that repeats with the angle, an order each.
pub(super) fn candidates(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
    index: usize,
) -> Vec<Candidate> {
    let kind = &catalogue()[index];
    let motor = fit.model.motor(&fit.x);
    let p = &motor.parameters;
    let tau_s = fitted_time_constant_s(fit);
    let per_rad = 1.0 / segments.runs[0].rad;
    let mut out = Vec::new();
    for order in orders(kind) {
        let wave = |shift: f64| -> Vec<f64> {
            let mut out = Vec::with_capacity(segments.len);
            for segment in &segments.segments {
                let run = &segments.runs[segment.run];
                let mean = |k: usize| run.mean_sine(k, order as f64, shift);
                match kind.id {
                    ids::ENCODER_ECCENTRICITY => {
                        let at = |k: usize| (order as f64 * run.angle(k) + shift).sin();
                        let first = at(segment.from);
                        out.extend((segment.from..segment.to).map(|k| at(k) - first));
                    }
                    ids::TORQUE_RIPPLE => {
                        let strength = |k: usize| match base.kind {
                            CommandKind::Voltage => {
                                let speed = 0.5 * (run.speed[k] + run.speed[k + 1]) * run.rad;
                                (run.command[k] - 2.0 * p.back_emf_v_s_per_rad * speed)
                                    * p.torque_constant_nm_per_a
                                    / p.resistance_ohm
                            }
                            CommandKind::Current => run.command[k] * p.torque_constant_nm_per_a,
                            CommandKind::Torque => run.command[k],
                        };
                        filter(
                            segments,
                            segment,
                            tau_s,
                            |k| mean(k) * strength(k),
                            &mut out,
                        );
                    }
                    _ => filter(segments, segment, tau_s, mean, &mut out),
                }
            }
            out
        };
        let per_unit = match kind.id {
            ids::ENCODER_ECCENTRICITY => 1.0 / per_rad,
            ids::GRAVITY_LOAD => -p.inertia_kg_m2 / per_rad,
            _ => p.inertia_kg_m2 / per_rad,
        };
        let mut values = vec![0.0; kind.parameters.len()];
        if kind.parameters.len() == 3 {
            values[1] = order as f64;
        }
        out.push(Candidate {
            member: Member { index, values },
            shape: Shape::Pair([wave(0.0), wave(FRAC_PI_2)], per_unit),
        });
    }
    out
}

/// Angle in counts that an acceleration in counts/s^2, the mean between a sample and the next, makes in a segment:
/// `v' = -v/tau + a`, where the shaft moves.
fn filter(
    segments: &Segments,
    segment: &Segment,
    time_constant_s: f64,
    acceleration: impl Fn(usize) -> f64,
    out: &mut Vec<f64>,
) {
    let run = &segments.runs[segment.run];
    let (mut x, mut v) = (0.0, 0.0);
    out.push(0.0);
    for k in segment.from + 1..segment.to {
        let dt = run.t_s[k] - run.t_s[k - 1];
        if run.moving[k] {
            let e = (-dt / time_constant_s).exp();
            let a = acceleration(k - 1);
            let f01 = (1.0 - e) * time_constant_s;
            x += f01 * v + (dt - f01) * time_constant_s * a;
            v = e * v + f01 * a;
        } else {
            v = 0.0;
        }
        out.push(x);
    }
}
