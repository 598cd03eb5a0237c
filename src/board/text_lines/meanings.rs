//! Description of each column of a text line.

use super::columns::{Column, NAMES};

impl Column {
    /// Every column once, by its printed name.
    pub fn printed() -> Vec<Self> {
        let mut columns: Vec<Self> = NAMES.iter().map(|(_, column)| *column).collect();
        columns.dedup();
        columns
    }

    /// Content.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::TimeMicros => "the board's time in microseconds, as micros() gives it",
            Self::TimeMillis => "the board's time in milliseconds, as millis() gives it",
            Self::TimeSeconds => "the board's time in s",
            Self::Sequence => "number of the sample",
            Self::Counts => "counts of the encoder",
            Self::Increments => "counts since the line before; they are summed up",
            Self::Speed(_) => "a speed by its unit; it is summed up over time",
            Self::CommandVolts => "the command in V",
            Self::CommandPwm255 => "the command as analogWrite has it: -255 to 255",
            Self::CommandPercent => "the command in per cent of full drive",
            Self::SupplyVolts => "the measured supply in V",
            Self::CurrentAmperes => "the measured current in A",
            Self::Ignored => "nothing that is used: leaves a column out",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_is_listed_once() {
        let names: Vec<&str> = Column::printed().into_iter().map(Column::name).collect();
        assert_eq!(names.join(", "), Column::names());
        let mut once = names.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), names.len());
    }
}
