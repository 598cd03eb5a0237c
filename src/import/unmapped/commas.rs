//! Detection of decimal commas in comma-separated rows, whose cells and fractions cannot be separated.

pub(super) const COMMAS_WITHIN: &str = "where commas are between the cells and within the numbers, a number is read as two columns; \
                             hint: export it with semicolons between the cells, or with decimal points";

/// Cells of one column. Those of a fraction have equally many digits in every row, and some begin with a zero.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Width {
    digits: Option<usize>,
    has_other_cells: bool,
    has_leading_zero: bool,
}

impl Width {
    pub fn take(&mut self, cell: &[u8]) {
        let digits = *self.digits.get_or_insert(cell.len());
        self.has_other_cells |= digits != cell.len() || !cell.iter().all(u8::is_ascii_digit);
        self.has_leading_zero |= cell.len() > 1 && cell[0] == b'0';
    }

    pub fn is_padded(&self) -> bool {
        self.has_leading_zero && !self.has_other_cells
    }
}
