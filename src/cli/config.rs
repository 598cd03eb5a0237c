//! `motorlab.toml` beside the runs: default flags of every command that takes them.

use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, CommandFactory};

use super::{CommandLine, Failure};
use crate::hint::parted;
use crate::motor::is_alike;
use crate::plain::{one_line, shown};

/// Name of the file.
pub(super) const NAME: &str = "motorlab.toml";
/// Largest size in bytes: some 20 keys of one line each are below 4 kB.
const MOST_BYTES: u64 = 1 << 16;
/// Arguments with runs, logs or a folder of them: the file is searched beside the first.
const RUNS: [&str; 4] = ["runs", "run", "log", "class"];
/// The command whose `--log` is an output file.
const WRITES_LOG: &str = "capture";
/// A key with a shorter name than its flag.
const COUNTS: (&str, &str) = ("counts", "counts-per-rev");
/// An argument that replaces all flags about a log.
const MAPPING: &str = "map";

#[derive(Debug, Default)]
pub(super) struct ConfiguredFlags {
    /// The flags, such as `--supply`.
    pub flags: Vec<String>,
    /// The message about them.
    pub message: Option<String>,
}

/// A key of the file with its value.
struct Entry {
    key: String,
    /// The flag without its dashes.
    long: String,
    /// The value as written in the file.
    written: String,
    /// The value for the flag; `None` to omit the flag.
    value: Option<String>,
}

impl Entry {
    fn argument(&self, is_switch: bool) -> Option<OsString> {
        let value = self.value.as_deref()?;
        Some(match is_switch {
            true => format!("--{}", self.long).into(),
            false => format!("--{}={value}", self.long).into(),
        })
    }
}

/// All flags that the file may contain, in the order of the message.
fn known() -> Command {
    let motor = Arg::new("motor").long("motor").value_name("FILE");
    let flags = super::import_flags::Flags::augment_args(Command::new(NAME).no_binary_name(true));
    flags.arg(motor).disable_help_flag(true)
}

fn key_of(long: &str) -> String {
    match long == COUNTS.1 {
        true => COUNTS.0.to_owned(),
        false => long.replace('-', "_"),
    }
}

fn is_switch(argument: &Arg) -> bool {
    matches!(argument.get_action(), ArgAction::SetTrue)
}

/// The keys in the order of the message.
fn keys(known: &Command) -> Vec<(String, &Arg)> {
    let mut keys: Vec<(String, &Arg)> = (known.get_arguments())
        .filter_map(|argument| Some((key_of(argument.get_long()?), argument)))
        .collect();
    let first = ["motor", "supply", COUNTS.0];
    keys.sort_by_key(|(key, _)| {
        let place = first.iter().position(|name| name == key);
        place.unwrap_or(first.len())
    });
    keys
}

/// Adds the file's flags to these arguments unless they are given. Nothing is added without a file, with
/// `--no-config`, or to arguments that do not parse.
pub(super) fn configure(arguments: &mut Vec<OsString>) -> Result<ConfiguredFlags, Failure> {
    let mut command = CommandLine::command();
    let Ok(matches) = command.try_get_matches_from_mut(arguments.iter()) else {
        return Ok(ConfiguredFlags::default());
    };
    if matches.get_flag("no_config") {
        return Ok(ConfiguredFlags::default());
    }
    let (leaf, given) = leaf(&command, &matches);
    let Some((path, entries)) = found(leaf, given)? else {
        return Ok(ConfiguredFlags::default());
    };
    let mut message = Vec::new();
    let mut flags = Vec::new();
    for entry in entries {
        let mut with_it = arguments.clone();
        let (Some(argument), Some(added)) = (taken_by(leaf, given, &entry), &entry.value) else {
            continue;
        };
        let Some(flag) = entry.argument(is_switch(argument)) else {
            continue;
        };
        let end = with_it.iter().position(|word| word == "--");
        with_it.insert(end.unwrap_or(with_it.len()), flag);
        let mut command = CommandLine::command();
        match command.try_get_matches_from_mut(with_it.iter()) {
            Ok(_) => {
                *arguments = with_it;
                let unit = if entry.long == "supply" && added.parse::<f64>().is_ok() {
                    " V"
                } else {
                    ""
                };
                message.push(format!("{} = {}{unit}", entry.key, entry.written));
                flags.push(format!("--{}", entry.long));
            }
            Err(error) if is_out_of_place(error.kind()) => {}
            Err(error) => return Err(refused(&path, &entry, &error)),
        }
    }
    let line = || format!("using {}: {}", shown(&path), message.join(", "));
    Ok(ConfiguredFlags {
        message: (!message.is_empty()).then(line),
        flags,
    })
}

