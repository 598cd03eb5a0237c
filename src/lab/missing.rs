//! Part 3: effects that the simulation lacks, as [`crate::diagnose`] identifies them from all recordings together.

use serde::Serialize;

use crate::check::{Finding, Severity};
use crate::diagnose::{Cause, Diagnosis, Interval, Options, diagnose};
use crate::motor::Motor;
use crate::recording::Run;
use crate::report::number::figure;

/// The diagnosis of the recordings.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Missing {
    /// They were diagnosed.
    Diagnosed(Box<Diagnosis>),
    /// They cannot be; why not.
    Undiagnosed(String),
}

impl Missing {
    /// Diagnoses all recordings together, in which this was found; `progress` is told what is being done.
    pub fn in_simulation_of(
        motor: &Motor,
        runs: &[Run],
        findings: &[Finding],
        progress: &(dyn Fn(&str) + Sync),
    ) -> Self {
        // As in `diagnose`: with a fatal finding nothing is asserted about the motor.
        if let Some(fatal) = findings
            .iter()
            .find(|found| found.severity == Severity::Fatal)
        {
            return Self::Undiagnosed(format!(
                "a finding about the recording is fatal: {}",
                fatal.sentence()
            ));
        }
        let options = Options {
            progress,
            ..Options::default()
        };
        match diagnose(runs, motor, &options) {
            Ok(diagnosis) => Self::Diagnosed(Box::new(diagnosis)),
            Err(why) => Self::Undiagnosed(why.to_string()),
        }
    }

    /// The diagnosis, where there is one.
    pub fn diagnosis(&self) -> Option<&Diagnosis> {
        match self {
            Self::Diagnosed(diagnosis) => Some(diagnosis),
            Self::Undiagnosed(_) => None,
        }
    }
}

/// Parameters of an effect with their 95 % intervals.
pub fn cause_numbers(cause: &Cause) -> String {
    let number = |(key, interval): (&&str, &Interval)| {
        let (key, interval) = interval.determined(key);
        format!(
            "{key} {} [{}, {}]",
            figure(interval.value, 3),
            figure(interval.lo95, 3),
            figure(interval.hi95, 3)
        )
    };
    let numbers: Vec<String> = cause.parameters.iter().map(number).collect();
    numbers.join(", ")
}
