//! Part 1: the five curves of the handout's script, and the difference between first and second order.

use serde::Serialize;

use super::transfer::TransferFunction;
use crate::compare::rms;
use crate::motor::{
    Drive, Effects, Model, Motor, Parameters, SimulationError, SimulationOptions, simulate,
};
use crate::recording::CommandKind;
use crate::units::{rad_per_count, rpm_from_rad_s};

/// End of the handout's simulation in s.
pub const END_S: f64 = 0.3;
/// Output period of the handout's simulation, in s.
pub const PRINT_S: f64 = 0.0001;
/// Share of the steady speed from which a difference is visible in a plot.
pub const VISIBLE: f64 = 0.05;

/// Terms of a curve's model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contents {
    /// Name of the column in CSV and JSON.
    pub id: &'static str,
    /// Name.
    pub name: &'static str,
    /// With or without the inductance.
    pub model: Model,
    /// With viscous friction.
    pub viscous: bool,
    /// With Coulomb friction.
    pub coulomb: bool,
}

/// The handout's five curves, in the order of its script.
pub const CURVES: [Contents; 5] = [
    contents(
        "first_order_viscous",
        "1st order, viscous friction",
        Model::FirstOrder,
        true,
        false,
    ),
    contents(
        "second_order_viscous",
        "2nd order, viscous friction",
        Model::SecondOrder,
        true,
        false,
    ),
    contents(
        "first_order_coulomb",
        "1st order, viscous and Coulomb friction",
        Model::FirstOrder,
        true,
        true,
    ),
    contents(
        "first_order_frictionless",
        "1st order, no friction",
        Model::FirstOrder,
        false,
        false,
    ),
    contents(
        "second_order_frictionless",
        "2nd order, no friction",
        Model::SecondOrder,
        false,
        false,
    ),
];

/// One curve.
pub const fn contents(
    id: &'static str,
    name: &'static str,
    model: Model,
    viscous: bool,
    coulomb: bool,
) -> Contents {
    Contents {
        id,
        name,
        model,
        viscous,
        coulomb,
    }
}

impl Contents {
    /// The motor with the terms of this model, and no effect beyond it.
    pub fn motor(&self, parameters: &Parameters) -> Motor {
        Motor {
            parameters: self.parameters(parameters),
            effects: Effects::none(),
            ..Motor::default()
        }
    }

    /// The parameters with the terms that the model lacks set to 0.
    pub fn parameters(&self, parameters: &Parameters) -> Parameters {
        let mut p = *parameters;
        if !self.viscous {
            p.viscous_friction_nm_s_per_rad = 0.0;
        }
        if !self.coulomb {
            p.coulomb_friction_nm = 0.0;
        }
        if self.model == Model::FirstOrder {
            p.inductance_h = 0.0;
        }
        p
    }

    /// Steady speed in rad/s at a constant voltage; `None` if unlimited, 0 if friction holds the shaft.
    pub fn steady_speed_rad_s(&self, parameters: &Parameters, volts: f64) -> Option<f64> {
        let p = self.parameters(parameters);
        let drive_nm = p.torque_constant_nm_per_a * volts.abs() / p.resistance_ohm;
        let net_nm = (drive_nm - p.coulomb_friction_nm).max(0.0);
        let gain = TransferFunction::first_order(&p).steady_gain()?;
        Some(gain * p.resistance_ohm / p.torque_constant_nm_per_a * net_nm * volts.signum())
    }
}

/// A curve: the true speed after a step of the supply at t = 0 from rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Name of the column.
    pub id: &'static str,
    /// Name.
    pub name: &'static str,
    /// Transfer function; `None` with Coulomb friction, which is nonlinear.
    pub transfer_function: Option<TransferFunction>,
    /// Its poles in 1/s; with Coulomb friction those in motion.
    pub poles: Vec<super::transfer::Pole>,
    /// Time constants in s.
    pub time_constants_s: Vec<f64>,
    /// Steady speed in rad/s.
    pub steady_speed_rad_s: Option<f64>,
    /// Largest difference between simulation and closed form in rad/s.
    pub off_closed_form_rad_s: f64,
    /// Times in s.
    #[serde(skip)]
    pub t_s: Vec<f64>,
    /// Speeds in rad/s.
    pub speed_rad_s: Vec<f64>,
    /// Angles in rad.
    #[serde(skip)]
    pub angle_rad: Vec<f64>,
}

impl Curve {
    /// Simulates the step of the supply.
    ///
    /// # Errors
    /// The motor's states exceed the range of floating point.
    pub fn simulated(
        contents: &Contents,
        parameters: &Parameters,
    ) -> Result<Self, SimulationError> {
        let motor = contents.motor(parameters);
        let samples = (END_S / PRINT_S).round() as u32;
        let t_s: Vec<f64> = (0..=samples).map(|k| f64::from(k) * PRINT_S).collect();
        let p = motor.parameters;
        let command = vec![p.supply_v; t_s.len()];
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let options = SimulationOptions {
            model: contents.model,
            ..SimulationOptions::default()
        };
        let trajectory = simulate(&motor, &drive, &options)?;
        let function = match contents.model {
            Model::FirstOrder => TransferFunction::first_order(&p),
            Model::SecondOrder => TransferFunction::second_order(&p),
        };
        // In forward motion at first order, Coulomb friction acts as a voltage drop; no curve has it at second order.
        let holding_v = p.resistance_ohm * p.coulomb_friction_nm / p.torque_constant_nm_per_a;
        let volts = (p.supply_v - holding_v).max(0.0);
        let off = |(&t, &w): (&f64, &f64)| (w - function.step_speed(volts, t)).abs();
        let off_closed_form_rad_s = t_s
            .iter()
            .zip(&trajectory.speed_rad_s)
            .map(off)
            .fold(0.0, f64::max);
        Ok(Self {
            id: contents.id,
            name: contents.name,
            transfer_function: (!contents.coulomb).then_some(function),
            poles: function.poles(),
            time_constants_s: function.time_constants_s(),
            steady_speed_rad_s: contents.steady_speed_rad_s(parameters, p.supply_v),
            off_closed_form_rad_s,
            t_s,
            speed_rad_s: trajectory.speed_rad_s,
            angle_rad: trajectory.angle_rad,
        })
    }
}

