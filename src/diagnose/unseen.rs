//! What runs cannot show, whether it is there or not: effects that would act in hardly any of their samples.
//!
//! Said where a diagnosis does not come to one answer, so that silence on an effect is not taken for its absence.

use super::data::RunData;
use super::rivals::find;
use super::setting::skips_turns;
use super::verdict::DataProblem;
use crate::recording::CommandKind;

/// An effect that acts in a smaller share of the samples does not show.
const SHOWS: f64 = 0.01;
/// Of a turn: less of one is too little of what repeats with the angle. A pendulum's weight shows in a tenth.
const LEAST_TURN: f64 = 0.02;

/// The effects that these runs cannot show, each with why.
pub(super) fn unseen(runs: &[RunData]) -> Vec<DataProblem> {
    let share = |acts: &dyn Fn(&RunData, usize) -> bool, of: &dyn Fn(&RunData, usize) -> bool| {
        let (mut some, mut all) = (0_u32, 0_u32);
        for run in runs {
            for k in (0..run.len()).filter(|&k| of(run, k)) {
                all += 1;
                some += u32::from(acts(run, k));
            }
        }
        f64::from(some) / f64::from(all.max(1))
    };
    let mut found = Vec::new();
    let mut say = |effects: &str, why: String| {
        found.push(DataProblem {
            run: "all runs".to_owned(),
            problem: "cannot_show".to_owned(),
            detail: format!("{effects}: {why}; these runs cannot show it"),
        });
    };
    let is_voltage = runs.iter().all(|run| run.kind == CommandKind::Voltage);
    let widest = find("dead_zone").and_then(|(_, kind)| kind.parameters.first().map(|p| p.hi));
    if let (true, Some(widest)) = (is_voltage, widest) {
        let inside = |run: &RunData, k: usize| {
            let command = run.command[k].abs();
            command > 0.0 && command <= widest
        };
        let acts = share(&inside, &|_, _| true);
        if acts < SHOWS {
            say(
                "dead zone",
                format!(
                    "the command is between 0 and {widest} V in {:.1} % of the samples",
                    100.0 * acts
                ),
            );
        }
        let coasts = |run: &RunData, k: usize| run.moving[k] && run.command[k] == 0.0;
        if share(&coasts, &|_, _| true) < SHOWS {
            say(
                "coasting at no command",
                "the shaft hardly ever moves without one".to_owned(),
            );
        }
    }
    let moves = |run: &RunData, k: usize| run.moving[k];
    let forward = share(&|run, k| run.speed_counts_s[k] > 0.0, &moves);
    if forward.min(1.0 - forward) < SHOWS {
        say(
            "friction that differs by direction",
            "the shaft turns one way only".to_owned(),
        );
    }
    let turns = runs.iter().map(|run| {
        let (lo, hi) = run
            .counts
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), n| {
                (lo.min(*n), hi.max(*n))
            });
        (hi - lo) / run.counts_per_rev
    });
    let turned = turns.fold(0.0, f64::max);
    if turned < LEAST_TURN {
        say(
            "gravity, cogging, eccentricity",
            format!("the shaft turns by {turned:.2} of a turn at most"),
        );
    }
    if skips_turns(runs) {
        say(
            "gravity, cogging, ripple, eccentricity",
            "the shaft passes whole turns from one sample to the next".to_owned(),
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Run;

    fn said(command: impl Fn(u32) -> f64, counts: impl Fn(u32) -> i64) -> String {
        let run = Run {
            sample_time_s: 0.005,
            counts_per_rev: 720.0,
            t_s: (0..400).map(|k| f64::from(k) * 0.005).collect(),
            command: (0..400).map(&command).collect(),
            counts: (0..400).map(&counts).collect(),
            ..Run::default()
        };
        let data = RunData::new(&run, 0).expect("a run");
        let found = unseen(&[data]).into_iter();
        found.map(|found| found.detail + "\n").collect()
    }

    #[test]
    fn a_step_in_one_direction_cannot_show_a_dead_zone() {
        let said = said(|_| 4.5, |k| i64::from(k) * 3);
        assert!(
            said.contains("dead zone: the command is between 0 and 1.5 V in 0.0 %"),
            "{said}"
        );
        assert!(said.contains("one way only"), "{said}");
        assert!(!said.contains("gravity"), "{said}");
    }

    #[test]
    fn whole_turns_between_samples_hide_what_repeats_with_the_angle() {
        let hidden = "passes whole turns from one sample to the next; these runs cannot show it";
        assert!(said(|_| 4.5, |k| i64::from(k) * 800).contains(hidden));
        assert!(!said(|_| 4.5, |k| i64::from(k) * 600).contains(hidden));
    }

    #[test]
    fn a_ramp_through_nought_and_back_can() {
        let command = |k: u32| 4.5 * (f64::from(k) / 200.0 * std::f64::consts::PI).sin();
        let said = said(command, |k| {
            (300.0 * (f64::from(k) / 200.0 * std::f64::consts::PI).cos()) as i64
        });
        assert!(!said.contains("dead zone"), "{said}");
        assert!(!said.contains("one way"), "{said}");
    }
}