/// A flag that conflicts with explicit ones, which take precedence.
fn is_out_of_place(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::ArgumentConflict | ErrorKind::MissingRequiredArgument
    )
}

fn leaf<'a>(command: &'a Command, matches: &'a ArgMatches) -> (&'a Command, &'a ArgMatches) {
    let Some((name, inner)) = matches.subcommand() else {
        return (command, matches);
    };
    match command.find_subcommand(name) {
        Some(subcommand) => leaf(subcommand, inner),
        None => (command, matches),
    }
}

/// The argument of this command for the entry, unless the call already has it.
fn taken_by<'a>(leaf: &'a Command, given: &ArgMatches, entry: &Entry) -> Option<&'a Arg> {
    let explicit = |id: &str| {
        let is_there = given.try_contains_id(id).is_ok();
        is_there && given.value_source(id) == Some(ValueSource::CommandLine)
    };
    if entry.long != "motor" && explicit(MAPPING) {
        return None;
    }
    let argument = leaf
        .get_arguments()
        .find(|argument| argument.get_long() == Some(entry.long.as_str()))?;
    // A column of a measured supply belongs to a log.
    let is_of_log = leaf
        .get_arguments()
        .any(|argument| argument.get_id() == "position");
    let is_column = entry.long == "supply" && entry.value.as_ref()?.parse::<f64>().is_err();
    (!explicit(argument.get_id().as_str()) && (is_of_log || !is_column)).then_some(argument)
}

/// The file beside the runs of this call, else in the working directory, and its entries.
fn found(leaf: &Command, given: &ArgMatches) -> Result<Option<(PathBuf, Vec<Entry>)>, Failure> {
    let mut found: Option<(PathBuf, Vec<Entry>)> = None;
    for path in places(leaf, given) {
        let Some(text) = text(&path)? else {
            continue;
        };
        let entries = entries(&path, &text)?;
        match &found {
            None => found = Some((path, entries)),
            Some((first, others)) if !is_same(others, &entries) => {
                return Err(Failure::wrong(
                    format!(
                        "{} and {} differ, and one command takes one of them",
                        shown(first),
                        shown(&path)
                    ),
                    "--no-config, with the flags given",
                )
                .at(&path));
            }
            Some(_) => {}
        }
    }
    Ok(found)
}

fn is_same(these: &[Entry], those: &[Entry]) -> bool {
    let pairs = |entries: &[Entry]| -> Vec<(String, Option<String>)> {
        (entries.iter())
            .map(|entry| (entry.key.clone(), entry.value.clone()))
            .collect()
    };
    pairs(these) == pairs(those)
}

/// Folders that may contain the file: that of each run, else the working directory.
fn places(leaf: &Command, given: &ArgMatches) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = Vec::new();
    for id in RUNS {
        if leaf.get_name() == WRITES_LOG && id == "log" {
            continue;
        }
        let Ok(Some(paths)) = given.try_get_many::<PathBuf>(id) else {
            continue;
        };
        for path in paths.filter(|path| path.as_os_str() != "-") {
            let folder = match path.is_dir() {
                true => path.clone(),
                false => path.parent().map_or_else(PathBuf::new, Path::to_owned),
            };
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
    }
    if folders.is_empty() {
        folders.push(PathBuf::new());
    }
    folders.iter().map(|folder| folder.join(NAME)).collect()
}

/// The file's text; `None` without a file.
fn text(path: &Path) -> Result<Option<String>, Failure> {
    let failed = |what: String| {
        Failure::wrong(
            format!("{}: {what}", shown(path)),
            "--no-config leaves it out",
        )
        .at(path)
    };
    match path.metadata() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        // A folder of a run that cannot be read is reported with that run.
        Err(_) => return Ok(None),
        Ok(found) if !found.is_file() => return Err(failed("it is no file".to_owned())),
        Ok(_) => {}
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| failed(error.to_string()))?;
    (file.take(MOST_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|error| failed(error.to_string()))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(failed(format!("it is longer than {MOST_BYTES} bytes")));
    }
    String::from_utf8(bytes)
        .map(Some)
        .map_err(|_| failed("it is no UTF-8 text".to_owned()))
}

