//! The inverse form: the command on the left, on the right what it takes to move as the shaft did move.
//!
//! A model of a motor is linear in most of what it may lack, once the motion is known. With a kernel `K` of half width `h`, bell-shaped
//! and 0 at its ends, every term is smoothed alike, and the derivatives pass to the kernel (modulating functions: Preisig and Rippin,
//! 1993; in many fields the weak form: Messenger and Bortz, 2021):
//!
//! ```text
//! K*u = c_a K''*angle + c_w K'*angle + c_s K*sgn(speed) + c K*(what an effect takes)
//! ```
//!
//! No simulation, no start and no local optimum. It holds where a controller answers to the motion (Janot, Gautier: inverse dynamic
//! identification): there a simulation of a motor that lacks its load drifts away from the recording whatever its numbers are.
//! How much of what the motor alone leaves a term takes, on folds that it was not fitted to, is its gain. Runs are never joined.

mod regression;
mod rows;

use super::periodic::{Wave, orders};
use crate::diagnose::fit::{BASE, Base, Member, error_of_sum};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{INVERSE_ROWS, STRIBECK_SHARES, TIED_ERRORS};
use crate::motor::CommandKind;
use crate::motor::catalogue::catalogue;
use regression::{Normal, predicted_squares, robust_weights};
use rows::{Row, rows};

/// What a term is a function of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Form {
    /// The same whatever the motion.
    Offset,
    /// `|speed|`: what differs by direction in proportion to it.
    Gain,
    /// `speed |speed|`.
    Drag,
    /// `sgn(speed) exp(-(speed/s)^2)` with `s` this share of the top speed.
    Start(f64),
    /// Sine and cosine of so many times the angle.
    Angle(usize),
}

impl Form {
    /// Effects that take it.
    pub fn ids(self) -> &'static [&'static str] {
        match self {
            Self::Offset => &[
                "asymmetric_friction",
                "constant_load",
                "asymmetric_voltage_drop",
            ],
            Self::Gain => &["asymmetric_viscous", "asymmetric_gain"],
            Self::Drag => &[
                "quadratic_drag",
                "supply_sag",
                "current_limit",
                "winding_heating",
            ],
            Self::Start(_) => &["stribeck", "static_friction", "dead_zone"],
            Self::Angle(1) => &["gravity_load"],
            Self::Angle(_) => &["cogging"],
        }
    }

    /// Whether it can only brake.
    fn brakes(self) -> bool {
        matches!(self, Self::Drag | Self::Start(_))
    }

    fn columns(self, row: &Row, top: f64) -> Vec<f64> {
        match self {
            Self::Offset => vec![1.0],
            Self::Gain => vec![row.speed.abs()],
            Self::Drag => vec![row.speed * row.speed.abs()],
            Self::Start(share) => {
                vec![row.speed.signum() * (-(row.speed / (share * top)).powi(2)).exp()]
            }
            Self::Angle(order) => {
                let (sine, cosine) = (order as f64 * row.angle).sin_cos();
                vec![sine, cosine]
            }
        }
    }
}

/// The motor's own part: volts (or amperes, or newton metres) per rad/s^2, per rad/s, against friction, and per N m of a known torque.
pub(crate) type Own = [f64; OWN];

/// How many numbers the motor's own part has.
const OWN: usize = 4;

/// What a term takes of what the motor alone leaves.
#[derive(Debug, Clone)]
pub(crate) struct Pick {
    pub form: Form,
    /// Share of the squares, on folds not fitted.
    pub gain: f64,
    /// Its standard error, by pieces.
    pub error: f64,
    /// The motor's own part beside it, and its own coefficients.
    pub own: Own,
    pub coefficients: Vec<f64>,
    /// What it takes of the squares of each piece.
    of_pieces: Vec<f64>,
}

impl Pick {
    /// Whether it stands out of its own error.
    pub fn is_seen(&self) -> bool {
        self.gain > TIED_ERRORS * self.error
    }

    /// Cycles in a turn, where it repeats with the angle.
    pub fn order(&self) -> Option<usize> {
        match self.form {
            Form::Angle(order) => Some(order),
            _ => None,
        }
    }

    /// Whether a member has the order of the angle that it has found, where it has one.
    pub fn is_of_order(&self, member: &Member) -> bool {
        match self.form {
            Form::Angle(order) if order > 1 => member.values[1] == order as f64,
            _ => true,
        }
    }

