//! Prior of the base parameters: tolerances of the motor file, or the posterior of reference runs.

use nalgebra::DMatrix;

use super::base::{BACK_EMF, BASE, Base, INDUCTANCE, TORQUE_CONSTANT, range_of};
use super::member::Member;
use super::reference::ReferencePosterior;
use super::tolerances::Tolerances;
use crate::motor::CommandKind;
use crate::motor::catalogue::catalogue;

/// Relative standard deviation of a value of the motor file, and whether it is assumed.
fn tolerance(base: &Base, key: &str) -> (f64, bool) {
    let stated = base.motor.tolerance.get(key).copied();
    (
        stated.unwrap_or(base.settings.default_tolerance),
        stated.is_none(),
    )
}

/// Relative variances of the fixed R and Kt from the motor file's tolerances: every torque, inertia and current is
/// identifiable relative to them only.
fn held_variances(base: &Base) -> (f64, f64) {
    let variance = |key: &str| tolerance(base, key).0.powi(2);
    match base.kind {
        CommandKind::Voltage => (
            variance("resistance_ohm"),
            variance("torque_constant_nm_per_a"),
        ),
        CommandKind::Current => (0.0, variance("torque_constant_nm_per_a")),
        CommandKind::Torque => (0.0, 0.0),
    }
}

/// Relative variance of values that are identifiable relative to R and Kt only: 0 if a torque is known.
pub(super) fn scale_variance(base: &Base) -> f64 {
    if base.torque_identifiable {
        return 0.0;
    }
    let (resistance, torque_constant) = held_variances(base);
    resistance + torque_constant
}

/// Prior standard deviation of a base parameter that an effect widens, relative to the motor file's: half the
/// effect's range.
pub(crate) fn freed_width(base: &Base, index: usize, number: usize) -> f64 {
    let parameter = &catalogue()[index].parameters[0];
    let (lo, hi) = range_of(parameter, base);
    let own = base.motor.parameters.get(BASE[number]).unwrap_or(1.0);
    0.5 * (hi - lo) / own
}

/// Deviation of the base parameter that an effect widens.
fn widened(base: &Base, members: &[Member], number: usize) -> Option<f64> {
    let freeing = members
        .iter()
        .find(|member| base.frees(member.id()) == Some(number));
    freeing.map(|member| freed_width(base, member.index, number))
}

/// Prior covariance of the used base parameters, and of the reference's effects after them, from the posterior of
/// reference runs; wider for a parameter that an effect widens.
pub(super) fn since(
    base: &Base,
    then: &ReferencePosterior,
    members: &[Member],
    used: &[usize],
) -> DMatrix<f64> {
    let mut covariance = then.prior(base.settings.same_axis);
    for (k, &number) in used.iter().enumerate() {
        covariance[(k, k)] += widened(base, members, number).unwrap_or(0.0).powi(2);
    }
    covariance
}

/// Prior of the used base parameters from tolerances: of the fixed R and Kt, of each parameter itself, and wider
/// where an effect widens it.
pub(super) fn tolerances(base: &Base, members: &[Member], used: &[usize]) -> Tolerances {
    let (resistance, torque_constant) = held_variances(base);
    // Sensitivity to R and to Kt: `J R/Kt`, `Kb`, `L/R`; with a known torque, `J` and `Kt/R`.
    let moves = |number: usize| match number {
        BACK_EMF => (0.0, 0.0),
        INDUCTANCE | TORQUE_CONSTANT => (-1.0, 0.0),
        _ if base.torque_identifiable => (0.0, 0.0),
        _ => (1.0, -1.0),
    };
    let held = |variance: f64, by: &dyn Fn(usize) -> f64, key: &str| {
        let column = used.iter().map(|&k| variance.sqrt() * by(k)).collect();
        (column, tolerance(base, key).1)
    };
    let mut columns: Vec<(Vec<f64>, bool)> = vec![
        held(resistance, &|k| moves(k).0, "resistance_ohm"),
        held(torque_constant, &|k| moves(k).1, "torque_constant_nm_per_a"),
    ];
    for (k, &number) in used.iter().enumerate() {
        let (own, is_assumed) = match widened(base, members, number) {
            Some(width) => (width, false),
            None => tolerance(base, BASE[number]),
        };
        let mut column = vec![0.0; used.len()];
        column[k] = own;
        columns.push((column, is_assumed));
    }
    Tolerances::new(used.len(), columns)
}
