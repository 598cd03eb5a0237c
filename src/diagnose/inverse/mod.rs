//! Equation-error regression (inverse dynamics identification; Janot and Gautier): starts for the fits.
//!
//! In: segments. Out: coefficients of the equation of motion. With a bell-shaped kernel `K` that vanishes at its
//! ends, every term is smoothed alike and derivatives pass to the kernel (modulating functions; Preisig and Rippin
//! 1993): `K*u = c_a K''*angle + c_w K'*angle + c_s K*sgn(speed)`. It needs no simulation and no start, and has no
//! local optimum, also in closed loop.

mod regression;
mod rows;

use super::model::{BASE, Base};
use super::segments::Segments;
use super::settings::solver::LEAST_ROWS;
use crate::motor::CommandKind;
use crate::motor::catalogue::EffectKind;
use regression::{Normal, robust_weights};
use rows::{Row, rows};

/// Coefficients of the nominal motor: volts (or amperes, or newton metres) per rad/s^2, per rad/s, of friction, and
/// per N m of a known torque.
pub(crate) type Own = [f64; OWN];

/// Number of these coefficients.
const OWN: usize = 4;

fn own_columns(row: &Row) -> Vec<f64> {
    let known = row.known_nm;
    vec![row.acceleration, row.speed, row.speed.signum(), known]
}

/// The coefficients of the nominal motor alone; `None` with too little motion.
pub(crate) fn own_part(segments: &Segments) -> Option<Own> {
    let rows = rows(segments);
    if rows.len() < LEAST_ROWS {
        return None;
    }
    let alone: Vec<Vec<f64>> = rows.iter().map(own_columns).collect();
    let weight = robust_weights(&rows, &alone);
    let found = Normal::of(&alone, &rows, &weight).solved(&[true; OWN]);
    Some(std::array::from_fn(|k| found[k]))
}

/// A load in addition to the nominal motor: amplitude and phase of `gravity_load`, torque of `constant_load`, in N m;
/// `None` with too little motion or for a wrong sign.
pub(crate) fn load_term(
    segments: &Segments,
    base: &Base,
    kind: &EffectKind,
) -> Option<(Own, Vec<f64>)> {
    let rows = rows(segments);
    let is_known = segments.runs.iter().all(|run| run.known.has_load());
    let repeats = kind.parameters.len() == 2;
    if rows.len() < LEAST_ROWS || (repeats && is_known) {
        return None;
    }
    let with: Vec<Vec<f64>> = (rows.iter())
        .map(|row| {
            let mut columns = own_columns(row);
            columns.extend_from_slice(if repeats { &row.wave } else { &[1.0] });
            columns
        })
        .collect();
    let alone: Vec<Vec<f64>> = rows.iter().map(own_columns).collect();
    let weight = robust_weights(&rows, &alone);
    let mut brakes = vec![true; OWN];
    brakes.resize(with[0].len(), false);
    let found = Normal::of(&with, &rows, &weight).solved(&brakes);
    let per_nm = base.kind.per_nm(&base.motor.parameters);
    let values = match &found[OWN..] {
        [sine, cosine] => vec![
            sine.hypot(*cosine) / per_nm,
            cosine.atan2(*sine).rem_euclid(std::f64::consts::TAU),
        ],
        [offset] => vec![offset / per_nm],
        _ => return None,
    };
    let own: Own = std::array::from_fn(|k| found[k]);
    (own[0] > 0.0).then_some((own, values))
}

/// The base parameters relative to the motor file's, in the order of [`BASE`], from the coefficients. Without a known
/// torque Kt is unchanged, with the assumed R. The inductance is not determined.
pub(crate) fn shares(base: &Base, [inertia, speed, friction, known]: Own) -> [f64; BASE.len()] {
    let p = &base.motor.parameters;
    let own_per_nm = base.kind.per_nm(p);
    let per_nm = if known > 0.0 { known } else { own_per_nm };
    let back_emf = match base.kind {
        CommandKind::Voltage => p.back_emf_v_s_per_rad,
        _ => 0.0,
    };
    let of = |found: f64, own: f64| if own > 0.0 { found / own } else { 1.0 };
    let turning = of(speed, back_emf + p.viscous_friction_nm_s_per_rad * per_nm);
    [
        of(inertia, p.inertia_kg_m2 * per_nm),
        turning,
        of(friction, p.coulomb_friction_nm * per_nm),
        turning,
        1.0,
        own_per_nm / per_nm,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::pipeline::Prepared;
    use crate::diagnose::samples::recording;
    use crate::diagnose::settings::Settings;
    use crate::motor::Motor;

    /// For a recording of the nominal motor the regression gives its parameters.
    #[test]
    fn base_parameters_of_a_plain_motor_are_its_parameters() {
        let run = [recording(&Motor::default(), 3000)];
        let prepared =
            Prepared::new(&run, &Motor::default(), &Settings::default(), false).expect("a run");
        let own = own_part(&prepared.all).expect("it moves");
        let of = shares(&prepared.base, own);
        assert!(of.iter().all(|share| (share - 1.0).abs() < 0.15), "{of:?}");
    }

    /// Counts that fall under a positive command are no friction: there is no result.
    #[test]
    fn a_reversed_motor_has_no_separate_part() {
        let mut run = recording(&Motor::default(), 1000);
        run.counts.iter_mut().for_each(|count| *count = -*count);
        let run = [run];
        let prepared =
            Prepared::new(&run, &Motor::default(), &Settings::default(), false).expect("a run");
        assert_eq!(own_part(&prepared.all), Some([0.0; OWN]));
    }
}
