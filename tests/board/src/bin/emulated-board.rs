//! `emulated-board`: plug in an emulated board and print its serial port; Ctrl-C unplugs it.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use emulated_board::bench::MotorShaft;
use emulated_board::board::Board;
use emulated_board::line::{Line, LineOptions, Pace};
use emulated_board::wiring::BoardKind;
use motorlab::board::faults::Faults;
use motorlab::board::pty::Pty;
use motorlab::motor::Motor;

/// The sketch on an emulated Arduino that turns a simulated motor, behind a serial port.
#[derive(Debug, Parser)]
struct CommandLine {
    /// Which board.
    #[arg(value_enum, default_value = "uno")]
    board: BoardKind,
    /// The board's time follows the wall clock's, instead of standing still while nothing happens and
    /// going as fast as it can while it records.
    #[arg(long)]
    real_time: bool,
    /// Motor file; without one the lab handout's motor.
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
    /// Write what really happened in the latest recording here, as CSV.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// The board's micros() when a recording starts.
    #[arg(long, value_name = "US")]
    micros_at_start: Option<u32>,
    /// Pull the reset line so long after START.
    #[arg(long, value_name = "SECONDS")]
    reset_after: Option<f64>,
    /// Probability that one bit of a byte flips, in both directions.
    #[arg(long, value_name = "P", default_value_t = 0.0)]
    flip: f64,
    /// Probability that a byte is lost, in both directions.
    #[arg(long, value_name = "P", default_value_t = 0.0)]
    drop: f64,
    /// Seed of flips and losses.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    match run(CommandLine::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("emulated-board: {error}");
            ExitCode::from(3)
        }
    }
}

fn run(arguments: CommandLine) -> Result<(), Box<dyn std::error::Error>> {
    let motor = match &arguments.motor {
        Some(path) => motorlab::motor::read_motor(path)?,
        None => Motor::default(),
    };
    let board = Board::new(arguments.board, MotorShaft::new(&motor)?)?;
    let pty = Pty::open()?;
    let mut output = std::io::stdout();
    writeln!(output, "{}", pty.path().display())?;
    output.flush()?;
    let faults = Faults {
        flip: arguments.flip,
        drop: arguments.drop,
        seed: arguments.seed,
        ..Faults::default()
    };
    let options = LineOptions {
        pace: if arguments.real_time {
            Pace::RealTime
        } else {
            Pace::Held
        },
        faults,
        faults_to_board: Faults {
            seed: arguments.seed.wrapping_add(1),
            ..faults
        },
        truth: arguments.truth,
        micros_at_start: arguments.micros_at_start,
        reset_after_s: arguments.reset_after,
    };
    Line::new(board, pty, options).run(&AtomicBool::new(false))?;
    Ok(())
}
