//! Part 3: effects that the recordings would not show, had the motor them at a typical magnitude.

use std::collections::BTreeMap;

use crate::board::{Profile, Segment};
use crate::diagnose::{Diagnosis, Plan, isolability};
use crate::motor::{CommandKind, Motor};
use crate::recording::Run;

/// Separation from the model without effects, in standard deviations, from which an effect can be identified: its logarithmic likelihood
/// ratio of 12.5 outweighs the prior odds of one effect of the catalogue and the free parameters.
const IDENTIFIED_FROM: f64 = 5.0;
/// Most samples of a recording of which this is computed: each of the catalogue's effects is simulated some times on it.
const MOST_SAMPLES: usize = 20_000;

/// Ids of the effects that these recordings of the motor do not show together, in the order of the catalogue, beside those that the diagnosis
/// names; none where it is not computed.
pub fn not_shown(motor: &Motor, runs: &[Run], diagnosis: &Diagnosis) -> Vec<&'static str> {
    let is_planned =
        |run: &Run| run.command_kind == CommandKind::Voltage && run.len() <= MOST_SAMPLES;
    if runs.is_empty() || !runs.iter().all(is_planned) {
        return Vec::new();
    }
    let mut squares: BTreeMap<&'static str, f64> = BTreeMap::new();
    let mut order = Vec::new();
    for run in runs {
        let mut motor = motor.clone();
        motor.parameters.counts_per_rev = run.counts_per_rev;
        motor.parameters.supply_v = run.supply_v.unwrap_or(motor.parameters.supply_v);
        let Some(found) = isolability(&motor, &plan(run), &|_| ()) else {
            return Vec::new();
        };
        // The first is the model without effects.
        for (k, effect) in found.effects.iter().enumerate().skip(1) {
            *squares.entry(effect).or_default() += found.between(k, 0).powi(2);
        }
        order = found.effects;
    }
    let of_classes = diagnosis
        .classes
        .iter()
        .flat_map(|class| class.members.iter());
    let named: Vec<&str> = diagnosis
        .effects
        .iter()
        .chain(of_classes)
        .copied()
        .collect();
    let is_hidden = |effect: &&'static str| {
        squares
            .get(effect)
            .is_some_and(|square| square.sqrt() < IDENTIFIED_FROM)
    };
    (order.into_iter())
        .filter(|effect| is_hidden(effect) && !named.contains(effect))
        .collect()
}

/// The recording as a plan: its commands, one after the other.
fn plan(run: &Run) -> Plan {
    let mut segments: Vec<Segment> = Vec::new();
    for (k, &command) in run.command.iter().enumerate() {
        let next = run.t_s.get(k + 1).copied();
        let duration_s = next.map_or(run.sample_time_s, |next| next - run.t_s[k]);
        match segments.last_mut() {
            Some(last) if last.command == command => last.duration_s += duration_s,
            _ => segments.push(Segment {
                duration_s,
                command,
            }),
        }
    }
    Plan {
        duration_s: segments.iter().map(|segment| segment.duration_s).sum(),
        profile: Profile {
            name: "recorded".to_owned(),
            segments,
        },
        sample_time_s: run.sample_time_s,
    }
}

/// In words, for the answer; empty where all effects would be shown. `reverses`: one of the recordings is driven in both directions.
pub fn words(effects: &[&str], reverses: bool) -> String {
    if effects.is_empty() {
        return String::new();
    }
    let names: Vec<String> = effects.iter().map(|id| id.replace('_', " ")).collect();
    let hint = match reverses {
        true => "",
        false => " hint: record with --profile reversing too, for more of them.",
    };
    format!(
        " At a typical magnitude these recordings do not show: {}.{hint}",
        names.join(", ")
    )
}