    /// A member with the amplitude and the phase that it has found, where it has them.
    pub fn started(&self, base: &Base, member: &Member) -> Member {
        let mut member = member.clone();
        if let (Form::Angle(order), [sine, cosine]) = (self.form, &self.coefficients[..]) {
            // Gravity is what has to be overcome, cogging pushes by itself.
            let per_unit =
                if order == 1 { 1.0 } else { -1.0 } / base.kind.per_nm(&base.motor.parameters);
            member.values = Wave { per_unit }.values(&member, (*sine, *cosine));
        }
        member
    }

    /// Whether another is not told from it.
    pub fn is_tied_with(&self, other: &Self) -> bool {
        let each = self.of_pieces.iter().zip(&other.of_pieces);
        let apart: Vec<f64> = each.map(|(a, b)| a - b).collect();
        self.gain - other.gain <= TIED_ERRORS * error_of_sum(&apart)
    }
}

fn own_columns(row: &Row) -> Vec<f64> {
    let known = row.known_nm;
    vec![row.acceleration, row.speed, row.speed.signum(), known]
}

/// The motor's own part where it alone explains the command; none where too little moves.
pub(crate) fn own_part(pieces: &Pieces) -> Option<Own> {
    let rows = rows(pieces);
    if rows.len() < INVERSE_ROWS {
        return None;
    }
    let alone: Vec<Vec<f64>> = rows.iter().map(own_columns).collect();
    let weight = robust_weights(&rows, &alone);
    let found = Normal::of(&alone, &rows, &weight, |_| true).solved(&[true; OWN]);
    Some(std::array::from_fn(|k| found[k]))
}

/// Terms by what they take, most first, the best of each kind; none where too little moves.
pub(crate) fn picks(pieces: &Pieces) -> Vec<Pick> {
    let rows = rows(pieces);
    if rows.len() < INVERSE_ROWS {
        return Vec::new();
    }
    let top = rows
        .iter()
        .fold(0.0_f64, |most, row| most.max(row.speed.abs()));
    let goes_round = pieces.runs.iter().any(|run| run.goes_round);
    let alone: Vec<Vec<f64>> = rows.iter().map(own_columns).collect();
    let weight = robust_weights(&rows, &alone);
    let Some(left) = predicted_squares(&rows, &alone, &[true; OWN], &weight, pieces) else {
        return Vec::new();
    };
    let sum: f64 = left.iter().sum();
    let mut forms = vec![Form::Offset, Form::Gain, Form::Drag];
    forms.extend(STRIBECK_SHARES.map(Form::Start));
    if !goes_round {
        let repeating = catalogue()
            .iter()
            .filter(|kind| ["gravity_load", "cogging"].contains(&kind.id));
        let is_load_known = pieces.runs.iter().all(|run| run.known.has_load());
        let orders = repeating.flat_map(orders);
        forms.extend(
            orders
                .filter(|order| *order > 1 || !is_load_known)
                .map(Form::Angle),
        );
    }
    let mut found: Vec<Pick> = Vec::new();
    for form in forms {
        let with: Vec<Vec<f64>> = (rows.iter().zip(&alone))
            .map(|(row, own)| [own.clone(), form.columns(row, top)].concat())
            .collect();
        let mut brakes = vec![true; OWN];
        brakes.resize(with[0].len(), form.brakes());
        let Some(then) = predicted_squares(&rows, &with, &brakes, &weight, pieces) else {
            continue;
        };
        let of_pieces: Vec<f64> = left.iter().zip(&then).map(|(a, b)| (a - b) / sum).collect();
        let all = Normal::of(&with, &rows, &weight, |_| true);
        let coefficients = all.solved(&brakes);
        found.push(Pick {
            form,
            gain: of_pieces.iter().sum(),
            error: error_of_sum(&of_pieces),
            own: std::array::from_fn(|k| coefficients[k]),
            coefficients: coefficients[OWN..].to_vec(),
            of_pieces,
        });
    }
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut kinds: Vec<&[&str]> = Vec::new();
    found.retain(|pick| {
        let is_new = !kinds.contains(&pick.form.ids());
        kinds.push(pick.form.ids());
        is_new
    });
    found
}

