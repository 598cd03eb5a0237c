//! Time in another unit than stated: milliseconds for seconds, microseconds for milliseconds, or the reverse.
//!
//! Two kinds of evidence. A host's clock beside the device's gives the factor itself. Without one, sample time, time
//! constant and top speed are compared with those of usual motors and logs, in the stated unit and in units 10^3 and
//! 10^6 times as long or short. Each is a log-normal distribution, and the likelihoods multiply (naive Bayes: Hastie,
//! Tibshirani and Friedman, The Elements of Statistical Learning, 2009, section 6.6.3). The device's own protocol
//! counts microseconds, so that there is no unit to mistake.

use std::f64::consts::TAU;

use super::finding::{Finding, Kind, Severity};
use super::response::{Response, TimeConstant, response};
use super::sample_time::stated_s;
use super::subject::Subject;
use super::words::{digits, time};
use crate::motor::{CommandKind, Motor};
use crate::recording::unit_of_time::{MISTAKEN, power_of_unit};
use crate::recording::{Run, Steps};

/// A quantity with a log-normal distribution: mean and standard deviation of its logarithm to base 10.
#[derive(Debug, Clone, Copy)]
struct Usual {
    mean: f64,
    deviation: f64,
}

/// Sample times of motor logs in s: 10 ms, 0.6 to 160 ms within two standard deviations. The recordings of tests/real
/// have 0.4 ms to 2.1 s.
const STEPS: Usual = Usual {
    mean: -2.0,
    deviation: 0.6,
};
/// Mechanical time constants in s: 60 ms, 6 ms (ironless) to 0.6 s (a loaded gear) within two standard deviations.
const TIME_CONSTANTS: Usual = Usual {
    mean: -1.2,
    deviation: 0.5,
};
/// Top speeds of the encoder's shaft in rad/s: 10, 0.1 to 1,000 within two standard deviations.
const SPEEDS: Usual = Usual {
    mean: 1.0,
    deviation: 1.0,
};
/// With a motor file: its speed and time constant are right within a factor of 4 for two standard deviations.
const AGAINST_MOTOR: f64 = 0.3;

/// Prior log odds that the stated unit is right: one recording in fifty is wrong.
const PRIOR_LOG_ODDS: f64 = 3.9;
/// A stated sample time that agrees with the times would have to be wrong in the same way: one in a thousand.
const STATED: f64 = 6.9;
/// Log odds from which another unit is reported: twenty to one.
const SURE: f64 = 3.0;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let Some(intervals) = Steps::of(run).filter(|_| is_stated(run)) else {
        return Vec::new();
    };
    let step_s = intervals.median_s();
    let host = host_factor(run);
    let by_host_power = host.and_then(power_of_unit);
    if by_host_power == Some(0) {
        return Vec::new();
    }
    let response = response(run);
    let told = score(subject, step_s, response.as_ref(), 1.0);
    let by_host = by_host_power.and_then(|power| {
        // A simulated board may run faster than real time: the host's steps must be those of a log.
        let host_step_s = step_s / 10f64.powi(power);
        (STEPS.score(host_step_s) > STEPS.score(step_s)).then_some((power, f64::INFINITY))
    });
    let by_motor = || {
        let rivals = MISTAKEN.into_iter().map(|power| {
            let factor = 10f64.powi(power);
            let better = score(subject, step_s, response.as_ref(), factor) - told;
            (power, better - prior(run, step_s, factor))
        });
        let best = rivals.max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, odds)| host.is_none() && *odds > SURE)
    };
    let Some((power, log_odds)) = by_host.or_else(by_motor) else {
        return Vec::new();
    };
    let factor = 10f64.powi(power);
    let mut evidence = vec![("factor", factor), ("step_s", step_s)];
    let mut words = vec![format!("a sample comes every {}", time(step_s))];
    if let Some(host) = host {
        evidence.push(("board_seconds_per_host_second", host));
        words.push(format!(
            "the board's time runs {} times the host's",
            digits(host, 3)
        ));
    } else {
        evidence.push(("log_odds", log_odds));
    }
    if let Some(response) = response {
        let speed_rad_s = response.top_counts_s * TAU / run.counts_per_rev;
        evidence.push(("top_speed_rad_s", speed_rad_s));
        if let TimeConstant::Estimated(time_constant_s) = response.time_constant {
            evidence.push(("time_constant_s", time_constant_s));
            words.push(format!(
                "the shaft takes {} to follow a command",
                time(time_constant_s)
            ));
        }
        let speeds = expected(run, subject.motor).0;
        if speeds.score(speed_rad_s * factor) > speeds.score(speed_rad_s) {
            words.push(format!(
                "it turns at {} rad/s at most",
                digits(speed_rad_s, 3)
            ));
        }
    }
    let (longer, told, right) = match power {
        6 => ("a million times too long", "us", "s"),
        3 => ("a thousand times too long", "ms", "s"),
        -3 => ("a thousand times too short", "s", "ms"),
        _ => ("a million times too short", "s", "us"),
    };
    let mut found = subject.finding(
        Kind::TimeUnit,
        Severity::Fatal,
        subject.whole(),
        format!(
            "the times are {longer}, as if {told} had been read as {right}: {}",
            words.join(", ")
        ),
        [],
        remedy(power),
    );
    found.evidence.extend(evidence);
    vec![found]
}

