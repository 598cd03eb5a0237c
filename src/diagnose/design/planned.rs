//! A profile as its recording would look, and models seen through it.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::board::Profile;
use crate::diagnose::fit::{Base, Fit, Model, Starts, dot, response, sensitivities, surroundings};
use crate::diagnose::noise::{Noise, Surroundings, Whitener};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{DEFAULT_TOLERANCE, ORDINARY_WANDER, UNSEEN_STEP, WANDER_TIMES_S};
use crate::motor::{CommandKind, Drive, KnownDifferences, Motor, SimulationOptions, simulate};
use crate::recording::Run;

/// Keeps what no row tells from being divided by nothing.
const LEAST_PRECISION: f64 = 1e-12;

/// What is assumed of a bench that no recording shows.
pub(super) const ORDINARY: Noise = Noise {
    strength: ORDINARY_WANDER,
    time_s: WANDER_TIMES_S[1],
    ..Noise::NONE
};

/// How a profile is to be recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sampling {
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Samples.
    pub samples: usize,
    /// Of the encoder.
    pub counts_per_rev: f64,
    /// Nominal supply in V.
    pub supply_v: f64,
}

/// A run that was not recorded: a model's simulated counts on a profile, cut into pieces as a recording is.
#[derive(Debug)]
pub(super) struct Planned {
    pub(super) pieces: Pieces,
    kind: CommandKind,
    /// Whether something is known to differ in it that is measured in units of its own: a disc, a load.
    pub(super) is_absolute: bool,
    around: Surroundings,
    noise: Noise,
    pub(super) whitener: Whitener,
}

/// A model with its numbers as it looks on a run, whitened.
#[derive(Debug)]
pub(super) struct View {
    pub(super) prediction: Vec<f64>,
    pub(super) columns: Vec<Vec<f64>>,
    /// Of `J'J + P`; none for what is only ever the truth.
    pub(super) solver: Option<Cholesky<f64, Dyn>>,
    /// Variances of its innovations where it brings scatter of its own.
    variances: Option<Vec<f64>>,
}

impl Planned {
    /// The run that a model makes of a profile with what is known to differ in it; `None` where it cannot be simulated.
    pub fn new(
        base: &Base,
        (model, x): (&Model, &[f64]),
        profile: &Profile,
        at: Sampling,
        noise: Noise,
        known: &KnownDifferences,
    ) -> Option<Self> {
        if at.samples < 2 {
            return None;
        }
        let t_s: Vec<f64> = (0..at.samples)
            .map(|k| k as f64 * at.sample_time_s)
            .collect();
        let command = profile.commands(at.sample_time_s, at.samples);
        let supply_v = known.supply_v().unwrap_or(at.supply_v);
        let mut motor = model.motor(x);
        motor.parameters.counts_per_rev = at.counts_per_rev;
        motor.parameters.supply_v = supply_v;
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let options = SimulationOptions::default();
        let trajectory = simulate(&known.applied_to(&motor), &drive, &options).ok()?;
        let run = Run {
            sample_time_s: at.sample_time_s,
            counts_per_rev: at.counts_per_rev,
            supply_v: Some(supply_v),
            command_kind: CommandKind::Voltage,
            counts: trajectory.counts,
            t_s,
            command,
            known: known.clone(),
            ..Run::default()
        };
        let pieces = Pieces::new(&[run], &base.motor).ok()?;
        let around = surroundings(&pieces, model, x, base.kind);
        let whitener = Whitener::new(&pieces, &around, noise);
        let mut of_supply = KnownDifferences::default();
        if let Some(supply_v) = known.supply_v() {
            of_supply.set("supply_v", supply_v).ok()?;
        }
        Some(Self {
            pieces,
            kind: base.kind,
            is_absolute: *known != of_supply,
            around,
            noise,
            whitener,
        })
    }

    /// The runs that were recorded, under the noise that a fit leaves.
    pub fn recorded(pieces: &Pieces, base: &Base, fit: &Fit) -> Self {
        Self {
            kind: base.kind,
            is_absolute: false,
            around: fit.around,
            noise: fit.noise,
            whitener: Whitener::new(pieces, &fit.around, fit.noise),
            pieces: pieces.clone(),
        }
    }

    /// How a model looks whose numbers are known to a precision and may give way.
    pub fn rival(
        &self,
        base: &Base,
        numbers: (&Model, &[f64]),
        precision: &DMatrix<f64>,
    ) -> Option<View> {
        self.rival_with(base, numbers, 0.0, precision)
    }

