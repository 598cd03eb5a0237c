//! A command that is constant over the whole run.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;
use super::words::unit;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let Some(&command) = run.command.first() else {
        return Vec::new();
    };
    if !subject.has("command") || run.command.iter().any(|other| *other != command) {
        return Vec::new();
    }
    let (severity, message, remedy) = if command == 0.0 {
        (
            Severity::Fatal,
            "the command is 0 throughout".to_owned(),
            "record the command too, or say what it was: [command] in the mapping, --profile of the capture",
        )
    } else {
        (
            Severity::Note,
            format!(
                "the command is {command} {} throughout",
                unit(run.command_kind)
            ),
            "a step from rest is enough for a model; runs with other levels and a reversal show more effects",
        )
    };
    vec![subject.finding(
        Kind::CommandConstant,
        severity,
        subject.whole(),
        message,
        [("command", command)],
        remedy,
    )]
}
