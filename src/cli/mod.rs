//! The command line: one file per subcommand, arguments and printing only.
//!
//! Every subcommand is a struct of arguments with `run(&self, &Output) -> Result<Status, Failure>`. With `--json`
//! exactly one JSON document goes to standard output; messages and progress go to standard error.

mod blind;
mod capture;
mod capture_report;
mod capture_text;
mod check;
mod compare;
mod completing;
mod completions;
mod config;
mod demo;
mod design;
mod diagnose;
mod diagnose_text;
mod effects;
mod explain;
mod export;
mod export_actuator;
mod export_run;
mod failure;
mod findings;
mod firmware;
mod flash;
mod foreign;
mod import;
mod import_flags;
mod import_words;
mod known;
mod lab;
mod lab_class;
mod live;
mod man;
mod missing_file;
mod motor;
mod motor_choice;
mod motor_file;
mod motor_template;
mod names;
mod numbers;
mod output_file;
mod overview;
mod picture;
mod ports;
mod progress;
mod reconnect;
mod replay;
mod resistance;
mod schema;
mod signals;
mod simulate;
mod staged;
mod tabulate;
mod threads;
mod typed_command;
mod until_known;
mod virtual_board;
mod virtual_capture;
mod virtual_spec;
mod wrong_use;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;

use clap::{Parser, Subcommand};
use serde::Serialize;

pub use failure::{Failure, Status};
pub use foreign::unreadable;

use crate::plain::{one_line, plain, plain_json};

/// Record a DC motor over serial, simulate it, compare the two, and identify the effects that cause the sim-to-real error.
#[derive(Debug, Parser)]
#[command(
    name = "motorlab",
    version,
    propagate_version = true,
    max_term_width = 100,
    help_template = overview::TEMPLATE
)]
pub struct CommandLine {
    /// Print one JSON document on standard output, and nothing else there.
    #[arg(long, global = true)]
    json: bool,
    /// Ignore the configuration file motorlab.toml that lies beside the runs.
    #[arg(long, global = true)]
    no_config: bool,
    #[command(subcommand)]
    command: Command,
}

/// The subcommands, in the order in which a lab uses them.
#[derive(Debug, Subcommand)]
enum Command {
    Ports(ports::Ports),
    Capture(capture::Capture),
    Replay(replay::Replay),
    Virtual(virtual_board::Virtual),
    Simulate(simulate::Simulate),
    Check(check::Check),
    Compare(compare::Compare),
    Lab(lab::Lab),
    Diagnose(diagnose::Diagnose),
    Design(design::Design),
    Effects(effects::Effects),
    Explain(explain::Explain),
    Motor(motor::MotorFile),
    Names(names::Names),
    Export(export::Export),
    Tabulate(tabulate::Tabulate),
    Blind(blind::Blind),
    Import(import::Import),
    Demo(demo::Demo),
    Firmware(firmware::Firmware),
    Flash(flash::Flash),
    Schema(schema::Schema),
    Completions(completions::Completions),
    Man(man::Man),
}

/// Output settings of a subcommand. A closed pipe (`| head`) is no error.
#[derive(Debug)]
pub struct Output {
    /// One JSON document instead of text.
    pub json: bool,
    /// The command line as typed, without output options.
    pub asked: String,
    /// Flags that the configuration file gave.
    pub configured: Vec<String>,
    /// Parameters that motor files leave to the handout, for the document: file, and keys with their values.
    filled: Mutex<BTreeMap<String, BTreeMap<&'static str, f64>>>,
}

/// A document with the values that motor files leave to the handout.
#[derive(Serialize)]
struct WithHandoutValues<'a, T> {
    #[serde(flatten)]
    document: &'a T,
    handout_values: &'a BTreeMap<String, BTreeMap<&'static str, f64>>,
}

impl Output {
    fn new(json: bool, asked: String) -> Self {
        Self {
            json,
            asked,
            configured: Vec::new(),
            filled: Mutex::default(),
        }
    }

