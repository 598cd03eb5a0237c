//! Order of convergence of modes that are not solved exactly: every step fixed at `H`, `H/2` .. `H/32`, compared with
//! `H/256`. The order is 4 for steps below the winding's time constant (0.4 ms), and 2 to 4 above it.

use crate::CommandKind;
use crate::catalogue::ids;
use crate::chain::Chain;
use crate::integrator::dynamics::Machine;
use crate::integrator::engine::{Engine, TICKS};
use crate::{ActiveEffect, Model, Motor};

/// Angle 0.3 s after a step of 4.5 V, with every step halved this many times.
fn angle_rad<const N: usize>(motor: &Motor, halvings: usize) -> f64 {
    let chain = Chain::new(
        &motor.parameters,
        &motor.effects,
        Model::SecondOrder,
        CommandKind::Voltage,
        |x| x,
    );
    let mut engine = Engine::<f64, N>::new(Machine::new(chain), 0.003);
    engine.hold_step(halvings);
    engine.command(4.5, 0.0);
    engine.advance(100 * TICKS);
    engine.y[0]
}

#[test]
fn curved_modes_converge_as_the_step_is_halved() {
    for (id, values) in [
        (ids::GRAVITY_LOAD, &[0.04, 0.6][..]),
        (ids::COGGING, &[0.03, 12.0, 1.1]),
        (ids::TORQUE_RIPPLE, &[0.12, 11.0, 0.7]),
        (ids::QUADRATIC_DRAG, &[0.002]),
        (ids::STRIBECK, &[0.03, 0.5]),
        (ids::PRESLIDING, &[0.035]),
        (ids::WINDING_HEATING, &[0.8, 5.0]),
    ] {
        let mut motor = Motor::default();
        motor.effects.set(ActiveEffect::new(id, values).unwrap());
        let angle = |halvings| match id {
            ids::WINDING_HEATING => angle_rad::<4>(&motor, halvings),
            _ => angle_rad::<3>(&motor, halvings),
        };
        let exact = angle(8);
        let errors: Vec<f64> = (0..6)
            .map(|halvings| (angle(halvings) - exact).abs())
            .collect();
        for (k, halved) in errors.windows(2).enumerate() {
            assert!(halved[1] < halved[0], "{id}, halving {k}: {halved:?} rad");
        }
        // Five halvings: 4^5 = 1,024 at order 2, a million at order 4.
        assert!(errors[0] / errors[5] > 500.0, "{id}: {errors:?} rad");
        assert!(errors[0] < 1e-5, "{id}: {errors:?} rad");
    }
}