fn remedy(power: i32) -> &'static str {
    match power {
        3 => {
            "import the log again with the next smaller unit, `--time COL:ms` where s was told (mapping file: `unit = \"ms\"` under [time]; --columns: t_ms)"
        }
        6 => {
            "import the log again with `--time COL:us` (mapping file: `unit = \"us\"` under [time]; --columns: t_us)"
        }
        -3 => {
            "import the log again with the next larger unit, `--time COL:s` where ms was told (mapping file: `unit = \"s\"` under [time]; --columns: t_s)"
        }
        _ => {
            "import the log again with `--time COL:s` (mapping file: `unit = \"s\"` under [time]; --columns: t_s)"
        }
    }
}

/// Whether the unit of the times was stated: not for a board that speaks the protocol (microseconds), a simulation
/// (seconds), or times made from row number and `sample_time_s`.
fn is_stated(run: &Run) -> bool {
    let header = &run.header;
    let by_row = header.get("imported").and_then(|i| i.get("time"));
    !(header.contains_key("boot_id")
        || header.get("simulated").and_then(toml::Value::as_bool) == Some(true)
        || by_row.and_then(toml::Value::as_str) == Some("made from the row number")
        || run.is_host_timed())
}

/// Ratio of device time to host time over the run.
fn host_factor(run: &Run) -> Option<f64> {
    let host = run.host_t_s.as_ref()?;
    let arrived: Vec<(f64, f64)> = (host.iter().zip(&run.t_s))
        .filter(|(host_s, _)| host_s.is_finite())
        .map(|(host_s, t_s)| (*host_s, *t_s))
        .collect();
    let (first, last) = (arrived.first()?, arrived.last()?);
    let factor = (last.1 - first.1) / (last.0 - first.0);
    (factor.is_finite() && factor > 0.0).then_some(factor)
}

/// Log likelihood if the times were `factor` times too long.
fn score(subject: &Subject<'_>, step_s: f64, response: Option<&Response>, factor: f64) -> f64 {
    let mut score = STEPS.score(step_s / factor);
    let Some(response) = response else {
        return score;
    };
    let run = subject.run;
    let (speeds, time_constants) = expected(run, subject.motor);
    let speed_rad_s = response.top_counts_s * TAU / run.counts_per_rev;
    score += speeds.score(speed_rad_s * factor);
    score
        + match response.time_constant {
            TimeConstant::Estimated(time_constant_s) => {
                time_constants.score(time_constant_s / factor)
            }
            TimeConstant::AtMost(time_constant_s) => {
                time_constants.score_below(time_constant_s / factor)
            }
            TimeConstant::Unknown => 0.0,
        }
}

/// Expected top speeds and time constants: the motor file's, if there is one and the command is a voltage.
fn expected(run: &Run, motor: Option<&Motor>) -> (Usual, Usual) {
    let largest_v = run
        .command
        .iter()
        .fold(0.0_f64, |most, u| most.max(u.abs()));
    let of = |value: f64, otherwise: Usual| {
        if value.is_finite() && value > 0.0 {
            Usual {
                mean: value.log10(),
                deviation: AGAINST_MOTOR,
            }
        } else {
            otherwise
        }
    };
    let Some(motor) = motor.filter(|_| run.command_kind == CommandKind::Voltage) else {
        return (SPEEDS, TIME_CONSTANTS);
    };
    let p = &motor.parameters;
    let loss = p.resistance_ohm * p.viscous_friction_nm_s_per_rad
        + p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad;
    let driving = p.torque_constant_nm_per_a * largest_v - p.resistance_ohm * p.coulomb_friction_nm;
    (
        of(driving / loss, SPEEDS),
        of(p.resistance_ohm * p.inertia_kg_m2 / loss, TIME_CONSTANTS),
    )
}

/// Prior log odds that the unit is right, against a factor of `factor`.
fn prior(run: &Run, step_s: f64, factor: f64) -> f64 {
    let Some(stated_s) = stated_s(run).or_else(|| header_sample_time_s(run)) else {
        return PRIOR_LOG_ODDS;
    };
    let near = |other_s: f64| (stated_s / other_s).log10().abs() < 0.1;
    if near(step_s) {
        PRIOR_LOG_ODDS + STATED
    } else if near(step_s / factor) {
        PRIOR_LOG_ODDS - STATED
    } else {
        PRIOR_LOG_ODDS
    }
}

/// The sample time in a header that no program generated.
fn header_sample_time_s(run: &Run) -> Option<f64> {
    let own = ["imported", "text_columns"];
    let written = run.header.contains_key("sample_time_s")
        && !own.iter().any(|key| run.header.contains_key(*key));
    written.then_some(run.sample_time_s)
}

impl Usual {
    /// Log likelihood of a value, without the constant.
    fn score(self, value: f64) -> f64 {
        -0.5 * self.deviations(value).powi(2)
    }

    /// Log probability of a value below this one: the lower tail below the mean.
    fn score_below(self, value: f64) -> f64 {
        let z = self.deviations(value);
        if z < 0.0 { self.score(value) } else { 0.0 }
    }

    fn deviations(self, value: f64) -> f64 {
        (value.log10() - self.mean) / self.deviation
    }
}
