//! Part 3: effects missing in the simulation, as [`crate::diagnose`] identifies them from all recordings together.

use serde::Serialize;

use super::Progress;
use crate::check::{Finding, Severity};
use crate::diagnose::{Cause, Diagnosis, Interval, NominalSource, Options, diagnose, nominal_fit};
use crate::motor::Motor;
use crate::recording::Run;
use crate::report::number::figure;

/// The diagnosis of the recordings.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Missing {
    /// The diagnosis.
    Diagnosed(Box<Diagnosis>),
    /// Reason of a missing diagnosis.
    Undiagnosed(String),
}

impl Missing {
    /// Diagnoses all recordings together, with their findings and the nominal motor. For an unknown axis the
    /// handout's parameters are no reference: its nominal motor is fitted, as in `diagnose` of a foreign log without
    /// a motor file.
    pub fn in_simulation_of(
        (motor, is_described): (&Motor, bool),
        runs: &[Run],
        findings: &[Finding],
        progress: Progress<'_>,
    ) -> (Self, Motor) {
        let mut motor = motor.clone();
        // As in `diagnose`: with a fatal finding there is no statement about the motor.
        if let Some(fatal) = findings
            .iter()
            .find(|found| found.severity == Severity::Fatal)
        {
            let why = format!(
                "a finding about the recording is fatal: {}",
                fatal.sentence()
            );
            return (Self::Undiagnosed(why), motor);
        }
        let mut options = Options {
            progress: &progress.doing,
            done: &progress.done,
            ..Options::default()
        };
        if !is_described {
            (progress.doing)("fitting the nominal model");
            let fit = match nominal_fit(runs, &motor, &options.settings) {
                Ok(fit) => fit,
                Err(why) => return (Self::Undiagnosed(why.to_string()), motor),
            };
            options.nominal_source = match fit.is_given {
                true => NominalSource::Handout,
                false => NominalSource::Fit,
            };
            motor = fit.motor;
        }
        let found = match diagnose(runs, &motor, &options) {
            Ok(diagnosis) => Self::Diagnosed(Box::new(diagnosis)),
            Err(why) => Self::Undiagnosed(why.to_string()),
        };
        (found, motor)
    }

    /// The diagnosis, if there is one.
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