/// Difference between the models of first and second order over the handout's 0.3 s.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrderDifference {
    /// Largest difference of speed in RPM.
    pub largest_rpm: f64,
    /// Time of the largest difference in s.
    pub largest_at_s: f64,
    /// RMS of the difference in RPM.
    pub rms_rpm: f64,
    /// Largest difference over the steady speed (the last speed without one).
    pub largest_relative: f64,
    /// RMS difference over the same.
    pub rms_relative: f64,
    /// Largest difference of angle in encoder counts.
    pub largest_counts: f64,
    /// Electrical time constant L/R in s.
    pub electrical_s: f64,
    /// Mechanical time constant J R / (R b + Kt Kb) in s; `None` without any damping.
    pub mechanical_s: Option<f64>,
    /// Inductance in H at which the largest difference reaches [`VISIBLE`] of the steady speed.
    pub visible_from_h: Option<f64>,
}

impl OrderDifference {
    /// Difference of two curves on the same times.
    pub fn between(first: &Curve, second: &Curve, parameters: &Parameters) -> Self {
        let differences = || {
            first
                .speed_rad_s
                .iter()
                .zip(&second.speed_rad_s)
                .map(|(a, b)| a - b)
        };
        let (at, largest) = differences()
            .map(f64::abs)
            .enumerate()
            .fold(
                (0, 0.0),
                |best, now| if now.1 > best.1 { now } else { best },
            );
        let last = first.speed_rad_s.last().copied().unwrap_or(0.0);
        let top = first.steady_speed_rad_s.unwrap_or(last);
        let angles = first.angle_rad.iter().zip(&second.angle_rad);
        let largest_angle = angles.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let rms_rad_s = rms(differences());
        let mechanical_s = first.time_constants_s.first().copied();
        Self {
            largest_rpm: rpm_from_rad_s(largest),
            largest_at_s: first.t_s.get(at).copied().unwrap_or(0.0),
            rms_rpm: rpm_from_rad_s(rms_rad_s),
            largest_relative: largest / top,
            rms_relative: rms_rad_s / top,
            largest_counts: largest_angle / rad_per_count(parameters.counts_per_rev),
            electrical_s: parameters.inductance_h / parameters.resistance_ohm,
            mechanical_s,
            visible_from_h: mechanical_s.map(|tau_s| visible_from_h(parameters, tau_s)),
        }
    }
}

/// Largest difference of the two orders' step responses over the steady speed, from their closed forms.
fn largest_relative(parameters: &Parameters, inductance_h: f64, mechanical_s: f64) -> f64 {
    let second = TransferFunction::second_order(&Parameters {
        inductance_h,
        ..*parameters
    });
    let first = TransferFunction::first_order(parameters);
    let steady = first.steady_gain().unwrap_or(f64::NAN);
    (0..=2000)
        .map(|k| f64::from(k) * 0.005 * mechanical_s)
        .map(|t_s| (first.step_speed(1.0, t_s) - second.step_speed(1.0, t_s)).abs() / steady)
        .fold(0.0, f64::max)
}

/// Inductance in H from which the orders differ visibly, by bisection: the difference increases with L.
fn visible_from_h(parameters: &Parameters, mechanical_s: f64) -> f64 {
    let (mut low, mut high) = (0.0, mechanical_s * parameters.resistance_ohm);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if largest_relative(parameters, middle, mechanical_s) < VISIBLE {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_speeds_follow_the_torque_balance() {
        let p = Parameters::default();
        // (Kt V / R - Tf) / (b + Kt Kb / R) = 0.295 / 0.059, and V / Kb without friction.
        let steady = |k: usize| CURVES[k].steady_speed_rad_s(&p, p.supply_v).unwrap();
        assert!((steady(2) - 5.0).abs() < 1e-12);
        assert!((steady(0) - 0.315 / 0.059).abs() < 1e-12);
        assert!((steady(3) - 4.5 / 0.7).abs() < 1e-12);
        assert_eq!(CURVES[2].steady_speed_rad_s(&p, 0.1), Some(0.0));
    }

    #[test]
    fn an_inductance_at_the_limit_has_the_stated_visibility() {
        let mut p = Parameters::default();
        let tau_s = 0.02 / 0.59;
        p.inductance_h = visible_from_h(&p, tau_s);
        let first = Curve::simulated(&CURVES[0], &p).unwrap();
        let second = Curve::simulated(&CURVES[1], &p).unwrap();
        let difference = OrderDifference::between(&first, &second, &p);
        assert!((difference.largest_relative - VISIBLE).abs() < 1e-4);
    }
}
