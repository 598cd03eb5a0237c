//! What the plausible values of effects depend on besides the motor: the command, the sample times, the clocks.
//!
//! A range in multiples of the sample time spans those of all runs. Of an axis that is driven by current or torque the
//! runs' largest command and top speed stand for stall and no load, which a supply does not set there; where the
//! friction is hardly known, a load may be as large as the torque at stall. Where the host stamped arrivals, the board's
//! clock is known: its error is `e = d(host - board)/d(board)`, between the earliest arrivals of the first and of
//! the last tenth, good to a millisecond over the run (`s`) and to the host's own clock. What the host saw, `o`, is
//! evidence: its density is `N(o; 0, s^2 + h^2)` of an ordinary clock, and that of the effect, even in the logarithm from
//! 0.1 to 10 % on both sides, of one that is off. Where arrivals are all
//! the time there is, nothing that shows in the timing alone can be told from the line's own. Where the shaft passes whole
//! turns from one sample to the next, what repeats with the angle has come and gone between them.

use super::checks::WIDEST_CLOCK;
use super::data::RunData;
use super::held;
use crate::motor::catalogue::{EffectKind, EffectParameter, Scale, Stage};
use crate::motor::{Motor, Parameters};
use crate::recording::CommandKind;

/// Standard deviation of an ordinary clock's error: from twice this on it is the effect's (`clock_error` begins at 0.1 %).
const ORDINARY_CLOCK: f64 = 0.0005;
/// The same of the host's (a computer's crystal).
const HOST_CLOCK: f64 = 5e-5;
/// Key of the limit of the edge rate, and its range as shares of the fastest edges that were counted.
pub(super) const MAX_RATE: &str = "max_rate_hz";
const LIMITS: (f64, f64) = (0.7, 1.5);
/// Smallest and largest error of a clock that is off.
const CLOCK_OFF: (f64, f64) = (0.001, 0.1);
/// Scatter in s of the earliest arrivals.
const ARRIVAL_S: f64 = 0.001;
/// Friction that is known no better than this, relative, is no measure of a load.
const UNKNOWN: f64 = 0.5;
/// Effects that repeat with the angle, and the turns from one sample to the next, half of the time in which the shaft
/// moves, from which on nothing is seen of them.
const PERIODIC: [&str; 4] = [
    "torque_ripple",
    "gravity_load",
    "cogging",
    "encoder_eccentricity",
];
const WHOLE_TURNS: f64 = 1.0;
/// Most that an unexplained clock speaks against a hypothesis, in nats.
const MOST_NATS: f64 = 50.0;

/// The setting of all runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    /// What is commanded.
    pub kind: CommandKind,
    /// Shortest and longest sample time in s.
    sample_times_s: (f64, f64),
    /// The clock's error as the host saw it, and its standard deviation.
    clock: Option<(f64, f64)>,
    /// All runs are timed by their arrival at the host.
    host_timed: bool,
    /// Fastest edges that were counted, in 1/s, smoothed.
    fastest_hz: f64,
    /// Size of the largest command.
    largest_command: f64,
    /// Top speed in rad/s.
    top_speed_rad_s: f64,
    /// The motor file hardly knows the friction.
    is_friction_unknown: bool,
    /// The shaft passes whole turns between samples.
    skips_turns: bool,
    /// The largest angle that the shaft of one run covers, in turns.
    pub travel_turns: f64,
    /// The axis is held by its controller.
    pub is_held: bool,
}

impl Setting {
    /// Of these runs of this motor.
    pub fn new(nominal: &Motor, runs: &[RunData]) -> Self {
        let times = || runs.iter().map(|run| run.sample_time_s);
        let longest = times().fold(0.0, f64::max);
        let mut weights = 0.0;
        let mut sum = 0.0;
        for (error, span_s) in runs.iter().filter_map(|run| run.clock) {
            if error.abs() < WIDEST_CLOCK {
                let weight = (span_s / ARRIVAL_S).powi(2);
                weights += weight;
                sum += weight * error;
            }
        }
        Self {
            kind: runs.first().map_or(CommandKind::Voltage, |run| run.kind),
            sample_times_s: (times().fold(f64::INFINITY, f64::min).min(longest), longest),
            clock: (weights > 0.0)
                .then(|| (sum / weights, (1.0 / weights).sqrt().hypot(HOST_CLOCK))),
            fastest_hz: runs
                .iter()
                .map(|run| run.top_speed_counts_s)
                .fold(0.0, f64::max),
            host_timed: runs.iter().all(|run| run.arrivals_scatter_s.is_some()),
            largest_command: runs
                .iter()
                .map(|run| run.largest_command)
                .fold(0.0, f64::max),
            top_speed_rad_s: runs
                .iter()
                .map(|run| run.top_speed_counts_s * std::f64::consts::TAU / run.counts_per_rev)
                .fold(1e-6, f64::max),
            is_friction_unknown: nominal
                .tolerance
                .get("coulomb_friction_nm")
                .is_some_and(|tolerance| *tolerance >= UNKNOWN),
            skips_turns: skips_turns(runs),
            travel_turns: travel_turns(runs),
            is_held: false,
        }
    }

    /// The numbers that ranges are multiples of: those of the motor, with a supply that stalls it at the largest
    /// command and turns it at the top speed where it is not driven by voltage.
    pub fn measures(&self, motor: &Parameters) -> Parameters {
        let mut p = *motor;
        let current_a = match self.kind {
            CommandKind::Voltage => return p,
            CommandKind::Current => self.largest_command,
            CommandKind::Torque => self.largest_command / p.torque_constant_nm_per_a,
        };
        p.supply_v = p.resistance_ohm * current_a;
        p.back_emf_v_s_per_rad = p.supply_v / self.top_speed_rad_s;
        p
    }

