//! One case: three runs, one held-out run, the nominal motor, and the label.

use std::collections::BTreeMap;

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use crate::effect::Effect;
use crate::kind::Kind;
use crate::motor::Motor;
use crate::profile::Profile;
use crate::random_torque::RandomTorque;
use crate::record::{CaseRun, Conditions, record};
use crate::strength::{beyond_refit, counts_under_conditions, counts_without_noise, rms};
use crate::true_motor::TrueMotor;

/// Options of the draw, besides the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Motors other than the handout's: each value by up to a factor of two, other encoders and supplies.
    pub other_motors: bool,
    /// Factor on the random torque of load and friction, which is 0.03 to 1 % of Tf (one sigma).
    pub random_torque_scale: f64,
    /// Least change of the angle by an effect in counts (RMS over the runs).
    pub least_counts: f64,
    /// For motors with backlash or compliance, friction is divided otherwise than inertia.
    pub friction_elsewhere: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            other_motors: false,
            random_torque_scale: 1.0,
            least_counts: 2.0,
            friction_elsewhere: false,
        }
    }
}

/// The truth of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// `none`, `single`, `pair` or `outside`.
    pub kind: String,
    /// The hidden effects with their true parameters; for those that a motor file has under other names (inertia,
    /// friction) the true value is here and the value without the effect in `motor`.
    pub effects: Vec<Effect>,
    /// Strength of each effect: change of the angle without it in counts (RMS over the three runs).
    pub strength_counts: BTreeMap<String, f64>,
    /// Residual of all effects together in counts RMS after re-identification of R, K, J, b and Tf within their
    /// tolerances (linear estimate); 0 without effects.
    pub beyond_refit_counts: f64,
    /// RMS in counts between the held-out run and the true motor without its random torque (same random numbers of
    /// effects): the lower bound of a model without knowledge of the random torque.
    pub unseen_floor_counts: f64,
    /// The motor, without the effects.
    pub motor: Motor,
    /// Standard deviation of the random torque of load and of friction, relative to Tf.
    #[serde(alias = "wander_relative")]
    pub random_torque_relative: f64,
    /// Correlation time of the random torque in s.
    #[serde(alias = "wander_time_s")]
    pub random_torque_time_s: f64,
}

impl Label {
    /// Standard deviation of the random load torque as a share of the stall torque; 0 without a random load.
    pub fn random_load_share(&self) -> f64 {
        let m = &self.motor;
        let stall_nm = m.torque_constant_nm_per_a * m.supply_v / m.resistance_ohm;
        // The random torque is relative to Tf with the effect.
        let mut effects = self.effects.iter();
        let changed = effects.find(|effect| effect.id == "coulomb_friction");
        let friction_nm = changed.and_then(|effect| effect.parameters.get("torque_nm"));
        self.random_torque_relative * friction_nm.unwrap_or(&m.coulomb_friction_nm) / stall_nm
    }
}

/// A case: the input of a diagnosis, and the withheld part.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Step at 0.03 s, step at 0.003 s (4 s each), multi-level reversing at 0.003 s (15 s).
    pub runs: Vec<CaseRun>,
    /// Another multi-level reversing run, for scoring predictions.
    pub unseen_run: CaseRun,
    /// The nominal motor, without effects.
    pub nominal: Motor,
    /// The truth.
    pub label: Label,
}

/// A case of the handout's kind of motor, determined by seed and kind.
pub fn generate(seed: u64, kind: &Kind) -> Case {
    generate_with(seed, kind, &Options::default())
}

/// [`generate`] with other motors, more random torque, or weaker effects.
pub fn generate_with(seed: u64, kind: &Kind, options: &Options) -> Case {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let ids: Vec<&str> = match kind {
        Kind::None => vec![],
        Kind::Single(id) | Kind::Outside(id) => vec![id],
        Kind::Pair(a, b) => vec![a, b],
    };
    let mut drawing = DrawnCase::draw(&ids, options, &mut rng);
    for _ in 1..MOST_DRAWINGS {
        if drawing.drawn.margin >= 1.0 {
            break;
        }
        // An effect without a drawn magnitude may have no influence in these runs of this motor.
        let other = DrawnCase::draw(&ids, options, &mut rng);
        if other.drawn.margin > drawing.drawn.margin {
            drawing = other;
        }
    }
    let DrawnCase {
        motor,
        nominal,
        random_torque,
        profiles,
        noise_seed,
        drawn,
    } = drawing;
    let plain = TrueMotor::without_effects(motor);
    let judged = &profiles[..3];
    let without = counts_without_noise(&plain, judged, noise_seed);
    let beyond_refit_counts = if ids.is_empty() {
        0.0
    } else {
        beyond_refit(&plain, judged, noise_seed, &drawn.counts, &without)
    };

    let mut runs: Vec<CaseRun> = Vec::with_capacity(4);
    let mut unseen_floor_counts = 0.0;
    for (k, profile) in profiles.iter().enumerate() {
        let seed = noise_seed.wrapping_add(k as u64);
        let conditions = Conditions {
            random_torque,
            seed,
        };
        let recording = record(&drawn.hidden, profile, motor.counts_per_rev, conditions);
        if k == 3 {
            unseen_floor_counts = floor_counts(&drawn.hidden, &recording.run, conditions);
        }
        runs.push(recording.run);
    }
    let unseen_run = runs.remove(3);
    let kind = match kind {
        Kind::None => "none",
        Kind::Single(_) => "single",
        Kind::Pair(..) => "pair",
        Kind::Outside(_) => "outside",
    };
    Case {
        runs,
        unseen_run,
        nominal,
        label: Label {
            kind: kind.to_owned(),
            effects: drawn.effects,
            strength_counts: drawn.strengths,
            beyond_refit_counts,
            unseen_floor_counts,
            motor,
            random_torque_relative: random_torque.sigma,
            random_torque_time_s: random_torque.time_s,
        },
    }
}

