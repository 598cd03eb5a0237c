//! How long a diagnosis takes, and how that grows with the samples.
//!
//! `cargo bench --bench diagnose`; `items/s` is samples a second. `three_runs` is a step at 0.03 s, one at 0.003 s and
//! 15 s of reversing at 0.003 s, of a motor with one effect, from the generator of the blind cases; `longer` is one
//! reversing run of so many seconds. `benches/diagnose_peer.py` fits one effect to as many samples with SciPy.

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
    let sample_time_s = 0.003;
    let duration_s = f64::from(seconds);
    let samples = (duration_s / sample_time_s) as u32;
    let t_s: Vec<f64> = (0..samples).map(|k| f64::from(k) * sample_time_s).collect();
    let profile = Profile::named("reversing", 4.5, 15.0).expect("a profile");
    let command: Vec<f64> = t_s
        .iter()
        .map(|t_s| profile.command_at(t_s % 15.0))
        .collect();
    let mut truth = Motor::default();
    let effect = ActiveEffect::from_keys("stribeck", [], &truth.parameters);
    truth.effects.set(effect.expect("in the catalogue"));
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let simulated = simulate(&truth, &drive, &SimulationOptions::default()).expect("a motor");
    let run = Run {
        sample_time_s,
        counts_per_rev: 720.0,
        counts: simulated.counts,
        t_s,
        command,
        ..Run::default()
    };
    time(bencher, &[run], &Motor::default());
}

fn time(bencher: Bencher<'_, '_>, runs: &[Run], motor: &Motor) {
    let samples: usize = runs.iter().map(Run::len).sum();
    bencher
        .counter(ItemsCount::new(samples))
        .bench_local(|| black_box(diagnose(black_box(runs), motor, &Options::default()).is_ok()));
}
