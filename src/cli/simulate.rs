//! `motorlab simulate`: the handout's models of the motor, driven by a profile.

use std::f64::consts::TAU;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::capture::capture_failure;
use super::motor_choice::MotorChoice;
use super::numbers::{duration_s, sample_time_s};
use super::output_file::{Force, Form};
use super::picture::on_terminal;
use super::progress::{set_share, spinner};
use super::staged::Staged;
use super::threads::Threads;
use super::{Failure, Output, Status};
use crate::board::Profile;
use crate::motor::{Drive, Motor, SimulationOptions, Trajectory, simulate_reporting};
use crate::plain::shown;
use crate::recording::{CommandKind, Run, difference_velocities, write_run};
use crate::report::{Figure, Panel, Series, Size, Stroke, svg};
use crate::units::rpm_from_rad_s;

/// Simulate the motor through a profile: true speed, and what encoder, sampling and difference make of it.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab simulate --ts 0.03 --duration 2\n  motorlab simulate --model first-order --no-coulomb --ts 0.003 --duration 0.6\n  motorlab simulate --motor motor.toml --profile reversing --duration 15 -o simulated.csv"
)]
pub struct Simulate {
    #[command(flatten)]
    motor: MotorChoice,
    /// Sample time in s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.003, value_parser = sample_time_s)]
    ts: f64,
    /// Command: a built-in profile, or a file of rows `t_s,command_v`.
    #[arg(long, default_value = "step")]
    profile: String,
    /// How long in s. [default: 2, or as long as the profile's file or name says]
    #[arg(long, value_name = "SECONDS", value_parser = duration_s)]
    duration: Option<f64>,
    /// Unit of the profile: volts, or amperes or newton metres of an axis that controls them.
    #[arg(long, value_enum, default_value_t = Kind::V)]
    command: Kind,
    /// Seed of random effects (lost edges, late samples).
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the simulated run. An existing file is not overwritten, unless with --force: the next free name is taken.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the picture as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Quantity that the profile commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    /// Volts.
    V,
    /// Amperes.
    A,
    /// Newton metres.
    Nm,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    shape: &'static str,
    model: &'static str,
    sample_time_s: f64,
    counts_per_rev: f64,
    steady_speed_rpm: f64,
    t_s: &'a [f64],
    command: &'a [f64],
    angle_rad: &'a [f64],
    speed_rad_s: &'a [f64],
    current_a: &'a [f64],
    counts: &'a [i64],
    velocity_rad_s: &'a [Option<f64>],
}

/// Default duration in s: the lab's step and a second of steady speed.
const DURATION_S: f64 = 2.0;
/// Most samples of a simulation: 160 bytes each, 480 MB in all.
const MOST_SAMPLES: f64 = 3e6;
/// Most samples with a printed document, which takes more than as much again.
const MOST_PRINTED: f64 = 1e6;