/// The entries of the file, with known keys and values that their flags accept.
fn entries(path: &Path, text: &str) -> Result<Vec<Entry>, Failure> {
    let failed = |what: String, hint: &str| {
        Failure::wrong(format!("{}: {what}", shown(path)), hint).at(path)
    };
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| {
            1 + text[..span.start.min(text.len())].matches('\n').count()
        });
        failed(
            format!("line {line}: {}", error.message()),
            "a line is KEY = VALUE, and a text stands in quotes",
        )
    })?;
    let known = known();
    let keys = keys(&known);
    if let Some(unknown) = table
        .keys()
        .find(|key| !keys.iter().any(|(known, _)| known == *key))
    {
        let what = format!("unknown key '{}'", one_line(unknown));
        return Err(failed(what, &known_key(unknown, &keys)));
    }
    let mut entries = Vec::new();
    for (key, argument) in &keys {
        let Some(value) = table.get(key) else {
            continue;
        };
        let Some(entry) = entry(key, argument, value, path) else {
            let expected = if is_switch(argument) {
                "true or false"
            } else {
                "a number or a text in quotes"
            };
            return Err(failed(
                format!("{key} = {}", one_line(&value.to_string())),
                &format!("it is {expected}"),
            ));
        };
        let words = entry.argument(is_switch(argument));
        if let Err(error) = known.clone().try_get_matches_from(words) {
            return Err(refused(path, &entry, &error));
        }
        entries.push(entry);
    }
    Ok(entries)
}

/// The entry of a key; `None` where the value is of another type.
fn entry(key: &str, argument: &Arg, value: &toml::Value, path: &Path) -> Option<Entry> {
    let beside = |text: &str| match argument.get_id() == "motor" {
        true => {
            let folder = path.parent().unwrap_or(Path::new(""));
            folder.join(text).display().to_string()
        }
        false => text.to_owned(),
    };
    let text = match (value, is_switch(argument)) {
        (toml::Value::Boolean(on), true) => on.then(String::new),
        (toml::Value::Boolean(on), false) if key == "unsigned" => Some(on.to_string()),
        (_, true) => return None,
        _ if key == "unsigned" => return None,
        (toml::Value::String(text), _) => Some(beside(text)),
        (toml::Value::Integer(number), _) => Some(number.to_string()),
        (toml::Value::Float(number), _) => Some(number.to_string()),
        _ => return None,
    };
    Some(Entry {
        key: key.to_owned(),
        long: argument.get_long()?.to_owned(),
        written: one_line(&value.to_string()).into_owned(),
        value: text,
    })
}

/// The key most similar to an unknown one, or all keys.
fn known_key(unknown: &str, keys: &[(String, &Arg)]) -> String {
    let plain = unknown.to_lowercase().replace('-', "_");
    let near = (keys.iter()).find(|(key, argument)| {
        let long = argument.get_long().unwrap_or_default();
        is_alike(&plain, key) || plain == long.replace('-', "_")
    });
    match near {
        Some((key, _)) => format!("did you mean '{key}'?"),
        None => {
            let all: Vec<&str> = keys.iter().map(|(key, _)| key.as_str()).collect();
            format!("its keys are {}", all.join(", "))
        }
    }
}

/// Error of a value that the flag does not accept.
fn refused(path: &Path, entry: &Entry, error: &clap::Error) -> Failure {
    let why = std::error::Error::source(error).map(ToString::to_string);
    let why = why.unwrap_or_else(|| {
        let text = error.to_string();
        let line = text.lines().next().unwrap_or_default();
        line.trim_start_matches("error: ").to_owned()
    });
    let (why, hint) = parted(&why);
    let hint = hint.map_or(String::new(), |hint| format!("{hint}; "));
    Failure::wrong(
        format!("{}: {} = {}: {why}", shown(path), entry.key, entry.written),
        format!("{hint}correct it, or --no-config leaves the file out"),
    )
    .at(path)
}
