//! Load and friction torques from position and speed of a body.

use crate::body::Body;
use crate::true_motor::TrueMotor;
use crate::unmodelled::Disturbance;

/// Torque of drag and gravity against positive rotation.
pub(crate) fn load_torque(x: &TrueMotor, body: &Body) -> f64 {
    x.drag * body.speed * body.speed.abs() + x.gravity.at(body.angle) + x.load_nm
}

/// Viscous coefficient in this direction.
pub(crate) fn viscous(x: &TrueMotor, speed: f64) -> f64 {
    x.motor.viscous_friction_nm_s_per_rad * (1.0 + x.viscous_asymmetry * speed.signum())
}

/// Static friction of both bodies together, for sliding friction `sliding_nm`.
pub(crate) fn holding_nm(x: &TrueMotor, sliding_nm: f64) -> f64 {
    sliding_nm + (x.static_nm - x.motor.coulomb_friction_nm).max(0.0)
}

/// Dry friction of steady sliding at this speed, of both bodies together.
pub(crate) fn sliding_nm(
    x: &TrueMotor,
    disturbance: &Disturbance,
    random_torque: f64,
    speed: f64,
    motor_torque: f64,
) -> f64 {
    let mut sliding = x.motor.coulomb_friction_nm * disturbance.friction_factor;
    if x.friction_asymmetry != 0.0 {
        // At rest the direction of the net torque decides.
        let way = if speed.abs() > 1e-4 {
            speed
        } else {
            motor_torque
        };
        sliding *= 1.0 + x.friction_asymmetry * way.signum();
    }
    if x.stribeck_nm > 0.0 {
        let ratio = speed / x.stribeck_speed_rad_s;
        sliding += x.stribeck_nm * (-ratio * ratio).exp();
    }
    let fraction = if motor_torque * speed >= 0.0 {
        x.driving_fraction
    } else {
        x.driven_fraction
    };
    (sliding + fraction * motor_torque.abs() + disturbance.extra_friction_nm + random_torque)
        .max(0.0)
}
