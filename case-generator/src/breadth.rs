//! The breadth set: several families of motors, plain protocols, sample times from 1 to 30 ms.
//!
//! A single step is the most common recording. Magnitudes of effects are those of [`Effect`], scaled to the motor's
//! supply and speed.

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::case::{Case, Label};
use crate::effect::{CATALOGUE, Effect};
use crate::kind::can_pair;
use crate::motor::{Motor, four_digits, normal};
use crate::profile::{Profile, millivolts};
use crate::random_torque::RandomTorque;
use crate::record::{Conditions, record};
use crate::strength::{beyond_refit, counts_without_noise, rms};
use crate::true_motor::TrueMotor;
use crate::unmodelled::OUTSIDE;

/// Families of motors.
pub const FAMILIES: [&str; 4] = ["lab", "hobby", "fast", "servo"];
/// Command protocols.
pub const PROTOCOLS: [&str; 7] = [
    "step",
    "two_levels",
    "staircase",
    "reversing",
    "triangle",
    "chirp",
    "random",
];

/// Description of a case of the breadth set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bench {
    /// One of [`FAMILIES`].
    pub family: &'static str,
    /// One of [`PROTOCOLS`].
    pub protocol: &'static str,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Relative standard deviation of every value of the motor file.
    pub tolerance: f64,
    /// Whether the motor file states it.
    pub is_stated: bool,
    /// Whether there is a small random load.
    pub has_random_torque: bool,
    /// Ids of the hidden effects.
    pub ids: Vec<&'static str>,
}

/// A case with its bench.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchCase {
    /// The case.
    pub case: Case,
    /// Its parameters as drawn.
    pub bench: Bench,
    /// The motor file, with the tolerance if it is stated.
    pub motor_file: String,
}

/// Hidden effects of a case of the breadth set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HiddenEffects {
    /// Nothing.
    Nothing,
    /// This many effects of the catalogue.
    Effects(usize),
    /// An effect outside the catalogue.
    Outside,
}

/// A plan of cases: a quarter without effects, a third with one, a sixth with two, a twentieth with three, a tenth
/// outside the catalogue, and a tenth with one effect on the plainest protocol, which may not separate it from
/// others.
pub fn plan_breadth(cases: usize, seed: u64) -> Vec<(u64, HiddenEffects, Option<&'static str>)> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed ^ 0x6272_6561_6474_6800);
    let mut plan: Vec<(u64, HiddenEffects, Option<&'static str>)> = (0..cases)
        .map(|k| {
            let hides = match k * 60 / cases.max(1) {
                0..15 => (HiddenEffects::Nothing, None),
                15..35 => (HiddenEffects::Effects(1), None),
                35..45 => (HiddenEffects::Effects(2), None),
                45..48 => (HiddenEffects::Effects(3), None),
                48..54 => (HiddenEffects::Outside, None),
                _ => (HiddenEffects::Effects(1), Some("step")),
            };
            (rng.random::<u64>(), hides.0, hides.1)
        })
        .collect();
    for last in (1..plan.len()).rev() {
        plan.swap(last, rng.random_range(0..=last));
    }
    plan
}

/// The case of one entry of a plan.
pub fn generate_bench(
    seed: u64,
    hides: HiddenEffects,
    protocol: Option<&'static str>,
) -> BenchCase {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    const TRIES: usize = 40;
    let mut best: Option<(f64, BenchCase)> = None;
    for _ in 0..TRIES {
        let (margin, case) = draw(&mut rng, hides, protocol);
        if margin >= 1.0 {
            return case;
        }
        if best.as_ref().is_none_or(|b| margin > b.0) {
            best = Some((margin, case));
        }
    }
    best.expect("a case was drawn").1
}

fn pick<T: Copy>(rng: &mut impl Rng, from: &[T]) -> T {
    from[rng.random_range(0..from.len())]
}

fn log_uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    rng.random_range(low.ln()..high.ln()).exp()
}

