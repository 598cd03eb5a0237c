//! Dates in file names.

use time::{Date, Month};

/// Length of a date as in `2026-03-01`.
pub(super) const DATE_LENGTH: usize = 10;

/// The first date as in `2026-03-01` in a text, and its byte position.
pub(super) fn date_in(text: &str) -> Option<(usize, Date)> {
    (0..text.len().checked_sub(DATE_LENGTH - 1)?).find_map(|at| {
        let part = text.get(at..at + DATE_LENGTH)?;
        let mut numbers = part.split('-');
        let mut next = |digits: usize| {
            let number = numbers.next().filter(|number| number.len() == digits)?;
            number
                .bytes()
                .all(|digit| digit.is_ascii_digit())
                .then_some(number)
        };
        let (year, month, day) = (next(4)?, next(2)?, next(2)?);
        let month = Month::try_from(month.parse::<u8>().ok()?).ok()?;
        let date = Date::from_calendar_date(year.parse().ok()?, month, day.parse().ok()?).ok()?;
        Some((at, date))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_in_names_are_found_and_other_numbers_are_not() {
        let found = |text| date_in(text).map(|(at, date)| (at, date.to_string()));
        assert_eq!(
            found("axis7_2026-03-01"),
            Some((6, "2026-03-01".to_owned()))
        );
        assert_eq!(
            found("12026-02-29x2024-02-29"),
            Some((12, "2024-02-29".to_owned()))
        );
        for text in ["", "axis", "2026-3-01", "2026-13-01", "é026-01-01"] {
            assert_eq!(found(text), None, "{text}");
        }
    }
}
