//! The plant compared with closed forms, and the random processes with their distributions.

use std::f64::consts::TAU;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::motor::Motor;
use crate::plant::Plant;
use crate::random_torque::{OrnsteinUhlenbeck, RandomTorque};
use crate::true_motor::{Contact, Coupling, TrueMotor};
use crate::unmodelled::Unmodelled;
use crate::{CATALOGUE, Kind, Mix, OUTSIDE, generate, plan};

const NO_RANDOM_TORQUE: RandomTorque = RandomTorque {
    sigma: 0.0,
    time_s: 1.0,
};

/// A motor with almost no inductance and no dry friction.
fn first_order() -> Motor {
    Motor {
        inductance_h: 1e-7,
        coulomb_friction_nm: 0.0,
        ..Motor::HANDOUT
    }
}

fn at_rest(hidden: &TrueMotor) -> Plant<'_> {
    Plant::new(hidden, NO_RANDOM_TORQUE, 0.5, 1)
}

#[test]
fn a_step_without_friction_follows_the_first_order_solution() {
    let m = first_order();
    let hidden = TrueMotor::without_effects(m);
    let mut plant = at_rest(&hidden);
    let rate = (m.viscous_friction_nm_s_per_rad
        + m.torque_constant_nm_per_a * m.back_emf_v_s_per_rad / m.resistance_ohm)
        / m.inertia_kg_m2;
    let steady = m.torque_constant_nm_per_a * 4.5 / (m.resistance_ohm * m.inertia_kg_m2 * rate);
    for k in 1..=40 {
        let t = 0.01 * f64::from(k);
        plant.hold(4.5, t);
        let angle = steady * (t - (1.0 - (-rate * t).exp()) / rate);
        let off_counts = (plant.read_angle() - angle) / m.count_rad();
        assert!(off_counts.abs() < 0.01, "{off_counts} counts at {t} s");
    }
}

#[test]
fn the_steady_speed_is_that_of_the_torque_balance_with_friction() {
    let hidden = TrueMotor::without_effects(Motor::HANDOUT);
    let mut plant = at_rest(&hidden);
    for volts in [4.5, 1.0, -3.0] {
        plant.hold(volts, plant.now() + 1.5);
        let drive = 0.07 * f64::abs(volts) - 0.02;
        let expected = (drive / 0.059).copysign(volts);
        assert!((plant.speed() - expected).abs() < 1e-4 * expected.abs());
    }
}

#[test]
fn the_shaft_sticks_below_the_breakaway_voltage_and_moves_above() {
    let hidden = TrueMotor::without_effects(Motor::HANDOUT);
    let breakaway_v = 0.02 * 10.0 / 0.7;
    let mut held = at_rest(&hidden);
    held.hold(0.98 * breakaway_v, 5.0);
    assert!(held.read_angle().abs() < 0.1 * hidden.motor.count_rad());
    let mut freed = at_rest(&hidden);
    freed.hold(1.02 * breakaway_v, 5.0);
    assert!(freed.read_angle() > 2.0 * hidden.motor.count_rad());
}

#[test]
fn two_inertias_on_a_spring_oscillate_at_their_natural_frequency() {
    let mut motor = first_order();
    motor.viscous_friction_nm_s_per_rad = 0.0;
    motor.torque_constant_nm_per_a = 0.0;
    let mut hidden = TrueMotor::without_effects(motor);
    hidden.coupling = Some(Coupling {
        load_fraction: 0.3,
        load_friction_share: 0.3,
        encoder_on_load: true,
        contact: Contact::Spring {
            frequency_hz: 12.0,
            damping_ratio: 0.0,
        },
    });
    let mut plant = at_rest(&hidden);
    plant.kick(0.2);
    let mut crossings = Vec::new();
    let mut before = 0.0;
    for k in 1..=10_000 {
        let t = 1e-4 * f64::from(k);
        plant.hold(0.0, t);
        let twist = plant.twist();
        if before < 0.0 && twist >= 0.0 {
            crossings.push(t - 1e-4 * twist / (twist - before));
        }
        before = twist;
    }
    let periods = (crossings.len() - 1) as f64;
    let frequency = periods / (crossings[crossings.len() - 1] - crossings[0]);
    assert!((frequency - 12.0).abs() < 0.02, "{frequency} Hz");
}