    /// The same whose motor is its twin by `more`.
    pub(super) fn rival_with(
        &self,
        base: &Base,
        (model, x): (&Model, &[f64]),
        more: f64,
        precision: &DMatrix<f64>,
    ) -> Option<View> {
        let (mut prediction, columns) = sensitivities(&self.pieces, model, x, &self.starts())?;
        let mut columns: Vec<Vec<f64>> = columns
            .iter()
            .map(|column| self.whitener.whiten(column))
            .collect();
        let mut precision = precision.clone();
        if self.is_absolute {
            let motor = model.motor(x);
            if more != 0.0 {
                prediction = response(&self.pieces, &unseen_twin(&motor, more), &self.starts())?;
            }
            let moved = |by: f64| {
                response(
                    &self.pieces,
                    &unseen_twin(&motor, more + by),
                    &self.starts(),
                )
            };
            let pairs = moved(-UNSEEN_STEP)?.into_iter().zip(moved(UNSEEN_STEP)?);
            let column: Vec<f64> = pairs.map(|(a, b)| (b - a) / (2.0 * UNSEEN_STEP)).collect();
            columns.push(self.whitener.whiten(&column));
            let n = precision.nrows();
            precision = precision.resize(n + 1, n + 1, 0.0);
            precision[(n, n)] = 1.0 / unseen_variance(base);
        }
        Some(View {
            prediction: self.whitener.whiten(&prediction),
            solver: Some(solver(&columns, precision)?),
            columns,
            variances: self.variances(model, x),
        })
    }

    /// Plans begin as they are planned.
    pub(super) fn starts(&self) -> Starts {
        Starts::measured(&self.pieces)
    }

    /// The same for a model that is only ever the truth.
    pub fn truth(&self, (model, x): (&Model, &[f64])) -> Option<View> {
        let prediction = response(&self.pieces, &model.motor(x), &self.starts())?;
        Some(View {
            prediction: self.whitener.whiten(&prediction),
            columns: Vec::new(),
            solver: None,
            variances: self.variances(model, x),
        })
    }

    pub(super) fn variances(&self, model: &Model, x: &[f64]) -> Option<Vec<f64>> {
        let own = surroundings(&self.pieces, model, x, self.kind);
        let around = Surroundings {
            jitter_s: own.jitter_s,
            loss: own.loss,
            ..self.around
        };
        let whitener = || Whitener::new(&self.pieces, &around, self.noise);
        (around != self.around).then(|| whitener().variances().collect())
    }

    /// The separation of a truth from a rival, in standard deviations; a rival that is seen as a truth only gives way nowhere.
    pub fn separation(&self, truth: &View, rival: &View) -> f64 {
        let pairs = truth.prediction.iter().zip(&rival.prediction);
        let difference: Vec<f64> = pairs.map(|(x, y)| x - y).collect();
        let left = left_after(&difference, &rival.columns, rival.solver.as_ref());
        let scatter = self.scatter(truth.variances.as_deref(), rival.variances.as_deref());
        left.hypot(scatter.sqrt())
    }

    /// What the scatter alone tells of a truth from a model.
    pub(super) fn scatter_of(&self, truth: &View, (model, x): (&Model, &[f64])) -> f64 {
        self.scatter(
            truth.variances.as_deref(),
            self.variances(model, x).as_deref(),
        )
    }

    /// What the scatter alone tells: twice the Kullback-Leibler divergence of the innovations.
    fn scatter(&self, truth: Option<&[f64]>, rival: Option<&[f64]>) -> f64 {
        if truth.is_none() && rival.is_none() {
            return 0.0;
        }
        let plain: Vec<f64> = self.whitener.variances().collect();
        let ratios = (truth.unwrap_or(&plain).iter()).zip(rival.unwrap_or(&plain));
        let told = ratios.filter(|(_, r)| **r > 0.0).map(|(s, r)| s / r);
        told.map(|rho| rho - 1.0 - rho.ln()).sum::<f64>().max(0.0)
    }
}

/// The separation of two fits on the runs that they were fitted to, under the noise that the truth leaves; without end where
/// the rival cannot be simulated.
pub(crate) fn separation_of(pieces: &Pieces, truth: &Fit, rival: &Fit) -> f64 {
    let Some((_, columns)) = sensitivities(pieces, &rival.model, &rival.x, &rival.starts) else {
        return f64::INFINITY;
    };
    let whitener = Whitener::new(pieces, &truth.around, truth.noise);
    let whiten = |column: &Vec<f64>| whitener.whiten(column);
    let columns: Vec<Vec<f64>> = columns.iter().map(whiten).collect();
    let pairs = truth.residual.iter().zip(&rival.residual);
    let difference: Vec<f64> = pairs.map(|(x, y)| y - x).collect();
    let solver = solver(&columns, rival.model.precision.clone());
    left_after(&whitener.whiten(&difference), &columns, solver.as_ref())
}

