//! Flags that describe the columns of a log.

use clap::Args;

use super::numbers::{counts_per_rev, number_in};
use crate::import::{GivenFlags, Integration};
use crate::motor::plausible;

/// Facts that the log lacks.
#[derive(Debug, Args)]
#[command(next_help_heading = "Columns of a log of another program")]
pub(super) struct Flags {
    /// The clock: its column and unit (s, ms, us, ns, min); or 10ms for rows 10 ms apart.
    #[arg(long, value_name = "COL:UNIT")]
    time: Option<String>,
    /// The command: its column and unit (pwm, percent, share, V, mV, A, mA, N m); or 7V@0.95s for 0 before and 7 V from
    /// there on; or a sum such as '2*goal-2*position:V'; or none.
    #[arg(long, value_name = "COL:UNIT", allow_hyphen_values = true)]
    command: Option<String>,
    /// Limit of the magnitude of such a sum.
    #[arg(long, value_name = "N", value_parser = positive)]
    command_limit: Option<f64>,
    /// The column that holds the direction of a command without a sign, and the number in it that is backwards; or none.
    #[arg(long, value_name = "COL:NUMBER", allow_hyphen_values = true)]
    direction: Option<String>,
    /// The position: its column and unit (counts, rev, rad, mrad, deg); or none.
    #[arg(long, value_name = "COL:UNIT")]
    position: Option<String>,
    /// The speed, where there is no position: its column and unit (rpm, rev/s, rad/s, deg/s, counts/s).
    #[arg(long, value_name = "COL:UNIT")]
    speed: Option<String>,
    /// How that speed becomes a position: backward, where it is the mean since the row before, such as a difference of positions;
    /// trapezoid, where it is the speed at the instant of the row; forward, where it holds until the next row. [default: backward
    /// where the speed comes in steps of counts; else the rule that leaves less of a first-order motor; or as the mapping says]
    #[arg(long, value_name = "RULE")]
    integrate: Option<Integration>,
    /// The measured current: its column and unit (A, mA).
    #[arg(long, value_name = "COL:UNIT")]
    current: Option<String>,
    /// The driver's supply in V, of which a PWM is a share; or the column and unit of a measured one.
    #[arg(long, value_name = "V")]
    supply: Option<String>,
    /// Counts of the encoder in one turn, all four edges counted.
    #[arg(long, value_name = "N", value_parser = counts_per_rev)]
    counts_per_rev: Option<f64>,
    /// Travel of a linear axis in one turn in m, for positions in m and mm.
    #[arg(long, value_name = "M", value_parser = positive)]
    m_per_rev: Option<f64>,
    /// The PWM that is full drive, such as 255. Values beyond it are full drive.
    #[arg(long, value_name = "N", value_parser = positive)]
    pwm_full: Option<f64>,
    /// The range after which the position restarts, in its own unit: 360, 65536.
    #[arg(long, value_name = "N", value_parser = positive)]
    wrap: Option<f64>,
    /// The position column holds the counts since the row before (readAndReset).
    #[arg(long)]
    increments: bool,
    /// The encoder counts against the command (A and B are swapped): the motion is turned round.
    #[arg(long)]
    reverse: bool,
    /// The encoder has one channel and no sign: the sign of the motion is the command's.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    unsigned: Option<bool>,
    /// Take one row of N; the command is the mean until the next.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    every: Option<u64>,
    /// Most runs that the log makes where its clock restarts. [default: 12]
    #[arg(long = "runs", value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    most_runs: Option<u64>,
}

impl Flags {
    pub fn given(&self) -> GivenFlags {
        GivenFlags {
            time: self.time.clone(),
            command: self.command.clone(),
            command_limit: self.command_limit,
            direction: self.direction.clone(),
            position: self.position.clone(),
            speed: self.speed.clone(),
            integrate: self.integrate,
            current: self.current.clone(),
            supply: self.supply.clone(),
            counts_per_rev: self.counts_per_rev,
            m_per_rev: self.m_per_rev,
            pwm_full: self.pwm_full,
            wrap: self.wrap,
            increments: self.increments,
            reverse: self.reverse,
            unsigned: self.unsigned,
            every: self.every,
            runs: self.most_runs,
        }
    }

    pub fn is_given(&self) -> bool {
        self.given() != GivenFlags::default()
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match number_in(text, plausible::SCALE)? {
        number if number > 0.0 => Ok(number),
        _ => Err("expected a number above 0\nhint: a decimal point, no unit and no thousands separator, such as 0.75".to_owned()),
    }
}
