//! Values of a direction column: a few numbers, or a few words such as CW and CCW.

use super::super::map::Backwards;
use super::column::Column;

/// Pairs of words for forwards and backwards, in lower case.
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

/// The different values of a direction column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marks {
    /// The index in `levels` for each row; `None` for rows without one.
    pub rows: Vec<Option<usize>>,
    /// The different numbers, ascending, or the different words.
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

    /// Index of this number or word.
    pub fn find(&self, backwards: &Backwards) -> Option<usize> {
        self.levels.iter().position(|level| level == backwards)
    }

    /// The indices of forwards and backwards by their words.
    pub fn pair(&self) -> Option<(usize, usize)> {
        let find = |wanted: &str| {
            let is_it = |level: &Backwards| matches!(level, Backwards::Word(word) if word.to_lowercase() == wanted);
            self.levels.iter().position(is_it)
        };
        (PAIRS.into_iter()).find_map(|(forwards, backwards)| find(forwards).zip(find(backwards)))
    }
}
