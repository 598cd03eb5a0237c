//! The command line of a diagnosis, which the proposed next step repeats.

use crate::plain::quoted;
use crate::recording::Run;

/// The command line of a diagnosis of these runs; runs without a file are `RUN...`.
pub(crate) fn asked(runs: &[Run], held_out: &[Run], reference: &[Run]) -> String {
    let mut line = format!("motorlab diagnose {}", words(runs));
    for (flag, runs) in [("--hold-out", held_out), ("--reference", reference)] {
        if !runs.is_empty() {
            line.push_str(&format!(" {flag} {}", words(runs)));
        }
    }
    line
}

fn words(runs: &[Run]) -> String {
    let paths = runs.iter().map(|run| run.path.as_ref());
    let paths: Option<Vec<String>> = paths
        .map(|path| path.map(|path| quoted(&path.to_string_lossy())))
        .collect();
    paths.map_or_else(|| "RUN...".to_owned(), |paths| paths.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_quoted_and_other_arguments_are_printed_unchanged() {
        let named = |path: &str| Run {
            path: Some(path.into()),
            ..Run::default()
        };
        let runs = [named("a.csv"), named("b c.csv")];
        assert_eq!(asked(&runs, &[], &[]), "motorlab diagnose a.csv 'b c.csv'");
        assert_eq!(
            asked(&runs[..1], &[Run::default()], &runs[..1]),
            "motorlab diagnose a.csv --hold-out RUN... --reference a.csv"
        );
    }
}