/// Most motors drawn until the effects change the angle by enough.
const MOST_DRAWINGS: usize = 20;

/// A motor with its command and effects.
struct DrawnCase {
    motor: Motor,
    nominal: Motor,
    random_torque: RandomTorque,
    profiles: Vec<Profile>,
    noise_seed: u64,
    drawn: DrawnEffects,
}

impl DrawnCase {
    fn draw(ids: &[&str], options: &Options, rng: &mut impl Rng) -> Self {
        let motor = Motor::draw(rng, options.other_motors);
        let nominal = motor.draw_nominal(rng);
        let random_torque = RandomTorque {
            sigma: options.random_torque_scale * log_uniform(rng, 0.0003, 0.01),
            time_s: log_uniform(rng, 0.3, 3.0),
        };
        let profiles = profiles(&motor, rng);
        let noise_seed = rng.random::<u64>();
        let plain = TrueMotor::without_effects(motor);
        let drawn = draw_effects(ids, &plain, &profiles[..3], noise_seed, options, rng);
        Self {
            motor,
            nominal,
            random_torque,
            profiles,
            noise_seed,
            drawn,
        }
    }
}

/// The three runs of a case, then the held-out one.
fn profiles(motor: &Motor, rng: &mut impl Rng) -> Vec<Profile> {
    let supply = motor.supply_v;
    let breakaway =
        motor.coulomb_friction_nm * motor.resistance_ohm / motor.torque_constant_nm_per_a;
    vec![
        Profile::step(0.03, 4.0, supply),
        Profile::step(0.003, 4.0, supply),
        Profile::multi_level(0.003, 15.0, supply, breakaway, rng),
        Profile::multi_level(0.003, 15.0, supply, breakaway, rng),
    ]
}

struct DrawnEffects {
    hidden: TrueMotor,
    effects: Vec<Effect>,
    strengths: BTreeMap<String, f64>,
    /// Encoder reading with all effects, without random torque.
    counts: Vec<f64>,
    /// The weakest effect's strength relative to the least one.
    margin: f64,
}

/// Draws magnitudes until each effect changes the angle by enough; after many attempts, the strongest.
fn draw_effects(
    ids: &[&str],
    plain: &TrueMotor,
    profiles: &[Profile],
    noise_seed: u64,
    options: &Options,
    rng: &mut impl Rng,
) -> DrawnEffects {
    const TRIES: usize = 30;
    let with = |effects: &[&Effect]| {
        let mut hidden = plain.clone();
        for effect in effects {
            effect.apply(&mut hidden);
        }
        let counts = counts_without_noise(&hidden, profiles, noise_seed);
        (hidden, counts)
    };
    let mut best: Option<DrawnEffects> = None;
    for _ in 0..TRIES {
        let effects: Vec<Effect> = ids
            .iter()
            .map(|id| {
                let effect = Effect::draw(id, &plain.motor, rng);
                if options.friction_elsewhere {
                    effect.with_friction_elsewhere(rng)
                } else {
                    effect
                }
            })
            .collect();
        let (hidden, counts) = with(&effects.iter().collect::<Vec<_>>());
        let mut strengths = BTreeMap::new();
        let mut margin = f64::INFINITY;
        for effect in &effects {
            let others: Vec<&Effect> = effects.iter().filter(|e| e.id != effect.id).collect();
            let strength = rms(&counts, &with(&others).1);
            margin = margin.min(strength / least_counts(&effect.id, options));
            strengths.insert(effect.id.clone(), strength);
        }
        let drawn = DrawnEffects {
            hidden,
            effects,
            strengths,
            counts,
            margin,
        };
        if margin >= 1.0 {
            return drawn;
        }
        if best.as_ref().is_none_or(|other| margin > other.margin) {
            best = Some(drawn);
        }
    }
    best.unwrap_or_else(|| DrawnEffects {
        hidden: plain.clone(),
        effects: Vec::new(),
        strengths: BTreeMap::new(),
        counts: counts_without_noise(plain, profiles, noise_seed),
        margin: 0.0,
    })
}

/// The least strength of an effect. Jitter has another limit: a spread of a whole sample at 3 ms changes the
/// handout's motor by 1.5 counts at top speed.
fn least_counts(id: &str, options: &Options) -> f64 {
    if id == "sample_jitter" {
        options.least_counts.min(0.4)
    } else {
        options.least_counts
    }
}

/// RMS in counts between a run and the same motor without random torque.
fn floor_counts(hidden: &TrueMotor, run: &CaseRun, conditions: Conditions) -> f64 {
    let still = Conditions {
        random_torque: RandomTorque {
            sigma: 0.0,
            ..conditions.random_torque
        },
        ..conditions
    };
    let counts: Vec<f64> = run.counts.iter().map(|&c| c as f64).collect();
    // floor(x + phi) - x has the mean phi - 1/2, where phi, the initial fraction of a count, is free in a fit: a mean
    // difference within its range is no error.
    let expected = counts_under_conditions(hidden, &run.profile, still);
    let difference: Vec<f64> = counts.iter().zip(&expected).map(|(c, e)| c - e).collect();
    let mean = difference.iter().sum::<f64>() / difference.len().max(1) as f64;
    let mean = mean.clamp(-0.5, 0.5);
    let offset = vec![mean; difference.len()];
    rms(&difference, &offset)
}

fn log_uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    rng.random_range(low.ln()..high.ln()).exp()
}
