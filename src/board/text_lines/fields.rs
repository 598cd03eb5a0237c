//! The fields of a line: numbers with or without labels, units and brackets.

use super::Column;

/// Units directly after a number, as in `20ms` and `3.5V`.
const UNITS: &[&str] = &[
    "us", "\u{b5}s", "\u{3bc}s", "ms", "s", "v", "a", "rpm", "rad/s", "deg/s", "rev/s", "counts",
    "ticks", "%",
];

/// One field of a line: `value`, or `label:value`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field<'a> {
    pub label: Option<&'a str>,
    value: &'a str,
}

impl<'a> Field<'a> {
    /// Whether only blanks are between this number, which has no unit, and a field of the same text.
    fn is_before(&self, text: &str, field: &str) -> bool {
        let offset = |part: &str| (part.as_ptr() as usize).checked_sub(text.as_ptr() as usize);
        let between = (offset(self.value).map(|at| at + self.value.len())).zip(offset(field));
        let blanks = between.and_then(|(from, to)| text.get(from..to));
        parsed(self.value).is_some()
            && blanks.is_some_and(|between| between.bytes().all(|byte| byte == b' '))
    }

    /// The number without its unit.
    pub(super) fn number(&self) -> Option<f64> {
        self.parts().map(|parts| parts.0)
    }

    /// Meaning of its label, and the unit after its number.
    pub(super) fn column(&self) -> Option<Column> {
        let label = self.label?;
        let unit = self.parts().map_or("", |parts| parts.1);
        let with_unit = || {
            let unit = unit.replace(['\u{b5}', '\u{3bc}'], "u");
            Column::from_name(&format!("{label} ({unit})"))
        };
        match unit {
            "" => Column::from_name(label),
            _ => with_unit().or_else(|| Column::from_name(label)),
        }
    }

    /// Whether the number's unit of time differs from the column's.
    pub(super) fn contradicts(&self, column: Column) -> bool {
        let times = [Column::TimeSeconds, Column::TimeMillis, Column::TimeMicros];
        let unit = self.parts().map_or("", |parts| parts.1);
        let of_label = Field {
            label: Some("t"),
            ..*self
        }
        .column();
        !unit.is_empty()
            && times.contains(&column)
            && of_label.is_some_and(|of_label| of_label != column)
    }

    /// The number and its unit.
    fn parts(&self) -> Option<(f64, &'a str)> {
        if let Some(number) = parsed(self.value) {
            return Some((number, ""));
        }
        let lower = self.value.to_lowercase();
        let unit = UNITS
            .iter()
            .filter(|unit| lower.ends_with(**unit))
            .max_by_key(|unit| unit.len())?;
        let at = self.value.len().checked_sub(unit.len())?;
        let (number, unit) = self.value.split_at_checked(at)?;
        parsed(number.trim_end()).map(|number| (number, unit))
    }
}

/// A number; a comma is a decimal one.
fn parsed(text: &str) -> Option<f64> {
    match text.parse() {
        Ok(number) => Some(number),
        Err(_) => text.replacen(',', ".", 1).parse().ok(),
    }
}

/// Whether commas are decimal: another separator is present, and each comma is between digits.
fn has_decimal_commas(text: &str) -> bool {
    let bytes = text.as_bytes();
    let is_digit = |at: Option<usize>| {
        at.and_then(|at| bytes.get(at))
            .is_some_and(u8::is_ascii_digit)
    };
    let mut commas = text.match_indices(',');
    text.contains([';', '\t'])
        && commas.all(|(at, _)| is_digit(at.checked_sub(1)) && is_digit(Some(at + 1)))
}

/// The time stamp before a message: `I (590) motor: ` of ESP-IDF in milliseconds, `[0.590] ` in seconds, `[590ms] `
/// with unit.
fn stamp(text: &str) -> Option<(Field<'_>, &str)> {
    let (label, value, rest) = match text.strip_prefix('[') {
        Some(inside) => {
            let (value, rest) = inside.split_once("] ")?;
            // A list of numbers in brackets has no labels.
            let label = match value.ends_with(|c: char| c.is_ascii_digit()) {
                true => "t_s",
                false => "t",
            };
            (label, value, rest.contains([':', '=']).then_some(rest)?)
        }
        None => {
            let level = text.strip_prefix(['E', 'W', 'I', 'D', 'V'])?;
            let (value, rest) = level.strip_prefix(" (")?.split_once(") ")?;
            ("t_ms", value, rest.split_once(": ")?.1)
        }
    };
    let label = Some(label);
    let field = Field { label, value };
    let is_number = field.number().is_some_and(|number| number >= 0.0);
    is_number.then_some((field, rest))
}

/// A unit after a blank.
fn is_unit(text: &str) -> bool {
    UNITS.contains(&text.to_lowercase().as_str())
}

