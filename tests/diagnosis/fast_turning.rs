//! Effects that repeat with the angle in recordings whose shaft turns by half a turn and more per sample.

use motorlab::diagnose::{Options, diagnose};
use motorlab::motor::Motor;

use crate::recorded::{LEVELS, recorded, with};

/// A small motor without a gear, in SI: 64 counts per revolution, some 350 rad/s at 4.5 V.
fn small(motor: Motor) -> Motor {
    let mut motor = motor;
    let p = &mut motor.parameters;
    p.resistance_ohm = 1.9;
    p.back_emf_v_s_per_rad = 0.012;
    p.torque_constant_nm_per_a = 0.012;
    p.viscous_friction_nm_s_per_rad = 2e-6;
    p.inductance_h = 6e-4;
    p.inertia_kg_m2 = 2.4e-6;
    p.coulomb_friction_nm = 0.0035;
    p.counts_per_rev = 64.0;
    motor
}

/// Slow parts of the recording show the load; in fast turning it cancels over each sample.
#[test]
fn gravity_load_is_identified_where_the_shaft_turns_half_a_turn_per_sample() {
    let truth = small(with(&[("gravity_load", &[0.0026, 0.35])]));
    let run = recorded(&truth, &LEVELS, 0.01, 10.0);
    let half_turn = run.counts_per_rev as i64 / 2;
    let mut steps = (run.counts.windows(2)).map(|pair| (pair[1] - pair[0]).abs());
    assert!(steps.any(|step| step > half_turn), "the shaft turns slowly");
    let found = diagnose(&[run], &small(Motor::default()), &Options::default()).expect("runs");
    assert_eq!(found.effects, ["gravity_load"], "{}", found.sentence);
}
