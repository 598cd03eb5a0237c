//! Hints for wrong use of the command line: synonyms of commands and options, and sources of missing arguments.

use std::ffi::OsString;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory, Error};

use super::CommandLine;
use crate::hint::{Hinted, parted};
use crate::motor::is_alike;

/// Synonyms of subcommands, with the command.
const COMMANDS: &[(&[&str], &str)] = &[
    (
        &["record", "log", "acquire", "measure", "read"],
        "a board is recorded by: motorlab capture PORT",
    ),
    (
        &["plot", "show", "graph", "view", "draw"],
        "a recording is drawn by: motorlab compare RUN --html page.html",
    ),
    (
        &["list", "devices", "port", "scan"],
        "boards are listed by: motorlab ports",
    ),
    (
        &["fit", "identify", "sysid", "estimate", "tune", "calibrate"],
        "a motor is fitted to recordings by: motorlab diagnose RUN --nominal fit --model-out motor.toml",
    ),
    (
        &["analyze", "analyse", "why", "diagnosis"],
        "the cause of a sim-to-real error is found by: motorlab diagnose RUN --motor motor.toml",
    ),
    (
        &["convert", "csv", "load"],
        "a log of another program is read by: motorlab import LOG",
    ),
    (
        &["validate", "verify", "lint"],
        "a recording is checked by: motorlab check RUN",
    ),
    (
        &["profile", "profiles", "columns", "words"],
        "profiles, columns and effects are listed by: motorlab names",
    ),
    (
        &["start", "init", "example", "tutorial"],
        "everything once, without hardware: motorlab demo",
    ),
];

/// Synonyms of the output file.
const WRITTEN: &[&str] = &[
    "output", "out", "o", "file", "out-file", "outfile", "save", "to",
];
/// Synonyms of the option for a recording.
const RECORDINGS: &[&str] = &["run", "runs", "recording", "recordings", "log", "input"];
/// The option by which subcommands take recordings.
const TAKES_RECORDINGS: &str = "--run";

/// Synonyms of options, the option, and a remark.
const OPTIONS: &[(&[&str], &str, &str)] = &[
    (
        &["time", "length", "seconds", "dur", "for"],
        "--duration",
        " SECONDS",
    ),
    (
        &[
            "sample-time",
            "sampling-time",
            "dt",
            "period",
            "rate",
            "fs",
            "freq",
        ],
        "--ts",
        " SECONDS (0.003 for 3 ms)",
    ),
    (
        &["voltage", "volts", "vsupply"],
        "--supply",
        " VOLTS; a part of it is commanded by a profile, as in --profile step@0.5",
    ),
    (WRITTEN, "--output", " FILE (-o)"),
    (WRITTEN, "--html", " FILE"),
    (&["input", "signal", "command"], "--profile", " NAME"),
    (
        &["params", "parameters", "model-file", "config"],
        "--motor",
        " FILE",
    ),
    (&["page", "report", "plot"], "--html", " FILE"),
    (&["baudrate", "bps", "speed"], "--baud", " BITS_PER_SECOND"),
    (
        &["cpr", "ppr", "counts", "resolution"],
        "--counts-per-rev",
        " COUNTS",
    ),
];

/// Required arguments, and where they come from.
const NEEDED: &[(&str, &str)] = &[
    (
        "<PORT>",
        "`motorlab ports` lists the ports with a board; virtual: is a board without hardware",
    ),
    (
        "<RUN>",
        "name a run file: `motorlab capture PORT -o run.csv` records one, `motorlab simulate -o run.csv` simulates one",
    ),
];

/// The parser's error with its tip, or another hint.
pub(super) fn hinted(error: &Error, arguments: &[OsString]) -> Hinted {
    let text = error.to_string();
    let text = text.trim_start_matches("error: ");
    let (mut what, mut tips) = (String::new(), Vec::new());
    for line in text.lines() {
        match line.trim_start().strip_prefix("tip: ") {
            Some(tip) => tips.push(tip),
            None if line.starts_with("For more information, try") => {}
            None if line.is_empty() => {}
            None => what = what + "\n" + line,
        }
    }
    // A value's parser has a hint of its own.
    let (what, of_value) = parted(what.trim_start());
    let needed = NEEDED.iter().find(|(name, _)| {
        error.kind() == ErrorKind::MissingRequiredArgument && what.contains(name)
    });
    let hint = of_value.map(str::to_owned);
    let hint = hint.or_else(|| (!tips.is_empty()).then(|| tips.join("; ")));
    let hint = hint.or_else(|| needed.map(|(_, from)| (*from).to_owned()));
    Hinted::new(what, hint.unwrap_or_else(|| help_of(arguments)))
}

