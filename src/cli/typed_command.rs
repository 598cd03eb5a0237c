//! The command line as typed, without output options, for messages that propose the next command.

use crate::plain::quoted;

/// Flags of `diagnose` that change no figure, and whether a value follows.
const WRITING: [(&str, bool); 6] = [
    ("--json", false),
    ("--explain", false),
    ("--force", false),
    ("--html", true),
    ("--model-out", true),
    ("--threads", true),
];

/// The words after the program's name as one command line.
pub(super) fn without_outputs(words: impl Iterator<Item = String>) -> String {
    let mut line = "motorlab".to_owned();
    let mut words = words;
    while let Some(word) = words.next() {
        let flag = word.split_once('=').map_or(word.as_str(), |(flag, _)| flag);
        match WRITING.iter().find(|(name, _)| *name == flag) {
            Some((_, true)) if flag == word => {
                words.next();
            }
            Some(_) => (),
            None => {
                line.push(' ');
                line.push_str(&quoted(&word));
            }
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_options_are_left_out() {
        let words = "diagnose a.csv --html why.html --json --motor=m.toml --html=x --model-out d.toml --threads 1 --good-enough 1%";
        let line = without_outputs(words.split(' ').map(str::to_owned));
        assert_eq!(
            line,
            "motorlab diagnose a.csv --motor=m.toml --good-enough 1%"
        );
        let spaced = ["diagnose", "my run.csv"].map(str::to_owned);
        assert_eq!(
            without_outputs(spaced.into_iter()),
            "motorlab diagnose 'my run.csv'"
        );
    }
}
