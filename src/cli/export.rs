//! `motorlab export`: a motor or a run in other programs' formats.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use serde_json::{Value, json};

use super::export_actuator::{ActuatorFile, wrote_actuator};
use super::export_run::RunFile;
use super::foreign::unreadable;
use super::motor_file::motor_file;
use super::output_file::{Force, Form, Outputs};
use super::resistance::Resistance;
use super::{Failure, Output, Status};
use crate::export::actuator;
use crate::export::{json, mat5, matlab, mujoco, urdf};
use crate::hint::{In, parted};
use crate::motor::Motor;
use crate::plain::shown;
use crate::recording::{Run, read_run};

/// Write a motor for MATLAB, MuJoCo, URDF, JSON, or with its effects as code; or a run for MATLAB, Parquet, MCAP.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab export matlab --motor motor.toml --run step3.csv -o matlab\n  motorlab export mujoco --motor motor.toml -o motor.xml\n  motorlab export urdf --motor diagnosed.toml --leave-out\n  motorlab export json\n  motorlab export c --motor diagnosed.toml -o motor.c\n  motorlab export mcap run.csv"
)]
pub struct Export {
    #[command(subcommand)]
    format: Format,
}

/// Format to write.
#[derive(Debug, Subcommand)]
enum Format {
    Matlab(Matlab),
    Mujoco(Mujoco),
    Urdf(Urdf),
    Json(Json),
    /// The motor with its effects as a C function, motor_step(state, voltage) -> torque.
    C(ActuatorFile),
    /// The motor with its effects as a plain Python function, step(state, voltage) -> torque.
    Python(ActuatorFile),
    /// The motor with its effects as motor_step.m for MATLAB, Simulink and Octave.
    Octave(ActuatorFile),
    /// The motor with its effects as an actuator class of Isaac Lab that imports only torch.
    IsaacLab(ActuatorFile),
    /// A run as a Parquet file, for pandas, DuckDB, PlotJuggler.
    Parquet(RunFile),
    /// A run as an MCAP file, for Foxglove and PlotJuggler.
    Mcap(RunFile),
}

impl Export {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        match &self.format {
            Format::Matlab(format) => format.run(output),
            Format::Mujoco(format) => format.run(output),
            Format::Urdf(format) => format.run(output),
            Format::Json(format) => format.run(output),
            Format::C(file) => file.run("c", actuator::Target::C, output),
            Format::Python(file) => file.run("python", actuator::Target::Python, output),
            Format::Octave(file) => file.run("octave", actuator::Target::Octave, output),
            Format::IsaacLab(file) => file.run("isaac-lab", actuator::Target::IsaacLab, output),
            Format::Parquet(run) => wrote("parquet", &[run.parquet(output)?], None, output),
            Format::Mcap(run) => wrote("mcap", &[run.mcap(output)?], None, output),
        }
    }
}

/// Motor_Parameters.m in the lab handout's names, and runs as MAT-files (version 5).
#[derive(Debug, Args)]
struct Matlab {
    #[command(flatten)]
    motor: MotorFile,
    /// A run to be written as NAME.mat; may be given several times.
    #[arg(long = "run", value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Folder for the files.
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

/// A MuJoCo model (MJCF): a hinge with armature, damping and frictionloss, and a general actuator in volts.
#[derive(Debug, Args)]
struct Mujoco {
    #[command(flatten)]
    motor: MotorFile,
    #[command(flatten)]
    target: Target,
    /// Python module to write beside the model: MuJoCo calls it for the motor's torque, with all of its effects.
    #[arg(
        long,
        value_name = "FILE",
        requires = "output",
        conflicts_with = "leave_out"
    )]
    callback: Option<PathBuf>,
}

/// A URDF joint with <dynamics>, its inertia and limits.
#[derive(Debug, Args)]
struct Urdf {
    #[command(flatten)]
    motor: MotorFile,
    #[command(flatten)]
    target: Target,
}

/// All parameters and effects with units and equations as JSON.
#[derive(Debug, Args)]
struct Json {
    #[command(flatten)]
    motor: MotorFile,
    /// File to write; without it the document goes to standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// Which motor.
#[derive(Debug, Args)]
pub(super) struct MotorFile {
    /// Motor file; without it the lab handout's motor.
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
    #[command(flatten)]
    resistance: Resistance,
}

/// Where a model goes, and what may be missing in it.
#[derive(Debug, Args)]
struct Target {
    /// File to write; without it the model goes to standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Leave out effects that the format cannot express, and name them in the file's comment.
    #[arg(long)]
    leave_out: bool,
    #[command(flatten)]
    force: Force,
}

impl MotorFile {
    /// The motor file, if one is given.
    pub(super) fn path(&self) -> &Option<PathBuf> {
        &self.motor
    }