#[test]
fn the_motor_leads_the_load_by_half_the_backlash() {
    let mut hidden = TrueMotor::without_effects(Motor::HANDOUT);
    let gap_rad = 0.05;
    hidden.coupling = Some(Coupling {
        load_fraction: 0.4,
        load_friction_share: 0.4,
        encoder_on_load: false,
        contact: Contact::Flanks { gap_rad },
    });
    let mut plant = at_rest(&hidden);
    for volts in [3.0, -3.0] {
        plant.hold(volts, plant.now() + 1.0);
        let lead = plant.twist() * volts.signum();
        // The flank itself deflects by a hundredth of a count under friction.
        assert!((lead - 0.5 * gap_rad).abs() < 0.02 * hidden.motor.count_rad());
    }
}

/// Forward both bodies respond together; backward the motor alone does, while the load keeps turning.
#[test]
fn a_one_way_clutch_carries_the_load_forward_only() {
    let m = first_order();
    let mut hidden = TrueMotor::without_effects(m);
    hidden.coupling = Some(Coupling {
        load_fraction: 0.6,
        load_friction_share: 0.0,
        encoder_on_load: false,
        contact: Contact::OneWay,
    });
    let damping = m.viscous_friction_nm_s_per_rad
        + m.torque_constant_nm_per_a * m.back_emf_v_s_per_rad / m.resistance_ohm;
    let end = m.torque_constant_nm_per_a * 4.5 / (m.resistance_ohm * damping);
    for (volts, share) in [(4.5, 1.0), (-4.5, 0.4)] {
        let mut plant = at_rest(&hidden);
        let time_constant_s = share * m.inertia_kg_m2 / damping;
        for k in 1..=20 {
            let t = 0.01 * f64::from(k);
            plant.hold(volts, t);
            let gone = t - time_constant_s * (1.0 - (-t / time_constant_s).exp());
            let off_counts = (plant.read_angle() - end * gone * volts.signum()) / m.count_rad();
            // The rollers deflect by some hundredths of a count while they drive.
            assert!(
                off_counts.abs() < 0.1,
                "{volts} V, {t} s: {off_counts} counts"
            );
        }
        // The motor brakes, and the load overruns.
        let twist = plant.twist();
        plant.hold(0.0, plant.now() + 0.3);
        assert!(volts < 0.0 || plant.twist() < twist - 0.5);
    }
}

/// A contact that is always open leaves no current and no torque.
#[test]
fn an_open_contact_leaves_no_torque() {
    let mut hidden = TrueMotor::without_effects(first_order());
    hidden.unmodelled = Some(Unmodelled::ThermalCutout {
        limit_w: 1e-9,
        time_constant_s: 1e3,
    });
    let mut plant = at_rest(&hidden);
    plant.hold(4.5, 0.01);
    let speed = plant.speed();
    // Open from the second update, 0.2 ms after the start, and damped by its bearing alone: 0.2 s is the time
    // constant.
    plant.hold(4.5, 0.11);
    let expected = speed * (-0.5_f64).exp();
    assert!(speed > 0.0 && (plant.speed() - expected).abs() < 1e-3 * expected);
}

#[test]
fn an_encoder_loses_the_configured_share_of_edges() {
    let mut hidden = TrueMotor::without_effects(Motor::HANDOUT);
    hidden.miss_probability = 0.03;
    let mut plant = at_rest(&hidden);
    plant.hold(4.5, 20.0);
    let passed = plant.read_angle() / hidden.motor.count_rad();
    let lost = passed - plant.counts() as f64;
    let sigma = (passed * 0.03 * 0.97).sqrt();
    assert!((lost - 0.03 * passed).abs() < 4.0 * sigma);
}

