//! Hint for a missing file: the folder that does not exist, or files in it with a similar name.

use std::fs;
use std::path::Path;

use crate::motor::is_alike;
use crate::plain::shown;

/// How a system error for a missing file or folder ends, on Unix and Windows.
const ENDS: [&str; 2] = ["(os error 2)", "(os error 3)"];
/// Words before a path in messages.
const VERBS: [&str; 4] = [
    "cannot read the profile ",
    "cannot create ",
    "cannot write ",
    "cannot read ",
];
/// Most names listed: one line.
const MOST_SHOWN: usize = 3;
/// Most entries of a folder that are examined.
const MOST_ENTRIES: usize = 10_000;

/// The hint of a message that ends with a missing file, which is `known` or precedes the error in the message.
pub(super) fn hint(message: &str, known: Option<&str>) -> Option<String> {
    let at = ENDS.iter().find_map(|end| message.find(end))?;
    let path = match known {
        Some(path) => path,
        None => named(&message[..at])?,
    };
    let path = Path::new(path);
    (!path.exists()).then(|| beside(path))
}

/// The path before `: No such file or directory`.
fn named(message: &str) -> Option<&str> {
    let first = message.lines().next()?;
    let first = first.strip_prefix("error: ").unwrap_or(first);
    let first = VERBS
        .iter()
        .find_map(|verb| first.strip_prefix(verb))
        .unwrap_or(first);
    first.split(": ").next().filter(|path| !path.is_empty())
}

fn beside(path: &Path) -> String {
    let mut folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut asked = path;
    while !folder.exists()
        && let Some(parent) = folder.parent()
    {
        asked = folder;
        folder = match parent.as_os_str().is_empty() {
            true => Path::new("."),
            false => parent,
        };
    }
    let name = |path: &Path| {
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
    };
    let Some(wanted) = name(asked) else {
        return format!("there is no {}", shown(path));
    };
    let is_folder = asked != path;
    let extension = |name: &str| {
        name.rsplit_once('.')
            .map(|(_, extension)| extension.to_lowercase())
    };
    let entries = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .take(MOST_ENTRIES)
        .flatten();
    let mut names: Vec<String> = entries
        .filter(|entry| !is_folder || entry.path().is_dir())
        .filter_map(|entry| name(&entry.path()))
        .filter(|name| !name.starts_with('.'))
        .collect();
    names.sort();
    let (alike, others): (Vec<String>, Vec<String>) =
        names.into_iter().partition(|name| is_alike(&wanted, name));
    let of_kind = |name: &String| !is_folder && extension(name) == extension(&wanted);
    let others: Vec<String> = others.into_iter().filter(of_kind).collect();
    let place = match folder == Path::new(".") {
        true => "this folder".to_owned(),
        false => shown(folder),
    };
    let missing = match is_folder {
        true => format!("there is no folder {}; ", shown(asked)),
        false => String::new(),
    };
    let listed = |names: &[String]| {
        let first: Vec<String> = names.iter().take(MOST_SHOWN).map(shown).collect();
        let more = match names.len().saturating_sub(MOST_SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        format!("{}{more}", first.join(", "))
    };
    match (alike.as_slice(), others.as_slice(), is_folder) {
        ([], [], true) => format!("there is no folder {}", shown(asked)),
        ([], [], false) => match extension(&wanted) {
            Some(extension) => format!("{place} has no .{} file", shown(extension)),
            None => format!("{place} has no file of a like name"),
        },
        ([], others, _) => format!("{missing}{place} has {}", listed(others)),
        (alike, _, _) => format!("{missing}{place} has {}", listed(alike)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_names_come_first_then_files_of_the_kind() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        for name in ["step30.csv", "ramp.csv", "chirp.csv", "notes.txt"] {
            fs::write(at(name), "").expect("a file");
        }
        let hint_for = |name: &str| {
            let path = at(name).display().to_string();
            let message = format!("error: {path}: No such file or directory (os error 2)");
            hint(&message, None)
                .expect("a hint")
                .replace(&folder.path().display().to_string(), "F")
        };
        assert_eq!(hint_for("step3.csv"), "F has step30.csv");
        assert_eq!(hint_for("x.csv"), "F has chirp.csv, ramp.csv, step30.csv");
        assert_eq!(hint_for("x.toml"), "F has no .toml file");
        assert_eq!(hint_for("runs/x.csv"), "there is no folder F/runs");
        assert_eq!(hint("error: a.csv: the disk is gone", None), None);
    }
}