impl Simulate {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        let profile = PathBuf::from(&self.profile);
        let inputs = self.motor.file().into_iter();
        let inputs = inputs.chain(profile.is_file().then_some(&profile));
        let outputs = self.force.outputs("simulate", inputs);
        outputs.check(&self.svg)?;
        let motor = self.motor.motor(output)?;
        let run = self.commanded(&motor, output.json)?;
        let drive = Drive {
            t_s: &run.t_s,
            command: &run.command,
            kind: run.command_kind,
        };
        let options = SimulationOptions {
            model: self.motor.model(),
            seed: self.seed,
            ..SimulationOptions::default()
        };
        let spinner = spinner();
        let samples = run.t_s.len();
        spinner.set_message(format!("simulating {samples} samples"));
        let done = |simulated| set_share(&spinner, simulated as f64 / samples as f64);
        let trajectory = simulate_reporting(&motor, &drive, &options, &done);
        spinner.finish_and_clear();
        let trajectory = trajectory.map_err(Failure::input)?;
        let run = Run {
            velocity_rad_s: Some(difference_velocities(
                &trajectory.counts,
                None,
                run.counts_per_rev,
                run.sample_time_s,
            )),
            counts: trajectory.counts.clone(),
            ..run
        };
        if let Some(path) = &self.output {
            let staged = Staged::of(self.force, &outputs, path)?;
            let target = staged.as_ref().map_or(path, |staged| staged.run());
            let mut written = write_run(&run, target).map_err(capture_failure)?;
            if let Some(staged) = &staged {
                staged.take_place(&outputs, [&mut written])?;
            }
            output.message(&format!("wrote {}", shown(&written)));
        }
        let figure = self.figure(&run, &trajectory);
        if let Some(path) = &self.svg {
            outputs.write(
                path,
                &svg::document(&figure, Size::PAGE),
                Form::Markup,
                output,
            )?;
        }
        let steady = trajectory.speed_rad_s.last().copied().unwrap_or(0.0);
        if output.json {
            output.document(&Document {
                shape: "motorlab-simulation/1",
                model: self.motor.words(),
                sample_time_s: run.sample_time_s,
                counts_per_rev: run.counts_per_rev,
                steady_speed_rpm: rpm_from_rad_s(steady),
                t_s: &run.t_s,
                command: &run.command,
                angle_rad: &trajectory.angle_rad,
                speed_rad_s: &trajectory.speed_rad_s,
                current_a: &trajectory.current_a,
                counts: &run.counts,
                velocity_rad_s: run.velocity_rad_s.as_deref().unwrap_or_default(),
            })?;
        } else {
            for panel in &figure.panels[..1] {
                output.picture(&on_terminal(panel, &figure.x_label))?;
            }
            output.line(&format!(
                "{}: {:.3} RPM ({:.4} rad/s) at the end; one count in one sample is {:.2} RPM",
                self.motor.words(),
                rpm_from_rad_s(steady),
                steady,
                rpm_from_rad_s(TAU / run.counts_per_rev / run.sample_time_s),
            ))?;
        }
        Ok(Status::Done)
    }

    /// The run before its simulation: times and commands.
    fn commanded(&self, motor: &Motor, prints: bool) -> Result<Run, Failure> {
        let parameters = &motor.parameters;
        let built_in_s = self.duration.unwrap_or(DURATION_S);
        let profile = Profile::named(&self.profile, parameters.supply_v, built_in_s)
            .map_err(Failure::input)?;
        // A file with one row has no duration.
        let own_s = Some(profile.duration_s()).filter(|s| *s > 0.0);
        let duration_s = self.duration.or(own_s).unwrap_or(DURATION_S);
        let samples = (duration_s / self.ts).round() + 1.0;
        let most = if prints { MOST_PRINTED } else { MOST_SAMPLES };
        if samples > most {
            return Err(Failure::wrong(
                format!(
                    "{samples:.0} samples are too many, {most:.0} are the most that fit 500 MB of memory"
                ),
                "lower --duration or raise --ts",
            ));
        }
        let samples = samples as usize;
        let mut run = Run {
            sample_time_s: self.ts,
            counts_per_rev: parameters.counts_per_rev,
            supply_v: Some(parameters.supply_v),
            command_kind: match self.command {
                Kind::V => CommandKind::Voltage,
                Kind::A => CommandKind::Current,
                Kind::Nm => CommandKind::Torque,
            },
            t_s: (0..samples).map(|k| k as f64 * self.ts).collect(),
            command: profile.commands(self.ts, samples),
            complete: true,
            ..Run::default()
        };
        run.header.insert("profile".into(), profile.name.into());
        run.header.insert("simulated".into(), true.into());
        run.header.insert("model".into(), self.motor.words().into());
        Ok(run)
    }

    fn figure(&self, run: &Run, trajectory: &Trajectory) -> Figure {
        let rpm = |speeds: &[f64]| {
            speeds
                .iter()
                .map(|&w| rpm_from_rad_s(w))
                .collect::<Vec<f64>>()
        };
        let encoder: Vec<f64> = run
            .velocity_rad_s
            .iter()
            .flatten()
            .map(|speed| speed.map_or(f64::NAN, rpm_from_rad_s))
            .collect();
        let speed = vec![
            Series::new(
                "by encoder and difference",
                Stroke::Step,
                0,
                &run.t_s,
                &encoder,
            ),
            Series::new(
                "true speed",
                Stroke::Line,
                1,
                &run.t_s,
                &rpm(&trajectory.speed_rad_s),
            ),
        ];
        let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
        let position = Series::new("", Stroke::Step, 0, &run.t_s, &counts);
        let command = Series::new("", Stroke::Step, 2, &run.t_s, &run.command);
        Figure {
            title: format!("Simulated motor, {}", self.motor.words()),
            x_label: "time (s)".to_owned(),
            panels: vec![
                Panel::new("speed (RPM)", speed).weighing(2.0),
                Panel::new("position (counts)", vec![position]),
                Panel::new(run.command_kind.column(), vec![command]).weighing(0.6),
            ],
        }
    }
}