    /// Largest torque that the commands can ask for: at stall, or in these runs where no supply sets it.
    fn largest_torque_nm(&self, motor: &Parameters) -> f64 {
        let constant = motor.torque_constant_nm_per_a;
        match self.kind {
            CommandKind::Voltage => motor.supply_v * constant / motor.resistance_ohm,
            CommandKind::Current => self.largest_command * constant,
            CommandKind::Torque => self.largest_command,
        }
    }

    /// Whether these runs can tell of an effect: samples taken late, a clock that is off and a command that comes
    /// late are what arrival times look like in any case; an axis that is held tells of torques only; whole turns between
    /// samples hide what repeats with the angle.
    pub fn tells_of(&self, effect: &EffectKind) -> bool {
        let is_timing = effect.stage == Stage::Timing || effect.id == "transport_delay";
        let is_periodic = PERIODIC.contains(&effect.id);
        let is_hidden = self.host_timed && is_timing || self.skips_turns && is_periodic;
        !is_hidden && (!self.is_held || held::tells_of(effect.id))
    }

    /// Plausible range of a parameter in its unit.
    pub fn range(&self, parameter: &EffectParameter, motor: &Parameters) -> (f64, f64) {
        let (shortest, longest) = self.sample_times_s;
        if parameter.key == MAX_RATE {
            // Faster edges were not counted.
            return (LIMITS.0 * self.fastest_hz, LIMITS.1 * self.fastest_hz);
        }
        if let (Some((error, deviation)), "relative") = (self.clock, parameter.key) {
            let half = 3.0 * deviation;
            return (error - half, error + half);
        }
        let measures = self.measures(motor);
        let lo = parameter.range(&measures, shortest).0;
        let hi = parameter.range(&measures, longest).1;
        if self.is_friction_unknown && parameter.scale == Scale::CoulombTorque {
            return (lo, hi.max(self.largest_torque_nm(motor)));
        }
        (lo, hi)
    }

    /// What a parameter is taken to be where nothing is known.
    pub fn default(&self, parameter: &EffectParameter, motor: &Parameters) -> f64 {
        parameter.default(&self.measures(motor), self.sample_times_s.0)
    }

    /// Logarithm of the density of what the host's clock showed, for a board whose clock is off or ordinary; 0 where it
    /// showed nothing.
    pub fn log_density_of_clock(&self, is_off: bool) -> f64 {
        let Some((error, deviation)) = self.clock else {
            return 0.0;
        };
        if is_off {
            let (least, most) = CLOCK_OFF;
            return -(2.0 * error.abs().max(least) * (most / least).ln()).ln();
        }
        let spread = deviation.hypot(ORDINARY_CLOCK);
        let off = error / spread;
        -(0.5 * off * off).min(MOST_NATS) - (spread * std::f64::consts::TAU.sqrt()).ln()
    }
}

/// The largest angle that the shaft of one run covers, in turns; pieces of a run count from the same zero.
fn travel_turns(runs: &[RunData]) -> f64 {
    let covered = |origin: usize| {
        let own = runs.iter().filter(|run| run.origin == origin);
        let turns = own.flat_map(|run| {
            let of = move |counts: &f64| (run.first_counts + counts) / run.counts_per_rev;
            run.counts.iter().map(of)
        });
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (least, most) = turns.fold(ends, |(lo, hi), x| (lo.min(x), hi.max(x)));
        most - least
    };
    let mut origins: Vec<usize> = runs.iter().map(|run| run.origin).collect();
    origins.dedup();
    origins.into_iter().map(covered).fold(0.0, f64::max)
}

/// Whether the shaft passes whole turns from one sample to the next, half of the time in which it moves.
pub(super) fn skips_turns(runs: &[RunData]) -> bool {
    let (mut moving, mut skipping) = (0_usize, 0_usize);
    for run in runs {
        for (speed, _) in run
            .speed_counts_s
            .iter()
            .zip(&run.moving)
            .filter(|(_, moves)| **moves)
        {
            moving += 1;
            let turns = speed.abs() * run.sample_time_s / run.counts_per_rev;
            skipping += usize::from(turns > WHOLE_TURNS);
        }
    }
    2 * skipping > moving
}

#[cfg(test)]
mod tests {
    use super::super::samples::{motor_with, ready, recording};
    use super::*;

    /// The first samples of a run that cover about so many turns.
    fn covering(turns: f64) -> Vec<RunData> {
        let run = ready(&recording(&motor_with(&[]))).remove(0);
        let of = |counts: &f64| counts / run.counts_per_rev;
        let samples = run
            .counts
            .iter()
            .take_while(|c| of(c).abs() < turns)
            .count();
        vec![run.head(samples).expect("a beginning")]
    }

    /// A quarter of a turn in each of two pieces of a run is half a turn of it, in two runs it is a quarter.
    #[test]
    fn pieces_of_a_run_count_together_and_runs_apart() {
        let first = covering(0.25).remove(0);
        let mut second = first.clone();
        second.first_counts += 0.25 * second.counts_per_rev;
        let together = travel_turns(&[first.clone(), second.clone()]);
        assert!((together - 0.5).abs() < 0.02, "{together}");
        second.origin = first.origin + 1;
        let apart = travel_turns(&[first, second]);
        assert!((apart - 0.25).abs() < 0.02, "{apart}");
    }
}