/// Splits at commas (except decimal ones), semicolons, tabs and blanks. Brackets and quotation marks of Python and
/// JSON separate fields as well.
pub(super) fn split(text: &str) -> Vec<Field<'_>> {
    let parts = [',', ';', '\t', ' ', '(', ')', '[', ']', '{', '}', '"', '\''];
    let (stamp, text) = stamp(text).map_or((None, text), |(field, rest)| (Some(field), rest));
    let has_decimal_commas = has_decimal_commas(text);
    // With blanks as the only separator a word that is a unit may be a field, except after a labelled number.
    let has_marks = text.contains([',', ';', '\t']);
    let is_between = |c: char| parts.contains(&c) && !(c == ',' && has_decimal_commas);
    let mut out: Vec<Field> = stamp.into_iter().collect();
    for field in text.split(is_between).filter(|field| !field.is_empty()) {
        let (label, value) = match field.split_once([':', '=']) {
            Some((label, value)) => (Some(label), value),
            None => (None, field),
        };
        match out.last_mut() {
            // `20 ms, 3.5 V`: blank before the unit.
            Some(last)
                if (has_marks || last.label.is_some())
                    && label.is_none()
                    && is_unit(field)
                    && last.is_before(text, field) =>
            {
                let from = last.value.as_ptr() as usize - text.as_ptr() as usize;
                let to = field.as_ptr() as usize - text.as_ptr() as usize + field.len();
                last.value = &text[from..to];
            }
            // `label: value`: blank after the colon.
            Some(last) if last.value.is_empty() && last.label.is_some() && label.is_none() => {
                last.value = value;
            }
            // `"label": value`: quotation mark before the colon.
            Some(last) if label == Some("") && last.label.is_none() => {
                *last = Field {
                    label: Some(last.value),
                    value,
                };
            }
            _ => out.push(Field { label, value }),
        }
    }
    out
}

/// Names in a header may contain blanks if another separator is used: `Time [us], Encoder counts`.
pub(super) fn split_header(text: &str) -> impl Iterator<Item = &str> {
    let separators: &[char] = if text.contains([',', ';', '\t']) {
        &[',', ';', '\t']
    } else {
        &[' ']
    };
    text.split(separators)
        .filter(|name| !name.trim().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_brackets_and_quotation_marks_are_stripped_from_numbers() {
        let numbers =
            |text: &str| -> Vec<Option<f64>> { split(text).iter().map(Field::number).collect() };
        let expected = [Some(20.0), Some(3.0), Some(-255.0)];
        for text in [
            "20,3,-255",
            "(20, 3, -255)",
            "[20 3 -255]",
            "time:20ms\tpos:3\tpwm:-255",
            "t=20ms pos=3counts pwm=-255",
            "{\"t_ms\": 20, \"pos\": 3, \"pwm\": -255}",
            "{\"t_ms\":20,\"pos\":3,\"pwm\":-255}",
            "20,0;3;-255,0",
            "20,0\t3\t-255,00",
            "I (20) motor: pos=3 duty=-255",
            "[20.0] pos: 3, duty: -255%",
            "[20ms] pos: 3, duty: -255%",
            "20 ms; 3; -255 %",
            "20 ms,3 counts,-255",
        ] {
            assert_eq!(numbers(text), expected, "{text}");
        }
        assert_eq!(numbers("9x0 5kg ms"), [None, None, None]);
        // With blanks as the only separator a unit is a word.
        assert_eq!(numbers("20 A 3"), [Some(20.0), None, Some(3.0)]);
    }

    #[test]
    fn the_unit_after_a_number_belongs_to_its_label() {
        let columns =
            |text: &str| -> Vec<Option<Column>> { split(text).iter().map(Field::column).collect() };
        assert_eq!(
            columns("time:20ms t=0.020s time:20\u{b5}s pos:3 u:4.5V"),
            [
                Some(Column::TimeMillis),
                Some(Column::TimeSeconds),
                Some(Column::TimeMicros),
                Some(Column::Counts),
                Some(Column::CommandVolts),
            ]
        );
        assert_eq!(
            columns("{\"t_ms\": 20, \"state\": 3}"),
            [Some(Column::TimeMillis), None]
        );
        assert_eq!(
            columns("[20ms] pos: 3, u: 4.5 V"),
            [
                Some(Column::TimeMillis),
                Some(Column::Counts),
                Some(Column::CommandVolts)
            ]
        );
        assert_eq!(
            columns("time: 0.02 s pos:3 counts duty:40.0 %"),
            [
                Some(Column::TimeSeconds),
                Some(Column::Counts),
                Some(Column::CommandPercent)
            ]
        );
        let first = |text| split(text)[0];
        assert!(first("20 us,3").contradicts(Column::TimeMillis));
        assert!(!first("20 ms,3").contradicts(Column::TimeMillis));
        assert!(!first("20,3").contradicts(Column::TimeMillis));
    }
}