fn help_of(arguments: &[OsString]) -> String {
    let mut command = CommandLine::command();
    let mut name = command.get_name().to_owned();
    let words = arguments.iter().skip(1).filter_map(|word| word.to_str());
    for word in words.filter(|word| !word.starts_with('-')) {
        let Some(found) = command.find_subcommand(word).cloned() else {
            break;
        };
        name = name + " " + found.get_name();
        command = found;
    }
    let listed = match command.has_subcommands() {
        true => "commands",
        false => "arguments and options",
    };
    format!("`{name} --help` lists its {listed}")
}

/// Replaces the parser's guesses by the intended option.
pub(super) fn improve(error: &mut Error) {
    match error.kind() {
        ErrorKind::InvalidSubcommand => {
            let asked = text(error, ContextKind::InvalidSubcommand);
            let known = COMMANDS
                .iter()
                .find(|(words, _)| words.contains(&asked.as_str()));
            keep_similar(error, &asked, ContextKind::SuggestedSubcommand);
            if let Some((_, tip)) = known {
                error.remove(ContextKind::SuggestedSubcommand);
                say(error, (*tip).to_owned());
            }
        }
        ErrorKind::UnknownArgument => {
            let asked = text(error, ContextKind::InvalidArg);
            // How a value may begin with a dash is no help for a mistyped option.
            error.remove(ContextKind::Suggested);
            keep_similar(error, &asked, ContextKind::SuggestedArg);
            if let Some(tip) = tip_of_option(error, &asked) {
                error.remove(ContextKind::SuggestedArg);
                say(error, tip);
            }
            // The parser's usage is that of its own proposal.
            if error.get(ContextKind::SuggestedArg).is_none()
                && let Some(mut asked) = asked_for(error)
            {
                let usage = ContextValue::StyledStr(asked.render_usage());
                error.remove(ContextKind::Usage);
                error.insert(ContextKind::Usage, usage);
            }
        }
        _ => {}
    }
}

fn text(error: &Error, kind: ContextKind) -> String {
    match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        _ => String::new(),
    }
}

fn say(error: &mut Error, tip: String) {
    error.remove(ContextKind::Suggested);
    error.insert(
        ContextKind::Suggested,
        ContextValue::StyledStrs(vec![StyledStr::from(tip)]),
    );
}

/// Keeps the parser's proposals that are similar.
fn keep_similar(error: &mut Error, asked: &str, kind: ContextKind) {
    let plain = |text: &str| text.trim_start_matches('-').to_lowercase();
    let asked = plain(asked);
    let is_near = |name: &String| is_alike(&asked, &plain(name));
    let kept = match error.remove(kind) {
        Some(ContextValue::Strings(names)) => {
            let near: Vec<String> = names.into_iter().filter(is_near).collect();
            (!near.is_empty()).then_some(ContextValue::Strings(near))
        }
        Some(ContextValue::String(name)) => is_near(&name).then_some(ContextValue::String(name)),
        other => other,
    };
    if let Some(kept) = kept {
        error.insert(kind, kept);
    }
}

/// The subcommand of the arguments.
fn asked_for(error: &Error) -> Option<Command> {
    let Some(ContextValue::StyledStr(usage)) = error.get(ContextKind::Usage) else {
        return None;
    };
    let command = CommandLine::command();
    let usage = usage.to_string();
    let mut words = usage.split_whitespace();
    let asked = words.find_map(|word| command.find_subcommand(word))?;
    let name = format!("{} {}", command.get_name(), asked.get_name());
    Some(asked.clone().bin_name(name))
}

