//! Marks between thousands in spreadsheets: `1,234,567` and `1.234,5`.
//!
//! A number with two groups, or with a group and a decimal mark, determines the mark. One group alone may be three
//! decimals: then the neighbours in its column decide, since `998` and `1,002` are consecutive as one thousand and
//! two.
//! neighbours in its column tell, since `998` and `1,002` go on as one thousand and two does.

use super::super::cells::{Cells, grouped, number, without_groups};

/// A number of a column, in both interpretations.
#[derive(Debug, Clone, Copy)]
struct Both {
    is_grouped: bool,
    as_decimals: f64,
    as_thousands: f64,
}

/// Evidence of one column for a mark.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    before: Option<Both>,
    /// Numbers that can only have thousands, and numbers in which the mark is a decimal one.
    sure: usize,
    decimal: usize,
    /// Neighbours that are closer as thousands, and as decimals.
    nearer: usize,
    farther: usize,
}

#[derive(Debug)]
pub(super) struct Thousands {
    mark: u8,
    columns: Vec<Seen>,
}

impl Thousands {
    pub fn of(mark: u8) -> Self {
        let columns = Vec::new();
        Self { mark, columns }
    }

    /// Adds a row.
    pub fn take(&mut self, cells: &Cells) {
        self.columns
            .resize(self.columns.len().max(cells.len()), Seen::default());
        for (at, seen) in self.columns.iter_mut().enumerate() {
            seen.take(cells.get(at), self.mark);
        }
    }

    /// The mark, if it separates thousands.
    pub fn mark(&self) -> Option<u8> {
        let sum = |of: fn(&Seen) -> usize| self.columns.iter().map(of).sum::<usize>();
        let is_near = sum(|seen| seen.nearer) > 0 && sum(|seen| seen.farther) == 0;
        let is_thousands = sum(|seen| seen.sure) > 0 || is_near;
        (is_thousands && sum(|seen| seen.decimal) == 0).then_some(self.mark)
    }
}

impl Seen {
    fn take(&mut self, cell: &[u8], mark: u8) {
        let groups = grouped(cell, mark);
        let has_mark = cell.contains(&mark);
        self.sure += usize::from(groups.is_some_and(|groups| groups.is_sure));
        if has_mark && groups.is_none() {
            self.decimal += usize::from(number(cell, true, "").is_ok());
            self.before = None;
            return;
        }
        let stripped = without_groups(cell, mark);
        let now = (number(cell, true, "").ok()).zip(number(&stripped, true, "").ok());
        let now = now.map(|(as_decimals, as_thousands)| Both {
            is_grouped: groups.is_some(),
            as_decimals,
            as_thousands,
        });
        if let (Some(now), Some(before)) = (now, self.before)
            && now.is_grouped != before.is_grouped
        {
            let jump = |of: fn(&Both) -> f64| (of(&now) - of(&before)).abs();
            match jump(|both| both.as_thousands) < jump(|both| both.as_decimals) {
                true => self.nearer += 1,
                false => self.farther += 1,
            }
        }
        self.before = now;
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::cells::Separator;
    use super::*;

    fn mark(lines: &[&str], mark: u8) -> Option<u8> {
        let mut found = Thousands::of(mark);
        let mut cells = Cells::default();
        for line in lines {
            cells.split(line.as_bytes(), Separator::Byte(b';'));
            found.take(&cells);
        }
        found.mark()
    }

    #[test]
    fn thousands_separators_are_separated_from_decimals() {
        assert_eq!(mark(&["0;990,000", "10,000;1,000,000"], b','), Some(b','));
        assert_eq!(mark(&["990;5", "1,002;5", "1,014;6"], b','), Some(b','));
        assert_eq!(mark(&["990;5", "1.002;5", "1.014;6"], b'.'), Some(b'.'));
        assert_eq!(mark(&["1.234,5;5", "1.240,5;5"], b'.'), Some(b'.'));
        // Decimals: other counts of digits, levels, and a first digit of 0.
        assert_eq!(mark(&["1,234;5", "1,3;5", "2;5"], b','), None);
        assert_eq!(mark(&["0;5", "1.125;5", "0;5"], b'.'), None);
        assert_eq!(mark(&["0,998;5", "1,002;5", "1,014;6"], b','), None);
        assert_eq!(mark(&["1.002;5", "1.014;6"], b'.'), None);
    }
}
