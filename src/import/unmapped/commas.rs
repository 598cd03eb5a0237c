//! Signs of decimal commas between comma-separated cells, where the cells cannot be separated.

/// Cause of more cells than columns, and the remedy.
pub(super) const COMMAS_WITHIN: &str = "where commas are between the cells and within the numbers, a number is read as two columns; \
                             hint: export it with semicolons between the cells, or with decimal points";

/// Cells with as many digits in every row, a zero before others in one of them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Width {
    digits: Option<usize>,
    is_other: bool,
    begins_with_zero: bool,
}

impl Width {
    pub fn take(&mut self, cell: &[u8]) {
        let digits = *self.digits.get_or_insert(cell.len());
        self.is_other |= digits != cell.len() || !cell.iter().all(u8::is_ascii_digit);
        self.begins_with_zero |= cell.len() > 1 && cell[0] == b'0';
    }

    pub fn is_padded(&self) -> bool {
        self.begins_with_zero && !self.is_other
    }
}
