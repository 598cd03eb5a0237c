//! Computing time of a diagnosis as a function of the number of samples.
//!
//! `cargo bench --bench diagnose`; `items/s` is samples per second. `three_runs` is a step at 0.03 s, one at 0.003 s
//! and 15 s of reversing at 0.003 s, of a motor with one effect, from the generator of the blind cases; `longer` is
//! one reversing run of the given length in s, `hours` one of 1.2 million samples. `benches/diagnose_peer.py` fits
//! one effect to as many samples with SciPy.

use case_generator::generate;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use motorlab::board::Profile;
use motorlab::diagnose::{Options, diagnose};
use motorlab::motor::{ActiveEffect, Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::{CommandKind, Run, read_run_from};

fn main() {
    divan::main();
}

#[divan::bench(args = ["none", "stribeck", "torque_ripple", "backlash+viscous_friction"], sample_count = 3)]
fn three_runs(bencher: Bencher<'_, '_>, kind: &str) {
    let case = generate(1, &kind.parse().expect("a kind of case"));
    let motor = Motor::from_toml(&case.nominal.to_toml()).expect("the generator's motor");
    let runs: Vec<Run> = case
        .runs
        .iter()
        .map(|run| {
            read_run_from(run.to_csv().as_bytes(), "case")
                .expect("the generator's run")
                .0
        })
        .collect();
    time(bencher, &runs, &motor);
}

#[divan::bench(args = [15, 30, 60, 120], sample_count = 1)]
fn longer(bencher: Bencher<'_, '_>, seconds: u32) {
    let profile = Profile::named("reversing", 4.5, 15.0).expect("a profile");
    let samples = (f64::from(seconds) / 0.003) as usize;
    let command_at = |t_s: f64| profile.command_at(t_s % 15.0);
    let run = recording("stribeck", (0.003, samples), command_at);
    time(bencher, &[run], &Motor::default());
}

/// An hour at 3 ms and ten at 30 ms, with levels of which 2 % are within a dead zone.
#[divan::bench(args = [0.003, 0.03], sample_count = 1)]
fn hours(bencher: Bencher<'_, '_>, sample_time_s: f64) {
    let samples = 1_200_000;
    let large = [4.5, 2.0, -3.0, 3.0, -4.5, -2.0, 3.7, -2.5];
    let small = [0.5, 1.2, 0.7, -0.4, -1.1, 0.9, -0.8, 0.3];
    let lasts_s = samples as f64 * sample_time_s;
    let level = |t_s: f64| {
        let levels = match (0.66..0.68).contains(&(t_s / lasts_s)) {
            true => small,
            false => large,
        };
        levels[(t_s / 0.7) as usize % 8]
    };
    let run = recording("dead_zone", (sample_time_s, samples), level);
    time(bencher, &[run], &Motor::default());
}

/// The handout's motor with an effect under a command.
fn recording(
    effect: &str,
    (sample_time_s, samples): (f64, usize),
    command_at: impl Fn(f64) -> f64,
) -> Run {
    let t_s: Vec<f64> = (0..samples).map(|k| k as f64 * sample_time_s).collect();
    let command: Vec<f64> = t_s.iter().map(|t_s| command_at(*t_s)).collect();
    let mut truth = Motor::default();
    let effect = ActiveEffect::from_keys(effect, [], &truth.parameters);
    truth.effects.set(effect.expect("in the catalogue"));
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let simulated = simulate(&truth, &drive, &SimulationOptions::default()).expect("a motor");
    Run {
        sample_time_s,
        counts_per_rev: 720.0,
        counts: simulated.counts,
        t_s,
        command,
        ..Run::default()
    }
}

fn time(bencher: Bencher<'_, '_>, runs: &[Run], motor: &Motor) {
    let samples: usize = runs.iter().map(Run::len).sum();
    bencher
        .counter(ItemsCount::new(samples))
        .bench_local(|| black_box(diagnose(black_box(runs), motor, &Options::default()).is_ok()));
}
