//! Runs of a motor that is known, for the tests of what is inside the diagnosis.

use super::WANDER_LEVELS;
use super::candidate::Candidate;
use super::data::RunData;
use super::disturbance::Disturbance;
use super::fit::Fit;
use super::hypothesis::{Hypothesis, Member};
use super::problem::Problem;
use super::rank::Ranking;
use super::rivals::find;
use super::scales::{damping_of, largest_acceleration};
use super::shapes::{Dependence, Group};
use super::unknown::Flexible;
use super::verdict::Gap;
use crate::board::Profile;
use crate::compare::FLOOR_COUNTS;
use crate::motor::catalogue::ActiveEffect;
use crate::motor::{Drive, Motor, SimulationOptions, simulate};
use crate::recording::{CommandKind, Run};

/// The lab handout's motor with these effects, each with the values of its parameters.
pub(super) fn motor_with(effects: &[(&str, &[f64])]) -> Motor {
    let mut motor = Motor::default();
    for (id, values) in effects {
        let effect = ActiveEffect::new(id, values).expect("an effect of the catalogue");
        motor.effects.set(effect);
    }
    motor
}

/// What the encoder of such a motor counts in 15 s of levels that reverse, at 3 ms.
pub(super) fn recording(motor: &Motor) -> Run {
    let sample_time_s = 0.003;
    let profile = Profile::named("reversing", 4.5, 15.0).expect("a profile of the board");
    let t_s: Vec<f64> = (0..5000).map(|k| f64::from(k) * sample_time_s).collect();
    let command: Vec<f64> = t_s.iter().map(|&t_s| profile.command_at(t_s)).collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let counts = simulate(motor, &drive, &SimulationOptions::default())
        .expect("it can be simulated")
        .counts;
    Run {
        sample_time_s,
        counts_per_rev: 720.0,
        supply_v: Some(4.5),
        complete: true,
        t_s,
        command,
        counts,
        ..Run::default()
    }
}

/// The same ready for the likelihood.
pub(super) fn ready(run: &Run) -> Vec<RunData> {
    vec![RunData::new(run, 0).expect("it can be simulated")]
}

/// These runs beside the lab handout's motor.
pub(super) fn problem<'a>(nominal: &'a Motor, runs: &'a [RunData]) -> Problem<'a> {
    let scale = largest_acceleration(nominal, runs);
    let levels = WANDER_LEVELS.map(|share| share * scale).to_vec();
    let damping = damping_of(nominal, CommandKind::Voltage);
    Problem::new(nominal, runs, damping, levels, Disturbance::default())
}

/// Place of an effect in the catalogue.
pub(super) fn index(id: &str) -> usize {
    find(id).expect("an effect of the catalogue").0
}

/// The fit of these effects from these values.
pub(super) fn fit(problem: &Problem<'_>, effects: &[(&str, &[f64])]) -> Fit {
    let (hypothesis, start) = start(problem, effects);
    (problem.fit(&hypothesis, &start, 10)).expect("it can be simulated")
}

/// The same with all numbers as they are given, on the weakest wander.
pub(super) fn held_at(problem: &Problem<'_>, effects: &[(&str, &[f64])]) -> Fit {
    let (hypothesis, start) = start(problem, effects);
    let weakest = problem.levels[problem.levels.len() - 1];
    (problem.fit_at(&hypothesis, &start, weakest, 0)).expect("it can be simulated")
}

fn start(problem: &Problem<'_>, effects: &[(&str, &[f64])]) -> (Hypothesis, Vec<f64>) {
    let member = |(id, values): &(&str, &[f64])| Member {
        index: index(id),
        values: values.to_vec(),
    };
    let members = effects.iter().map(member).collect();
    let hypothesis = Hypothesis::new(problem.nominal, members, &problem.setting);
    let start = hypothesis.start();
    (hypothesis, start)
}

/// These sets and something unknown, of which nothing else is known.
pub(super) fn ranking(candidates: Vec<Candidate>, unknown: f64) -> Ranking {
    Ranking {
        candidates,
        unknown,
        flexible: Flexible {
            log_gain: 0.0,
            group: Group::Smooth(Dependence::Time),
            size: 1.0,
            wander: 0.0,
            gains: Vec::new(),
            gain_of_large: 0.0,
        },
        unknown_gain: 0.0,
        jumps: 0.0,
        beside: Vec::new(),
        imitated: Vec::new(),
    }
}

/// A gap of a hundred counts, of which refitting leaves 50 and the best set so many.
pub(super) fn gap(after_effect: f64) -> Gap {
    Gap {
        metric: "position_rmse_counts",
        floor: FLOOR_COUNTS,
        before: 100.0,
        after_parameters: 50.0,
        after_effect,
        closed: 1.0 - (after_effect - FLOOR_COUNTS) / (100.0 - FLOOR_COUNTS),
        closed_lo95: 0.0,
        closed_hi95: 1.0,
        closed_deviation: 0.0,
        rungs95: [(0.0, 100.0); 3],
        held_out: String::new(),
    }
}
