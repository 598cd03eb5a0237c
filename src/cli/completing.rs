//! Completions within a word, such as the effect in `virtual:?effect=`; called by every shell's script.

use super::names::{SHARES, TIMES, parameters_of};
use super::schema::documents;
use super::virtual_spec::BOARD_KEYS;
use crate::board::BUILT_IN;
use crate::board::text_lines::Column;
use crate::motor::Parameters;
use crate::motor::catalogue::{Stage, catalogue, find};

/// Words that begin with `word` and may follow `before`; none where only the parser's grammar knows.
pub(super) fn completing(before: &str, word: &str) -> Vec<String> {
    let Some((stem, names)) = proposed(before, word) else {
        return Vec::new();
    };
    let words = names.into_iter().map(|name| format!("{stem}{name}"));
    words.filter(|known| known.starts_with(word)).collect()
}

/// The fixed part of a word, and its possible continuations.
fn proposed<'a>(before: &str, word: &'a str) -> Option<(&'a str, Vec<String>)> {
    let behind = |sign: char| word.rfind(sign).map(|at| &word[..=at]);
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    match before {
        "--profile" => Some(match (behind(','), behind('@')) {
            (Some(stem), _) => (stem, owned(&TIMES)),
            (None, Some(stem)) => (stem, owned(&SHARES)),
            (None, None) => ("", owned(&BUILT_IN.map(|(name, _)| name))),
        }),
        "--columns" => {
            let columns = Column::printed().into_iter().map(Column::name);
            Some((
                behind(',').unwrap_or_default(),
                columns.map(str::to_owned).collect(),
            ))
        }
        "effects" => Some((
            "",
            ids()
                .chain(Stage::ALL.map(Stage::id).map(str::to_owned))
                .collect(),
        )),
        "schema" => Some(("", documents().map(str::to_owned).collect())),
        _ if before == "--board" || word.starts_with("virtual:") => Some(of_a_board(word)),
        _ => None,
    }
}

fn ids() -> impl Iterator<Item = String> {
    catalogue().iter().map(|kind| kind.id.to_owned())
}

/// For a virtual board: keys, including those of its effect, or effects.
fn of_a_board(word: &str) -> (&str, Vec<String>) {
    const EFFECT: &str = "effect=";
    if word == "virtual:" {
        return (word, keys("").map(|key| format!("?{key}")).collect());
    }
    let stem = word.rfind(['&', '?', ':']).map_or(0, |at| at + 1);
    if word[stem..].starts_with(EFFECT) {
        return (&word[..stem + EFFECT.len()], ids().collect());
    }
    let named = word[..stem]
        .rsplit_once(EFFECT)
        .map_or("", |(_, after)| after);
    let effect = named.split('&').next().unwrap_or_default();
    (&word[..stem], keys(effect).collect())
}

fn keys(effect: &str) -> impl Iterator<Item = String> {
    let of_effect = find(effect).map_or_else(Vec::new, |(_, kind)| parameters_of(kind));
    let board = BOARD_KEYS.iter().map(|(key, _)| *key);
    (of_effect.into_iter().chain(["effect"]).chain(board))
        .chain(Parameters::KEYS)
        .map(|key| format!("{key}="))
}