fn tip_of_option(error: &Error, typed: &str) -> Option<String> {
    let asked = asked_for(error)?;
    let has = |option: &str| {
        (asked.get_arguments()).any(|argument| argument.get_long() == option.strip_prefix("--"))
    };
    let Some(name) = typed.strip_prefix('-') else {
        if asked.get_name() == "design" {
            return Some(format!(
                "a design takes a profile (--profile); the next experiment of a recording: motorlab diagnose {typed}"
            ));
        }
        return has(TAKES_RECORDINGS)
            .then(|| format!("a recording is given by {TAKES_RECORDINGS} {typed}"));
    };
    let name = name.trim_start_matches('-');
    if ["effect", "effects"]
        .into_iter()
        .any(|word| is_alike(name, word))
    {
        return Some(
            "an effect belongs to a motor: [effects.ID] in a motor file, or virtual:?effect=ID on a virtual board"
                .to_owned(),
        );
    }
    if RECORDINGS.contains(&name)
        && let Some(first) = asked.get_positionals().next()
        && let Some([value, ..]) = first.get_value_names()
    {
        let bin = asked.get_bin_name().unwrap_or_default();
        return Some(format!("it is given without an option: {bin} {value}"));
    }
    let mut called = OPTIONS.iter().filter(|(words, _, _)| words.contains(&name));
    let (_, option, remark) = called.find(|(_, option, _)| has(option))?;
    Some(format!("did you mean {option}{remark}?"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    fn message(arguments: &[&str]) -> String {
        let all = ["motorlab"].iter().chain(arguments);
        let mut error = CommandLine::try_parse_from(all).expect_err("wrong use");
        improve(&mut error);
        error.to_string()
    }

    #[test]
    fn synonyms_suggest_a_command_or_an_option() {
        for (arguments, meant) in [
            (&["record", "COM3"][..], "motorlab capture"),
            (&["plot", "run.csv"], "motorlab compare"),
            (&["list"], "motorlab ports"),
            (&["fit", "run.csv"], "--nominal fit"),
            (&["captur"], "'capture'"),
            (&["diagnos"], "'diagnose'"),
            (&["capture", "virtual:", "--time", "4"], "--duration"),
            (&["capture", "virtual:", "--sample-time", "1"], "--ts"),
            (&["capture", "virtual:", "--out", "a"], "--output"),
            (&["simulate", "--effect", "backlash"], "virtual:?effect="),
            (&["simulate", "--dt", "0.01"], "--ts"),
            (&["diagnose", "a.csv", "--explian"], "--explain"),
            (&["compare", "a.csv", "--report", "x"], "--html"),
            (&["compare", "a.csv", "--output", "x.html"], "--html"),
            (&["diagnose", "a.csv", "-o", "x.html"], "--html"),
            (&["diagnose", "--run", "a.csv"], "motorlab diagnose RUN"),
            (&["import", "--log", "a.csv"], "motorlab import"),
            (&["lab", "a.csv"], "--run a.csv"),
            (&["simulate", "--efect", "backlash"], "virtual:?effect="),
        ] {
            let message = message(arguments);
            assert!(message.contains(meant), "{arguments:?}: {message}");
        }
    }

    #[test]
    fn misleading_suggestions_are_removed() {
        for (arguments, away) in [
            (&["plot", "run.csv"][..], "'ports'"),
            (&["capture", "virtual:", "--time", "4"], "--patience"),
            (&["capture", "virtual:", "--sample-time", "1"], "as a value"),
            (&["banana"], "similar"),
            (&["design", "a.csv"], "--run"),
            (&["check", "a.csv", "--output", "x"], "did you mean"),
        ] {
            let message = message(arguments);
            assert!(!message.contains(away), "{arguments:?}: {message}");
        }
    }

    #[test]
    fn every_suggested_option_belongs_to_a_subcommand() {
        let command = CommandLine::command();
        for (_, option, _) in OPTIONS {
            let mut all = command
                .get_subcommands()
                .flat_map(|sub| sub.get_arguments());
            assert!(
                all.any(|argument| argument.get_long() == option.strip_prefix("--")),
                "{option}"
            );
        }
    }
}