    /// The JSON document, on standard output.
    pub fn document(&self, document: &impl Serialize) -> Result<(), Failure> {
        self.write(&self.in_json(document)?)
    }

    /// A JSON document as text, with the key `handout_values` if a motor file lacks values.
    fn in_json(&self, document: &impl Serialize) -> Result<String, Failure> {
        match self.filled.lock() {
            Ok(filled) if !filled.is_empty() => plain_json(&WithHandoutValues {
                document,
                handout_values: &filled,
            }),
            _ => plain_json(document),
        }
        .map_err(Failure::input)
    }

    /// Records the values that this motor file leaves to the handout; returns whether they are new.
    fn filled(&self, path: &Path, values: &[(&'static str, f64)]) -> bool {
        let values = values.iter().copied().collect();
        let filled = self.filled.lock();
        filled.is_ok_and(|mut filled| filled.insert(path.display().to_string(), values).is_none())
    }

    /// A line of text on standard output. Control characters from files and devices are removed, except the colours
    /// of a plot.
    pub fn line(&self, text: &str) -> Result<(), Failure> {
        self.write(&for_people(text))
    }

    /// A plot of this program on standard output, colours included.
    pub fn picture(&self, text: &str) -> Result<(), Failure> {
        self.write(text)
    }

    fn write(&self, text: &str) -> Result<(), Failure> {
        let mut output = io::stdout().lock();
        match writeln!(output, "{text}").and_then(|()| output.flush()) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::device(error)),
            _ => Ok(()),
        }
    }

    /// A message on standard error; a write error is ignored. Control characters from files and devices are removed.
    pub fn message(&self, text: &str) {
        let text = for_people(text);
        let _ = progress::with_progress_suspended(|| writeln!(io::stderr().lock(), "{text}"));
    }
}

impl Output {
    /// Prints the failure on standard error, with `--json` also as a document, and returns its exit status.
    fn end(&self, failure: &Failure) -> Status {
        self.message(&failure.to_string());
        self.failed(failure);
        failure.status
    }

    /// With `--json`, prints the failure as a document; a closed pipe is ignored.
    fn failed(&self, failure: &Failure) {
        if self.json {
            let text = plain_json(&failure.document());
            let _ = text.map(|text| self.write(&text));
        }
    }
}

/// Text for output: arguments of this call, such as file names, are on one line in it, and control characters are
/// removed. All messages and lines pass through here.
fn for_people(text: &str) -> String {
    let typed = std::env::args_os().skip(1);
    let text = typed.fold(text.to_owned(), |text, argument| {
        typed_on_one_line(text, &argument.to_string_lossy())
    });
    plain(&text).into_owned()
}

/// The text with an argument's line ends and tabs replaced as by `one_line`, also where it contains only a part of
/// the argument, which is found by the neighbouring characters.
fn typed_on_one_line(text: String, argument: &str) -> String {
    let letters: Vec<char> = argument.chars().collect();
    (0..letters.len())
        .filter(|k| matches!(letters[*k], '\n' | '\t'))
        .fold(text, |text, k| {
            let ends = (k + 2).min(letters.len());
            let beside: String = letters[k.saturating_sub(1)..ends].iter().collect();
            text.replace(&beside, &one_line(&beside))
        })
}

impl CommandLine {
    /// Parses the arguments of this process and runs the subcommand.
    pub fn run_arguments() -> ExitCode {
        Self::run_these(std::env::args_os().collect()).into()
    }