/// A motor of a family, from supply, no-load speed, resistance, time constant and shares of friction.
fn motor_of(family: &str, rng: &mut impl Rng) -> Motor {
    let (supplies, speed, counts): (&[f64], (f64, f64), &[f64]) = match family {
        "hobby" => (
            &[6.0, 12.0, 24.0],
            (8.0, 40.0),
            &[360.0, 700.0, 1200.0, 2400.0, 3600.0],
        ),
        "fast" => (
            &[6.0, 12.0],
            (300.0, 1200.0),
            &[12.0, 24.0, 28.0, 48.0, 64.0],
        ),
        "servo" => (&[7.4, 12.0], (4.0, 9.0), &[4096.0, 8192.0]),
        _ => return Motor::draw(rng, false),
    };
    let supply_v = pick(rng, supplies);
    let dry = log_uniform(rng, 0.02, 0.12);
    let wet = log_uniform(rng, 0.01, 0.15);
    let top = log_uniform(rng, speed.0, speed.1);
    let resistance_ohm = log_uniform(rng, 1.0, 12.0);
    let kb = supply_v * (1.0 - dry) / top / (1.0 + wet);
    let kt = kb * rng.random_range(0.92..1.0);
    let coupling = kt * kb / resistance_ohm;
    let viscous = wet * coupling;
    let time_constant_s = log_uniform(rng, 0.015, 0.12);
    Motor {
        resistance_ohm,
        back_emf_v_s_per_rad: kb,
        torque_constant_nm_per_a: kt,
        viscous_friction_nm_s_per_rad: viscous,
        inductance_h: resistance_ohm * log_uniform(rng, 1e-4, 8e-4),
        inertia_kg_m2: time_constant_s * (coupling + viscous),
        coulomb_friction_nm: dry * kt * supply_v / resistance_ohm,
        counts_per_rev: pick(rng, counts),
        supply_v,
    }
}

/// An effect's magnitudes on this motor's scales, if they are drawn for the lab motor's.
fn scaled(mut effect: Effect, motor: &Motor) -> Effect {
    let volts = motor.supply_v / Motor::HANDOUT.supply_v;
    let speed = motor.top_speed_rad_s() / Motor::HANDOUT.top_speed_rad_s();
    for (key, value) in &mut effect.parameters {
        match key.as_str() {
            "threshold_v" | "drop_v" => *value = four_digits(*value * volts),
            "stribeck_speed_rad_s" => *value = four_digits(*value * speed),
            _ => {}
        }
    }
    effect
}

fn profile_of(protocol: &'static str, motor: &Motor, ts: f64, rng: &mut impl Rng) -> Profile {
    let supply = motor.supply_v;
    let rest = |n: f64| (n / ts).round() as usize;
    let mut u: Vec<f64> = Vec::new();
    let hold = |u: &mut Vec<f64>, level: f64, for_s: f64| {
        u.extend(std::iter::repeat_n(millivolts(level), rest(for_s).max(1)));
    };
    let name = match protocol {
        "step" => {
            let level = supply * pick(rng, &[1.0, 1.0, 0.8, 0.6]);
            hold(&mut u, 0.0, pick(rng, &[0.1, 0.3, 0.5]));
            hold(&mut u, level, rng.random_range(2.0..6.0));
            "step"
        }
        "two_levels" => {
            hold(&mut u, 0.0, 0.3);
            hold(&mut u, supply * rng.random_range(0.3..0.6), 2.0);
            hold(&mut u, supply * rng.random_range(0.7..1.0), 2.0);
            hold(&mut u, 0.0, 1.0);
            "two_levels"
        }
        "staircase" => {
            hold(&mut u, 0.0, 0.3);
            for k in 1..=8 {
                hold(&mut u, supply * f64::from(k) / 8.0, 0.8);
            }
            "staircase"
        }
        "reversing" => {
            let level = supply * rng.random_range(0.6..1.0);
            hold(&mut u, 0.0, 0.3);
            for k in 0..8 {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                hold(&mut u, sign * level * [1.0, 0.6][k / 2 % 2], 0.9);
            }
            "reversing"
        }
        "triangle" => {
            let n = rest(rng.random_range(6.0..12.0));
            for k in 0..n {
                let phase = 4.0 * k as f64 / n as f64;
                let level = if phase < 1.0 {
                    phase
                } else if phase < 3.0 {
                    2.0 - phase
                } else {
                    phase - 4.0
                };
                u.push(millivolts(supply * level));
            }
            "triangle"
        }
        "chirp" => {
            let (lasts_s, f0, f1) = (8.0, 0.3_f64, 6.0_f64);
            let n = rest(lasts_s);
            for k in 0..n {
                let t = k as f64 * ts;
                let phase = std::f64::consts::TAU * (f0 * t + 0.5 * (f1 - f0) / lasts_s * t * t);
                u.push(millivolts(0.9 * supply * phase.sin()));
            }
            "chirp"
        }
        _ => {
            let breakaway =
                motor.coulomb_friction_nm * motor.resistance_ohm / motor.torque_constant_nm_per_a;
            let lasts_s = rng.random_range(8.0..15.0);
            return Profile::multi_level(ts, lasts_s, supply, breakaway, rng);
        }
    };
    Profile {
        name,
        sample_time_s: ts,
        command_v: u,
    }
}