#[test]
fn the_random_torque_has_its_variance_and_correlation_time() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut random_torque = OrnsteinUhlenbeck::new(2.0, 0.5, &mut rng);
    // Half a correlation time per step: neighbours correlate by exp(-1/2).
    let values: Vec<f64> = (0..40_000)
        .map(|_| random_torque.step(0.25, &mut rng))
        .collect();
    let variance = values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
    let neighbours = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / values.len() as f64;
    // Four standard errors of the estimates.
    assert!((variance - 4.0).abs() < 0.2, "{variance}");
    assert!((neighbours / variance - (-0.5_f64).exp()).abs() < 0.03);
}

#[test]
fn nominal_figures_are_off_by_five_percent() {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let mut squares = 0.0;
    for _ in 0..500 {
        let mut draw_nominal = Motor::HANDOUT.draw_nominal(&mut rng);
        let mut truth = Motor::HANDOUT;
        for (b, t) in draw_nominal
            .figures_mut()
            .into_iter()
            .zip(truth.figures_mut())
        {
            squares += (*b / *t - 1.0).powi(2);
        }
    }
    // Chi-square of 3500: standard error of the sigma 1.2 %, four of them.
    let sigma = (squares / 3500.0).sqrt();
    assert!((sigma / 0.05 - 1.0).abs() < 0.05, "{sigma}");
}

#[test]
fn a_case_is_reproduced_from_its_seed_and_keeps_the_least_strength() {
    let kind = Kind::Pair("stribeck", "voltage_drop");
    let case = generate(11, &kind);
    assert_eq!(case, generate(11, &kind));
    assert_ne!(case.runs, generate(12, &kind).runs);
    assert_eq!(case.label.effects.len(), 2);
    for (id, strength) in &case.label.strength_counts {
        assert!(*strength >= 2.0, "{id}: {strength} counts");
    }
    let lengths: Vec<usize> = case.runs.iter().map(|r| r.counts.len()).collect();
    assert_eq!(lengths, [133, 1333, 5000]);
}

#[test]
fn an_effect_without_a_magnitude_is_given_a_motor_on_which_it_shows() {
    for seed in 0..12 {
        let case = generate(seed, &Kind::Single("coast_at_zero"));
        let strength = case.label.strength_counts["coast_at_zero"];
        assert!(strength >= 2.0, "seed {seed}: {strength} counts");
    }
}

#[test]
fn without_effect_and_random_torque_the_held_out_residual_is_the_quantization() {
    let case = generate(4, &Kind::None);
    let floor = case.label.unseen_floor_counts;
    let quantisation = 1.0 / 12.0_f64.sqrt();
    assert!(
        floor > 0.8 * quantisation && floor < 20.0 * quantisation,
        "{floor}"
    );
}

#[test]
fn a_mixed_plan_holds_every_effect_about_as_often() {
    let cases = plan(300, 9, Mix::Mixed);
    assert_eq!(cases.len(), 300);
    assert_eq!(cases, plan(300, 9, Mix::Mixed));
    for id in CATALOGUE {
        let n = cases.iter().filter(|(_, k)| *k == Kind::Single(id)).count();
        assert_eq!(n, 6, "{id}");
    }
    for id in OUTSIDE {
        let n = cases
            .iter()
            .filter(|(_, k)| *k == Kind::Outside(id))
            .count();
        assert!(n == 3 || n == 4, "{id}: {n}");
    }
    let none = cases.iter().filter(|(_, k)| *k == Kind::None).count();
    assert_eq!(none, 30);
}

#[test]
fn every_effect_outside_the_catalogue_shows() {
    for id in OUTSIDE {
        let case = generate(21, &Kind::Outside(id));
        assert_eq!(case.label.effects[0].id, id);
        assert!(case.label.strength_counts[id] > 2.0, "{id}");
    }
}

#[test]
fn a_kind_is_parsed_from_its_name() {
    for name in ["none", "backlash", "belt_jump", "cogging+inertia"] {
        assert_eq!(
            name.parse::<Kind>().map(|k| k.to_string()),
            Ok(name.to_owned())
        );
    }
    for name in [
        "",
        "wobble",
        "cogging+cogging",
        "backlash+compliance",
        "cogging+belt_jump",
    ] {
        assert!(name.parse::<Kind>().is_err(), "{name}");
    }
    assert!((TAU / 720.0 - Motor::HANDOUT.count_rad()).abs() < 1e-15);
}
