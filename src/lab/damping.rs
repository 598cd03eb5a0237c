//! Part 1: the damping terms of the motor, and the error of leaving one out.
//!
//! At steady speed the torques balance: `Kt V / R = (Kt Kb / R) w + b w + Tf`.

use serde::Serialize;

use crate::motor::Parameters;

/// A term of the torque balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Term {
    /// Back EMF, `Kt Kb / R` times the speed.
    BackEmf,
    /// Viscous friction, `b` times the speed.
    Viscous,
    /// Coulomb friction, `Tf`.
    Coulomb,
}

/// One term at steady speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Share {
    /// The term.
    pub term: Term,
    /// Its torque in N m.
    pub torque_nm: f64,
    /// Its share of the stall torque.
    pub share: f64,
    /// Steady speed in rad/s without it; `None` if no other term limits the speed.
    pub steady_without_rad_s: Option<f64>,
    /// Relative error of the steady speed without it.
    pub steady_error: Option<f64>,
    /// Time constant in s without it; `None` without damping.
    pub time_constant_without_s: Option<f64>,
}

/// The torque balance at the supply voltage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Damping {
    /// Stall torque Kt V / R in N m.
    pub stall_torque_nm: f64,
    /// Steady speed in rad/s with every term; `None` if unlimited.
    pub steady_rad_s: Option<f64>,
    /// Voltage below which the shaft does not move, R Tf / Kt, in V.
    pub breakaway_v: f64,
    /// The terms, the largest first.
    pub shares: Vec<Share>,
}

/// Coefficient of viscous damping, and friction torque.
fn balance(p: &Parameters, without: Option<Term>) -> (f64, f64) {
    let kept = |term: Term, value: f64| if without == Some(term) { 0.0 } else { value };
    let back_emf = p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm;
    (
        kept(Term::BackEmf, back_emf) + kept(Term::Viscous, p.viscous_friction_nm_s_per_rad),
        kept(Term::Coulomb, p.coulomb_friction_nm),
    )
}

fn steady(p: &Parameters, without: Option<Term>) -> Option<f64> {
    let (damping, friction_nm) = balance(p, without);
    let stall_nm = p.torque_constant_nm_per_a * p.supply_v / p.resistance_ohm;
    (damping > 0.0).then(|| (stall_nm - friction_nm).max(0.0) / damping)
}

impl Damping {
    /// The torque balance for these parameters at the supply voltage.
    pub fn of(p: &Parameters) -> Self {
        let stall_torque_nm = p.torque_constant_nm_per_a * p.supply_v / p.resistance_ohm;
        let steady_rad_s = steady(p, None);
        let speed = steady_rad_s.unwrap_or(0.0);
        let back_emf = p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm;
        // Friction at standstill is at most the motor's torque.
        let torques = [
            (Term::BackEmf, back_emf * speed),
            (Term::Viscous, p.viscous_friction_nm_s_per_rad * speed),
            (Term::Coulomb, p.coulomb_friction_nm.min(stall_torque_nm)),
        ];
        let mut shares: Vec<Share> = torques
            .into_iter()
            .map(|(term, torque_nm)| {
                let without = steady(p, Some(term));
                let (damping, _) = balance(p, Some(term));
                Share {
                    term,
                    torque_nm,
                    share: torque_nm / stall_torque_nm,
                    steady_without_rad_s: without,
                    steady_error: without
                        .filter(|_| speed > 0.0)
                        .map(|without| without / speed - 1.0),
                    time_constant_without_s: (damping > 0.0).then(|| p.inertia_kg_m2 / damping),
                }
            })
            .collect();
        shares.sort_by(|a, b| b.share.total_cmp(&a.share));
        Self {
            stall_torque_nm,
            steady_rad_s,
            breakaway_v: p.resistance_ohm * p.coulomb_friction_nm / p.torque_constant_nm_per_a,
            shares,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_handouts_motor_agrees_with_a_calculation_by_hand() {
        // Steady at 5 rad/s: 0.245 + 0.05 + 0.02 = 0.315 N m.
        let damping = Damping::of(&Parameters::default());
        let terms: Vec<Term> = damping.shares.iter().map(|share| share.term).collect();
        assert_eq!(terms, [Term::BackEmf, Term::Viscous, Term::Coulomb]);
        for (share, (torque, without)) in damping.shares.iter().zip([
            (0.245, 0.295 / 0.01),
            (0.05, 0.295 / 0.049),
            (0.02, 0.315 / 0.059),
        ]) {
            assert!((share.torque_nm - torque).abs() < 1e-12);
            assert!((share.steady_without_rad_s.unwrap() - without).abs() < 1e-9);
            assert!((share.steady_error.unwrap() - (without / 5.0 - 1.0)).abs() < 1e-12);
        }
        let whole: f64 = damping.shares.iter().map(|share| share.share).sum();
        assert!((whole - 1.0).abs() < 1e-12);
        assert!((damping.breakaway_v - 0.2 / 0.7).abs() < 1e-12);
    }

    #[test]
    fn a_motor_that_cannot_start_has_no_error_of_its_speed() {
        let stuck = Parameters {
            coulomb_friction_nm: 1.0,
            ..Parameters::default()
        };
        let damping = Damping::of(&stuck);
        assert_eq!(damping.steady_rad_s, Some(0.0));
        assert!((damping.shares[0].share - 1.0).abs() < 1e-12);
        assert!(
            damping
                .shares
                .iter()
                .all(|share| share.steady_error.is_none())
        );
    }
}