fn draw(
    rng: &mut Pcg64Mcg,
    hides: HiddenEffects,
    protocol: Option<&'static str>,
) -> (f64, BenchCase) {
    let family = pick(rng, &FAMILIES);
    let motor = motor_of(family, rng);
    let tolerance = pick(rng, &[0.02, 0.05, 0.15]);
    let is_stated = tolerance == 0.05 || rng.random_bool(0.5);
    let mut nominal = motor;
    for figure in nominal.figures_mut() {
        let factor: f64 = (tolerance * normal(rng)).exp();
        *figure = four_digits(*figure * factor);
    }
    let protocol = protocol.unwrap_or_else(|| pick(rng, &PROTOCOLS));
    let ts = pick(rng, &[0.001, 0.002, 0.003, 0.005, 0.01, 0.02, 0.03]);
    let count = if protocol == "step" {
        1
    } else {
        rng.random_range(1..=3)
    };
    let mut profiles: Vec<Profile> = (0..count)
        .map(|_| profile_of(protocol, &motor, ts, rng))
        .collect();
    profiles.push(profile_of("random", &motor, ts.max(0.002), rng));
    let has_random_torque = rng.random_bool(0.5);
    // Drawn relative to dry friction, stated relative to the stall torque.
    let stall = motor.torque_constant_nm_per_a * motor.supply_v / motor.resistance_ohm;
    let random_torque = RandomTorque {
        sigma: if has_random_torque {
            rng.random_range(0.003..0.01) * stall / motor.coulomb_friction_nm
        } else {
            0.0
        },
        time_s: log_uniform(rng, 0.1, 2.0),
    };
    let ids: Vec<&'static str> = match hides {
        HiddenEffects::Nothing => vec![],
        HiddenEffects::Outside => vec![pick(rng, &OUTSIDE)],
        HiddenEffects::Effects(count) => {
            let mut ids: Vec<&'static str> = Vec::new();
            while ids.len() < count {
                let id = pick(rng, &CATALOGUE);
                if ids.iter().all(|other| can_pair(other, id)) {
                    ids.push(id);
                }
            }
            ids
        }
    };
    let noise_seed = rng.random::<u64>();
    let plain = TrueMotor::without_effects(motor);
    let effects: Vec<Effect> = (ids.iter())
        .map(|id| scaled(Effect::draw(id, &motor, rng), &motor))
        .collect();
    let with = |effects: &[&Effect]| {
        let mut hidden = plain.clone();
        for effect in effects {
            effect.apply(&mut hidden);
        }
        hidden
    };
    let hidden = with(&effects.iter().collect::<Vec<_>>());
    let judged = &profiles[..count];
    let counts = counts_without_noise(&hidden, judged, noise_seed);
    let without = counts_without_noise(&plain, judged, noise_seed);
    let mut strengths = std::collections::BTreeMap::new();
    let mut margin = f64::INFINITY;
    for effect in &effects {
        let others: Vec<&Effect> = effects.iter().filter(|e| e.id != effect.id).collect();
        let strength = rms(
            &counts,
            &counts_without_noise(&with(&others), judged, noise_seed),
        );
        let least = if effect.id == "sample_jitter" {
            0.4
        } else {
            2.0
        };
        margin = margin.min(strength / least);
        strengths.insert(effect.id.clone(), strength);
    }
    let beyond = if ids.is_empty() {
        0.0
    } else {
        beyond_refit(&plain, judged, noise_seed, &counts, &without)
    };
    let mut runs = Vec::new();
    for (k, profile) in profiles.iter().enumerate() {
        let conditions = Conditions {
            random_torque,
            seed: noise_seed.wrapping_add(k as u64),
        };
        runs.push(record(&hidden, profile, motor.counts_per_rev, conditions).run);
    }
    let unseen_run = runs.pop().expect("the last is kept");
    let motor_file = nominal.to_toml_within(is_stated.then_some(tolerance));
    let kind = match (hides, ids.len()) {
        (HiddenEffects::Nothing, _) => "none",
        (HiddenEffects::Outside, _) => "outside",
        (_, 1) => "single",
        (_, 2) => "pair",
        _ => "triple",
    };
    let case = Case {
        runs,
        unseen_run,
        nominal,
        label: Label {
            kind: kind.to_owned(),
            effects,
            strength_counts: strengths,
            beyond_refit_counts: beyond,
            unseen_floor_counts: 0.0,
            motor,
            random_torque_relative: random_torque.sigma,
            random_torque_time_s: random_torque.time_s,
        },
    };
    let bench = Bench {
        family,
        protocol,
        sample_time_s: ts,
        tolerance,
        is_stated,
        has_random_torque,
        ids,
    };
    (
        margin,
        BenchCase {
            case,
            bench,
            motor_file,
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_has_its_shares_and_is_the_same_again() {
        let plan = plan_breadth(600, 3);
        let count = |hides: HiddenEffects| plan.iter().filter(|case| case.1 == hides).count();
        assert_eq!(count(HiddenEffects::Nothing), 150);
        assert_eq!(count(HiddenEffects::Effects(1)), 260);
        assert_eq!(count(HiddenEffects::Effects(2)), 100);
        assert_eq!(count(HiddenEffects::Effects(3)), 30);
        assert_eq!(count(HiddenEffects::Outside), 60);
        assert_eq!(plan, plan_breadth(600, 3));
        assert_ne!(plan, plan_breadth(600, 4));
    }

    #[test]
    fn a_bench_has_its_stated_motor_and_effects() {
        for seed in 0..12 {
            let bench = generate_bench(seed, HiddenEffects::Effects(1), None);
            assert_eq!(bench, generate_bench(seed, HiddenEffects::Effects(1), None));
            let label = &bench.case.label;
            let ids: Vec<&str> = label
                .effects
                .iter()
                .map(|effect| effect.id.as_str())
                .collect();
            assert_eq!(ids, bench.bench.ids);
            assert!(
                FAMILIES.contains(&bench.bench.family) && PROTOCOLS.contains(&bench.bench.protocol)
            );
            assert_eq!(
                bench.motor_file.contains("[tolerance]"),
                bench.bench.is_stated
            );
            assert_eq!(
                label.random_load_share() > 0.0,
                bench.bench.has_random_torque
            );
            for run in &bench.case.runs {
                assert_eq!(run.profile.sample_time_s, bench.bench.sample_time_s);
                assert!(
                    run.profile
                        .command_v
                        .iter()
                        .all(|u| u.abs() <= label.motor.supply_v + 1e-3)
                );
                let moved = run.counts.iter().any(|n| n.abs() > 10);
                assert!(moved, "{:?}", bench.bench);
            }
            // A nominal value that is off by the tolerance: neither exact nor by five sigma.
            let (kb, draw_nominal) = (
                label.motor.back_emf_v_s_per_rad,
                bench.case.nominal.back_emf_v_s_per_rad,
            );
            let off = (draw_nominal / kb).ln().abs();
            assert!(off > 0.0 && off < 5.0 * bench.bench.tolerance, "{off}");
        }
    }

    #[test]
    fn a_perfect_motor_without_random_torque_repeats() {
        let bench = generate_bench(5, HiddenEffects::Nothing, Some("step"));
        assert!(bench.bench.ids.is_empty() && bench.case.runs.len() == 1);
        assert_eq!(bench.case.label.beyond_refit_counts, 0.0);
    }
}