    pub(super) fn read(&self, output: &Output) -> Result<Motor, Failure> {
        let motor = match &self.motor {
            Some(path) => motor_file(path, output)?,
            None => {
                output.message("no --motor: the lab handout's motor is exported");
                Motor::default()
            }
        };
        let motor = self.resistance.of(motor);
        for line in motor.assumptions() {
            output.message(&line);
        }
        Ok(motor)
    }
}

impl Matlab {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        let inputs = self.runs.iter().chain(&self.motor.motor);
        let outputs = self.force.outputs("export", inputs);
        let mut files = vec![self.output.join(matlab::FILE_NAME)];
        for path in &self.runs {
            let mut name = path.file_stem().unwrap_or(path.as_os_str()).to_owned();
            name.push(".mat");
            let file = self.output.join(name);
            if files.contains(&file) {
                return Err(Failure::wrong(
                    format!("two of the runs would both become {}", shown(&file)),
                    "rename one of them, or export them into two folders with -o",
                ));
            }
            files.push(file);
        }
        for file in &files {
            outputs.may_replace(file, None)?;
        }
        let motor = self.motor.read(output)?;
        let runs = self.read_runs(output)?;
        std::fs::create_dir_all(&self.output).map_err(|error| {
            Failure::device(In::new(
                format!("cannot make {}", shown(&self.output)),
                error,
            ))
        })?;
        outputs.check(&files)?;
        outputs.write_silently(&files[0], &matlab::script(&motor), Form::Matlab)?;
        for (file, run) in files[1..].iter().zip(&runs) {
            let content = mat5::of_run(run).map_err(Failure::input)?;
            outputs.write_bytes(file, &content, None)?;
        }
        wrote("matlab", &files, Some(&motor), output)
    }

    /// Reads every run before the first file is written.
    fn read_runs(&self, output: &Output) -> Result<Vec<Run>, Failure> {
        let mut runs = Vec::new();
        for path in &self.runs {
            let (run, notes) = read_run(path).map_err(|error| unreadable(path, error))?;
            for note in notes {
                output.message(&format!("{}: {note}", shown(path)));
            }
            runs.push(run);
        }
        Ok(runs)
    }
}

impl Mujoco {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        let outputs = self.target.outputs(&self.motor)?;
        outputs.check(self.target.output.iter().chain(&self.callback))?;
        let motor = self.motor.read(output)?;
        if let (Some(model), Some(module)) = (&self.target.output, &self.callback) {
            actuator::check(&motor, mujoco::TIME_STEP_S).map_err(Failure::input)?;
            let text = mujoco::called_model(&motor, &shown(module));
            outputs.write_silently(model, &text, Form::Markup)?;
            let text = actuator::Target::Mujoco.file(&motor, mujoco::TIME_STEP_S);
            outputs.write_silently(module, &text, Form::Toml)?;
            return wrote_actuator("mujoco", &[model, module], None, &motor, output);
        }
        let model = mujoco::model(&motor, self.target.leave_out).map_err(|error| {
            let error = error.to_string();
            let (what, hint) = parted(&error);
            Failure::wrong(
                what,
                format!(
                    "--callback motor.py writes a Python module that MuJoCo calls for all of the motor's effects; {}",
                    hint.unwrap_or_default()
                ),
            )
        })?;
        self.target
            .write("mujoco", &outputs, &model, &motor, output)
    }
}

impl Urdf {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        let outputs = self.target.outputs(&self.motor)?;
        let motor = self.motor.read(output)?;
        let model = urdf::model(&motor, self.target.leave_out).map_err(Failure::input)?;
        self.target.write("urdf", &outputs, &model, &motor, output)
    }
}

impl Json {
    fn run(&self, output: &Output) -> Result<Status, Failure> {
        let outputs = self.force.outputs("export", &self.motor.motor);
        outputs.check(&self.output)?;
        let motor = self.motor.read(output)?;
        let document = json::document(&motor);
        let Some(path) = &self.output else {
            output.document(&document)?;
            return Ok(Status::Done);
        };
        let text = output.in_json(&document)?;
        outputs.write_silently(path, &text, Form::Json)?;
        wrote("json", std::slice::from_ref(path), Some(&motor), output)
    }
}

impl Target {
    /// The output file, refused before the work if it could not be written after it.
    fn outputs(&self, motor: &MotorFile) -> Result<Outputs, Failure> {
        let outputs = self.force.outputs("export", &motor.motor);
        outputs.check(&self.output)?;
        Ok(outputs)
    }

    fn write(
        &self,
        format: &str,
        outputs: &Outputs,
        model: &str,
        motor: &Motor,
        output: &Output,
    ) -> Result<Status, Failure> {
        match &self.output {
            Some(path) => {
                outputs.write_silently(path, model, Form::Markup)?;
                wrote(format, std::slice::from_ref(path), Some(motor), output)
            }
            None if output.json => {
                let mut document = document(format, Vec::new(), Some(motor));
                document["text"] = model.into();
                output.document(&document)?;
                Ok(Status::Done)
            }
            None => {
                output.line(model.trim_end())?;
                Ok(Status::Done)
            }
        }
    }
}

/// The JSON document of an export: files, and assumed parameters of the motor.
pub(super) fn document(format: &str, files: Vec<&Path>, motor: Option<&Motor>) -> Value {
    let mut document = json!({
        "shape": "motorlab-export/1",
        "format": format,
        "files": files,
    });
    let assumed = motor.map(Motor::assumptions).unwrap_or_default();
    if !assumed.is_empty() {
        document["assumed"] = assumed.into();
    }
    document
}

fn wrote(
    format: &str,
    files: &[PathBuf],
    motor: Option<&Motor>,
    output: &Output,
) -> Result<Status, Failure> {
    if output.json {
        let files = files.iter().map(PathBuf::as_path).collect();
        output.document(&document(format, files, motor))?;
    } else {
        for file in files {
            output.line(&format!("wrote {}", shown(file)))?;
        }
    }
    Ok(Status::Done)
}
