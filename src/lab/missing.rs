//! Part 3: what is missing in the simulation, as [`crate::diagnose`] finds it in all recordings together.

use serde::Serialize;

use crate::check::{Finding, Severity};
use crate::diagnose::{Cause, Diagnosis, Interval, Options, diagnose};
use crate::motor::Motor;
use crate::recording::Run;
use crate::report::number::figure;

/// What the recordings say of the simulation's gaps.
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
        // As `diagnose` has it: what is to be mended first says nothing of the motor.
        if let Some(fatal) = findings
            .iter()
            .find(|found| found.severity == Severity::Fatal)
        {
            return Self::Undiagnosed(format!(
                "the recording has to be mended first: {}",
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

/// A cause's name as the report says it.
pub fn cause_words(cause: &Cause) -> &str {
    match cause.effect.as_str() {
        "none" => "no effect: the same model with other numbers",
        "unknown" => "something that no effect of the catalogue explains",
        effect => effect,
    }
}

/// A cause's numbers with their 95 % intervals.
pub fn cause_numbers(cause: &Cause) -> String {
    let number = |(key, interval): (&String, &Interval)| {
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