fn solver(columns: &[Vec<f64>], mut precision: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    for i in 0..columns.len() {
        precision[(i, i)] += LEAST_PRECISION;
        for j in 0..=i {
            let told = dot(&columns[i], &columns[j]);
            precision[(i, j)] += told;
            if i != j {
                precision[(j, i)] += told;
            }
        }
    }
    precision.cholesky()
}

/// The size of what is left of a whitened difference when the numbers of some columns may give way.
fn left_after(
    difference: &[f64],
    columns: &[Vec<f64>],
    solver: Option<&Cholesky<f64, Dyn>>,
) -> f64 {
    let right = DVector::from_fn(columns.len(), |k, _| dot(&columns[k], difference));
    let gain = solver.map_or(0.0, |solver| solver.solve(&right).dot(&right));
    (dot(difference, difference) - gain).max(0.0).sqrt()
}

/// The motor with more resistance and all that is mechanical smaller by the same factor: voltage in and counts out are those of
/// the motor, so that no recording tells how far it is right. With a known inertia or load they are not.
pub(super) fn unseen_twin(motor: &Motor, by: f64) -> Motor {
    let mut twin = motor.clone();
    twin.parameters.resistance_ohm *= 1.0 + by;
    for key in [
        "inertia_kg_m2",
        "coulomb_friction_nm",
        "viscous_friction_nm_s_per_rad",
    ] {
        if let Some(value) = twin.parameters.get_mut(key) {
            *value /= 1.0 + by;
        }
    }
    for effect in twin.effects.iter_mut() {
        let parameters = effect.kind().parameters;
        for (value, parameter) in effect.values.iter_mut().zip(parameters) {
            let mut units = ["N m", "kg m^2"].iter();
            if units.any(|unit| parameter.unit.starts_with(unit)) {
                *value /= 1.0 + by;
            }
        }
    }
    twin
}

/// Variance of the logarithm of `R/Kt`, by what the motor file says of both.
pub(super) fn unseen_variance(base: &Base) -> f64 {
    let variance = |key: &str| {
        let stated = base.motor.tolerance.get(key).copied();
        stated.unwrap_or(DEFAULT_TOLERANCE).powi(2)
    };
    variance("resistance_ohm") + variance("torque_constant_nm_per_a")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::diagnose::design) fn base() -> Base {
        Base {
            motor: Motor::default(),
            kind: CommandKind::Voltage,
            sample_time_s: 0.01,
            clock: None,
            is_host_timed: false,
            knows_torque: false,
            then: None,
        }
    }

    pub(in crate::diagnose::design) fn planned(base: &Base, key: Option<(&str, f64)>) -> Planned {
        let mut known = KnownDifferences::default();
        if let Some((key, value)) = key {
            known.set(key, value).expect("a known difference");
        }
        let at = Sampling {
            sample_time_s: 0.01,
            samples: 600,
            counts_per_rev: 720.0,
            supply_v: 4.5,
        };
        let model = Model::new(base, Vec::new());
        let numbers = model.start();
        let profile = Profile::built_in("reversing", 4.5, 6.0).expect("built in");
        Planned::new(base, (&model, &numbers), &profile, at, ORDINARY, &known).expect("a motor")
    }

    /// More resistance, and all that is mechanical smaller by as much, is the same equation; a disc or a load of known size is not
    /// smaller with them.
    #[test]
    fn a_known_disc_or_load_alone_tells_the_twin_from_the_motor() {
        let base = base();
        let motor = &base.motor;
        let twin = unseen_twin(motor, 0.05);
        let off = |key| {
            let planned = planned(&base, key);
            let one = response(&planned.pieces, motor, &planned.starts()).expect("a motor");
            let other = response(&planned.pieces, &twin, &planned.starts()).expect("a motor");
            let off = one.iter().zip(other).map(|(a, b)| (a - b).abs());
            off.fold(0.0, f64::max)
        };
        assert!(off(None) < 0.01, "{}", off(None));
        for known in [("inertia_added_kg_m2", 0.002), ("gravity_torque_nm", 0.1)] {
            assert!(off(Some(known)) > 0.5, "{known:?}: {}", off(Some(known)));
        }
    }

    /// What is left of a difference is what lies outside the columns (free numbers), and what a number known to a precision does not
    /// give way: `a^2 p / (1 + p)` of a part of length `a` along a column of length 1.
    #[test]
    fn the_separation_is_what_does_not_give_way() {
        let columns = [vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0]];
        let left = |precision: f64| {
            let known = DMatrix::from_diagonal_element(2, 2, precision);
            left_after(
                &[3.0, 4.0, 12.0],
                &columns,
                solver(&columns, known).as_ref(),
            )
        };
        assert!((left(0.0) - 12.0).abs() < 1e-6);
        assert!((left(1e12) - 13.0).abs() < 1e-6);
        assert!((left(3.0) - (144.0_f64 + 25.0 * 0.75).sqrt()).abs() < 1e-9);
    }
}