/// The base numbers as shares of the motor file's, in the order of [`BASE`], that a motor's own part comes to. Without a known torque
/// that of Kt is 1, with R as it is. The inductance is not in it.
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
    use crate::diagnose::samples::{motor_with, recording};
    use crate::diagnose::settings::INVERSE_DECIDES;
    use crate::motor::{Motor, Parameters};
    use crate::recording::Run;

    fn found(motor: &Motor) -> (Vec<Pick>, Base) {
        found_in(recording(motor, 3000))
    }

    fn found_in(run: Run) -> (Vec<Pick>, Base) {
        let nominal = Motor::default();
        let pieces = Pieces::new(&[run], &nominal).expect("a run");
        let base = Base {
            motor: nominal,
            kind: CommandKind::Voltage,
            sample_time_s: pieces.runs[0].sample_time_s,
            clock: None,
            is_host_timed: false,
            knows_torque: false,
            then: None,
        };
        (picks(&pieces), base)
    }

    /// A motor without any effect leaves nothing to pick, and its own part is the motor file's.
    #[test]
    fn a_plain_motor_has_nothing_to_pick() {
        let (picks, base) = found(&Motor::default());
        assert!(
            picks.iter().all(|pick| pick.gain < INVERSE_DECIDES),
            "{picks:?}"
        );
        let of = shares(&base, picks[0].own);
        assert!(of.iter().all(|share| (share - 1.0).abs() < 0.15), "{of:?}");
    }

    /// A load on an arm is the first pick by far; its torque in volts is `torque R/Kt`.
    #[test]
    fn a_load_on_an_arm_has_its_torque() {
        let torque_nm = 0.05;
        let (picks, base) = found(&motor_with(&[("gravity_load", &[torque_nm, 0.6])]));
        let first = &picks[0];
        assert_eq!(first.form, Form::Angle(1));
        assert!(first.gain > INVERSE_DECIDES && first.is_seen(), "{first:?}");
        assert!(!first.is_tied_with(&picks[1]), "{:?}", picks[1]);
        let Parameters {
            resistance_ohm,
            torque_constant_nm_per_a,
            ..
        } = base.motor.parameters;
        let volts = first.coefficients[0].hypot(first.coefficients[1]);
        let expected = torque_nm * resistance_ohm / torque_constant_nm_per_a;
        assert!(
            (volts / expected - 1.0).abs() < 0.1,
            "{volts} for {expected}"
        );
        let phase = first.coefficients[1].atan2(first.coefficients[0]);
        assert!((phase - 0.6).abs() < 0.2, "{phase}");
    }

    /// A known load is no gravity that is found: its torque tells what a newton metre takes, and the motor's own part in it.
    #[test]
    fn a_known_load_tells_what_torque_takes() {
        let mut motor = motor_with(&[("gravity_load", &[0.12, 0.0])]);
        let mut run = recording(&motor, 3000);
        (run.known.set("gravity_torque_nm", 0.12)).expect("a known load");
        let (picks, base) = found_in(run);
        assert!(
            picks.iter().all(|pick| pick.order() != Some(1)),
            "{picks:?}"
        );
        let p = &mut motor.parameters;
        let found = picks[0].own[OWN - 1] * p.torque_constant_nm_per_a / p.resistance_ohm;
        assert!((found - 1.0).abs() < 0.1, "{found}");
        let of = shares(&base, picks[0].own);
        assert!((of[BASE.len() - 1] - 1.0).abs() < 0.1, "{of:?}");
    }

    /// Counts that fall under a positive command: nothing brakes so, and nothing is found.
    #[test]
    fn a_motor_that_turns_the_wrong_way_leaves_all() {
        let mut run = recording(&Motor::default(), 1000);
        run.counts.iter_mut().for_each(|count| *count = -*count);
        let (picks, _) = found_in(run);
        assert!(picks.iter().all(|pick| pick.own == [0.0; OWN]), "{picks:?}");
    }

    /// Viscous friction that differs by direction is the same as a gain that does, and told from an offset.
    #[test]
    fn a_direction_is_told_from_an_offset() {
        let (picks, _) = found(&motor_with(&[("asymmetric_gain", &[0.1])]));
        assert_eq!(picks[0].form, Form::Gain, "{picks:?}");
        assert!(picks[0].is_seen(), "{:?}", picks[0]);
    }
}