    /// Parses these arguments, the program's name first, and runs the subcommand. Wrong use is reported as any other
    /// failure.
    pub fn run_these(mut arguments: Vec<OsString>) -> Status {
        if arguments.len() < 2 {
            let output = Output::new(false, String::new());
            return match output.line(overview::SHORT_HELP) {
                Ok(()) => Status::Done,
                Err(failure) => failure.status,
            };
        }
        let words = arguments.iter().skip(1);
        let asked =
            typed_command::without_outputs(words.map(|word| word.to_string_lossy().into_owned()));
        let json = (arguments.iter().skip(1))
            .take_while(|argument| *argument != "--")
            .any(|argument| argument == "--json");
        let mut output = Output::new(json, asked);
        let configured = match config::configure(&mut arguments) {
            Ok(configured) => configured,
            Err(failure) => return output.end(&failure),
        };
        if let Some(message) = &configured.message {
            output.message(message);
        }
        output.configured = configured.flags;
        let wrong = match Self::try_parse_from(&arguments) {
            Ok(line) => return line.run(&output),
            Err(wrong) => wrong,
        };
        if !wrong.use_stderr() {
            // Help and version, as requested.
            let _ = wrong.print();
            return Status::Done;
        }
        output.end(&Self::wrong_use(&arguments, wrong))
    }

    fn wrong_use(arguments: &[OsString], wrong: clap::Error) -> Failure {
        // Parsed again with escaped arguments, because the parser quotes them.
        let shown =
            (arguments.iter()).map(|argument| one_line(&argument.to_string_lossy()).into_owned());
        let mut wrong = Self::try_parse_from(shown).err().unwrap_or(wrong);
        wrong_use::improve(&mut wrong);
        Failure::input(wrong_use::hinted(&wrong, arguments)).of_kind("wrong_use")
    }

    /// Runs the subcommand; a failure is printed on standard error and returned as exit status.
    fn run(self, output: &Output) -> Status {
        if output.json {
            progress::hide();
        }
        let result = match self.command {
            Command::Ports(command) => command.run(output),
            Command::Capture(command) => command.run(output),
            Command::Replay(command) => command.run(output),
            Command::Virtual(command) => command.run(output),
            Command::Simulate(command) => command.run(output),
            Command::Check(command) => command.run(output),
            Command::Compare(command) => command.run(output),
            Command::Lab(command) => command.run(output),
            Command::Diagnose(command) => command.run(output),
            Command::Design(command) => command.run(output),
            Command::Effects(command) => command.run(output),
            Command::Explain(command) => command.run(output),
            Command::Motor(command) => command.run(output),
            Command::Names(command) => command.run(output),
            Command::Export(command) => command.run(output),
            Command::Tabulate(command) => command.run(output),
            Command::Blind(command) => command.run(output),
            Command::Import(command) => command.run(output),
            Command::Demo(command) => command.run(output),
            Command::Firmware(command) => command.run(output),
            Command::Flash(command) => command.run(output),
            Command::Schema(command) => command.run(output),
            Command::Completions(command) => command.run(output),
            Command::Man(command) => command.run(output),
        };
        match result {
            Ok(status) => status,
            Err(failure) => output.end(&failure),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The given arguments are used, not those of the process: Python's differ.
    #[test]
    fn wrong_use_is_reported_for_the_given_arguments() {
        let arguments = ["motorlab", "diag\nnos"].map(OsString::from);
        let wrong = CommandLine::try_parse_from(&arguments).expect_err("no command");
        let message = CommandLine::wrong_use(&arguments, wrong).to_string();
        assert!(message.contains("'diag\u{fffd}nos'"), "{message}");
    }

    #[test]
    fn arguments_are_printed_on_one_line() {
        let of = |text: &str, argument| typed_on_one_line(text.to_owned(), argument);
        assert_eq!(of("a\nb.csv: x\n  y", "a\nb.csv"), "a\u{fffd}b.csv: x\n  y");
        assert_eq!(
            of("a\nb-2.csv\n\nUsage", "in/a\nb.csv"),
            "a\u{fffd}b-2.csv\n\nUsage"
        );
        assert_eq!(of("\tb: x", "\tb"), "\u{fffd}b: x");
        assert_eq!(of("a\n  b", "a b"), "a\n  b");
    }
}
