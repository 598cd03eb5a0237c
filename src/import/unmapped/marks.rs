//! Meaning of a direction column: a few numbers, or a few words such as CW and CCW.

use super::super::map::Backwards;
use super::column::Column;

/// Words for forwards and backwards that go together, in small letters.
const PAIRS: [(&str, &str); 9] = [
    ("cw", "ccw"),
    ("f", "r"),
    ("f", "b"),
    ("fwd", "rev"),
    ("fwd", "bwd"),
    ("forward", "reverse"),
    ("forward", "backward"),
    ("forwards", "backwards"),
    ("+", "-"),
];

/// The levels of a column of directions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marks {
    /// The level of each row, from 0 in the order of `levels`; none where it has none.
    pub rows: Vec<Option<usize>>,
    /// The different numbers, least first, or the different words.
    pub levels: Vec<Backwards>,
}

impl Marks {
    pub fn of(column: &Column) -> Self {
        if column.is_numeric() {
            let levels = column.levels();
            let at = |number: &f64| levels.iter().position(|level| level == number);
            return Self {
                rows: column.numbers.iter().map(at).collect(),
                levels: levels.iter().copied().map(Backwards::Number).collect(),
            };
        }
        Self {
            rows: column.words_at.clone(),
            levels: (column.words.iter().cloned())
                .map(Backwards::Word)
                .collect(),
        }
    }

    /// The level of this number or word.
    pub fn find(&self, said: &Backwards) -> Option<usize> {
        self.levels.iter().position(|level| level == said)
    }

    /// The levels that are forwards and backwards by their words.
    pub fn pair(&self) -> Option<(usize, usize)> {
        let find = |wanted: &str| {
            let is_it = |level: &Backwards| matches!(level, Backwards::Word(word) if word.to_lowercase() == wanted);
            self.levels.iter().position(is_it)
        };
        (PAIRS.into_iter()).find_map(|(forwards, backwards)| find(forwards).zip(find(backwards)))
    }
}
