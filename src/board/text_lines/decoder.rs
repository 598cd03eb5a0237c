//! Decoder of a text board's bytes: one line at a time into samples; every skipped line is reported with its reason.

use super::event::{Skipped, TextEvent, TextSample};
use super::fields::{Field, split, split_header};
use super::teleplot::{Signal, Teleplot};
use super::unwrapper::Unwrapper;
use super::{Column, ColumnError, Columns};

/// Longest line read; a longer one is skipped.
pub const MAX_LINE_BYTES: usize = 512;

/// Full drive as an 8-bit PWM value.
const FULL_PWM255: f64 = 255.0;
const MICROS_WRAP: i64 = 1 << 32;
const I16_WRAP: i64 = 1 << 16;

/// Streaming decoder of a text board's bytes. Never panics, buffers at most one line.
#[derive(Debug, Clone)]
pub struct TextDecoder {
    columns: Option<Columns>,
    /// The columns were given: labels do not change them.
    given: bool,
    /// The last line ended with a carriage return, whose newline may follow.
    after_return: bool,
    /// Length of the last line, if it was a sample.
    last_sample_bytes: usize,
    line: Vec<u8>,
    line_number: u64,
    overlong: bool,
    longest_line: usize,
    time: Unwrapper,
    counts: Unwrapper,
    /// A count outside 16 bits was seen: the board's counter is wider and does not wrap there.
    wide_counts: bool,
    teleplot: Teleplot,
}

impl TextDecoder {
    /// A decoder with these columns, or those of the first header or labelled line.
    ///
    /// The first line is usually incomplete, since the port is opened in the middle of one: it is skipped like any
    /// other invalid line.
    pub fn new(columns: Option<Columns>) -> Self {
        Self {
            given: columns.is_some(),
            after_return: false,
            last_sample_bytes: 0,
            columns,
            line: Vec::with_capacity(MAX_LINE_BYTES),
            line_number: 0,
            overlong: false,
            longest_line: 0,
            time: Unwrapper::default(),
            counts: Unwrapper::default(),
            wide_counts: false,
            teleplot: Teleplot::default(),
        }
    }

    /// The columns, once they are known.
    pub fn columns(&self) -> Option<&Columns> {
        self.columns.as_ref()
    }

    /// Length in bytes, end of line included, of the longest line that was a sample.
    pub fn longest_sample_line(&self) -> usize {
        self.longest_line
    }

    /// Whether the counter was seen to wrap at 16 bits.
    pub fn counts_wrap(&self) -> bool {
        !self.wide_counts && self.counts.has_wrapped()
    }

    /// Processes one byte; returns an event with the last byte of a line that is not blank.
    pub fn push(&mut self, byte: u8) -> Option<TextEvent> {
        if std::mem::take(&mut self.after_return) && byte == b'\n' {
            if self.last_sample_bytes > 0 {
                self.longest_line = self.longest_line.max(self.last_sample_bytes + 1);
            }
            return None;
        }
        self.after_return = byte == b'\r';
        if byte != b'\n' && byte != b'\r' {
            if self.line.len() < MAX_LINE_BYTES {
                self.line.push(byte);
            } else {
                self.overlong = true;
            }
            return None;
        }
        self.line_number += 1;
        self.last_sample_bytes = 0;
        let bytes = std::mem::take(&mut self.line);
        let overlong = std::mem::take(&mut self.overlong);
        let text = String::from_utf8_lossy(&bytes);
        let trimmed = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
        let event = if overlong {
            Some(self.skip(trimmed, Skipped::TooLong))
        } else if trimmed.is_empty() {
            None
        } else if let Some(signal) = Signal::of(trimmed) {
            let row = self.teleplot.push(&signal, bytes.len() + 1);
            row.map(|row| self.read_line(&row.text, row.wire_bytes))
        } else {
            Some(self.read_line(trimmed, bytes.len() + 1))
        };
        self.line = bytes;
        self.line.clear();
        event
    }

    fn skip(&self, text: &str, why: Skipped) -> TextEvent {
        TextEvent::Skipped {
            line: self.line_number,
            why,
            text: text.to_owned(),
        }
    }

    fn read_line(&mut self, text: &str, wire_bytes: usize) -> TextEvent {
        let fields = split(text);
        if fields.iter().any(|field| field.label.is_some()) {
            return self.read_labelled(text, &fields, wire_bytes);
        }
        let Some(numbers) = self.numbers(&fields) else {
            return self.read_header(text, &fields);
        };
        // The first line may be incomplete: its fields are not counted.
        if self.columns.is_none() && numbers.len() == 1 && self.line_number > 1 {
            self.columns = Columns::new(vec![Column::Counts]).ok();
        }
        let Some(columns) = self.columns.clone() else {
            return self.skip(text, Skipped::ColumnsUnknown);
        };
        if numbers.len() != columns.as_slice().len() {
            let (expected, found) = (columns.as_slice().len(), numbers.len());
            return self.skip(text, Skipped::FieldCount { expected, found });
        }
        self.sample(text, columns.as_slice(), &numbers, wire_bytes)
    }

    /// The numbers of a line; an ignored column may contain text, which gives 0.
    fn numbers(&self, fields: &[Field]) -> Option<Vec<f64>> {
        let columns = self.columns.as_ref().map_or(&[][..], Columns::as_slice);
        if columns.len() == fields.len() {
            return numbers_of(fields, columns);
        }
        fields.iter().map(Field::number).collect()
    }

    /// `t_us:1200 counts:17`: each line states its columns.
    fn read_labelled(&mut self, text: &str, fields: &[Field], wire_bytes: usize) -> TextEvent {
        if let Some(columns) = self.columns.clone().filter(|_| self.given) {
            return match self.numbers(fields) {
                Some(numbers) => self.read_by_given(text, fields, &numbers, &columns, wire_bytes),
                None => self.skip(text, Skipped::NotNumbers),
            };
        }
        let columns: Vec<Column> = (fields.iter())
            .map(|field| field.column().unwrap_or(Column::Ignored))
            .collect();
        let Some(numbers) = numbers_of(fields, &columns) else {
            return self.skip(text, Skipped::NotNumbers);
        };
        match Columns::new(columns) {
            Ok(columns) => {
                let event = self.sample(text, columns.as_slice(), &numbers, wire_bytes);
                self.columns = Some(columns);
                event
            }
            Err(ColumnError::NoCounts) if self.columns.is_none() => {
                let labels: Vec<&str> = fields.iter().filter_map(|field| field.label).collect();
                let labels = labels.join(",");
                self.skip(text, Skipped::NoCountsLabelled { labels })
            }
            Err(error) if self.columns.is_none() => TextEvent::BadHeader(error),
            Err(_) => self.skip(text, Skipped::NotNumbers),
        }
    }

    /// A labelled line with given columns: their names and units apply, in the line's order; a label with another
    /// known meaning is a clash.
    fn read_by_given(
        &mut self,
        text: &str,
        fields: &[Field],
        numbers: &[f64],
        columns: &Columns,
        wire_bytes: usize,
    ) -> TextEvent {
        let columns = columns.as_slice();
        if columns.len() != fields.len() {
            let (expected, found) = (columns.len(), fields.len());
            return self.skip(text, Skipped::FieldCount { expected, found });
        }
        let clash = fields.iter().zip(columns).find_map(|(field, &column)| {
            let label = field.label?;
            let known = Column::from_name(label)?;
            (column != Column::Ignored && !known.is_kind_of(column)).then_some((label, column))
        });
        if let Some((label, column)) = clash {
            let (label, column) = (label.to_owned(), column.name());
            return self.skip(text, Skipped::Clash { label, column });
        }
        self.sample(text, columns, numbers, wire_bytes)
    }

    /// A line of words is a header if most of them name columns, counts among them; else a banner.
    fn read_header(&mut self, text: &str, fields: &[Field]) -> TextEvent {
        let columns: Vec<_> = split_header(text).map(Column::from_name).collect();
        let known = columns.iter().flatten().count();
        let words = fields.iter().filter(|field| field.number().is_none());
        if self.columns.is_some() || words.count() < fields.len() || 2 * known < columns.len() {
            return self.skip(text, Skipped::NotNumbers);
        }
        let columns = columns.into_iter().map(|c| c.unwrap_or(Column::Ignored));
        match Columns::new(columns.collect()) {
            Ok(columns) => {
                self.columns = Some(columns.clone());
                TextEvent::Header(columns)
            }
            Err(error) => TextEvent::BadHeader(error),
        }
    }

    fn sample(
        &mut self,
        text: &str,
        columns: &[Column],
        numbers: &[f64],
        wire_bytes: usize,
    ) -> TextEvent {
        let mut sample = TextSample::default();
        let mut raw_time = None;
        for (&column, &value) in columns.iter().zip(numbers) {
            let whole = value.fract() == 0.0 && value.abs() < 9e15;
            let good = match column {
                Column::Ignored => true,
                Column::Counts
                | Column::Increments
                | Column::Sequence
                | Column::TimeMicros
                | Column::TimeMillis => whole,
                Column::TimeSeconds => value.abs() < 9e9,
                _ => value.is_finite(),
            };
            if !good {
                let column = column.name();
                return self.skip(text, Skipped::BadValue { column });
            }
            match column {
                Column::TimeMicros => raw_time = Some((value as i64, MICROS_WRAP)),
                Column::TimeMillis => raw_time = Some((value as i64 * 1000, MICROS_WRAP * 1000)),
                Column::TimeSeconds => raw_time = Some(((value * 1e6).round() as i64, i64::MAX)),
                Column::Sequence => sample.sequence = u64::try_from(value as i64).ok(),
                Column::Counts => sample.counts = value as i64,
                Column::Increments | Column::Speed(_) => sample.summand = Some((column, value)),
                Column::CommandVolts => sample.command_v = Some(value),
                Column::CommandPwm255 => sample.command_pwm255 = Some(value),
                Column::CommandPercent => sample.command_pwm255 = Some(value * FULL_PWM255 / 100.0),
                Column::SupplyVolts => sample.supply_v = Some(value),
                Column::CurrentAmperes => sample.current_a = Some(value),
                Column::Ignored => {}
            }
        }
        sample.time_us = raw_time.map(|(value, wrap)| self.time.unwrap(value, wrap));
        self.wide_counts |= i16::try_from(sample.counts).is_err();
        if !self.wide_counts {
            sample.counts = self.counts.unwrap(sample.counts, I16_WRAP);
        }
        self.longest_line = self.longest_line.max(wire_bytes);
        self.last_sample_bytes = wire_bytes;
        TextEvent::Sample(sample)
    }
}

/// The numbers of fields with known columns; text in an ignored column is 0.
fn numbers_of(fields: &[Field], columns: &[Column]) -> Option<Vec<f64>> {
    let number = |(field, column): (&Field, &Column)| match column {
        Column::Ignored => Some(field.number().unwrap_or(0.0)),
        _ => field.number().filter(|_| !field.contradicts(*column)),
    };
    fields.iter().zip(columns).map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn events(decoder: &mut TextDecoder, text: &str) -> Vec<TextEvent> {
        text.bytes().filter_map(|b| decoder.push(b)).collect()
    }

    fn samples(events: Vec<TextEvent>) -> Vec<TextSample> {
        let sample = |event| match event {
            TextEvent::Sample(sample) => Some(sample),
            _ => None,
        };
        events.into_iter().filter_map(sample).collect()
    }

    #[test]
    fn every_separator_and_label_form_gives_the_same_sample() {
        let wanted = TextSample {
            time_us: Some(3000),
            counts: -17,
            command_v: Some(4.5),
            ..TextSample::default()
        };
        for line in [
            "3000,-17,4.5\r\n",
            "3000 -17 4.5\n",
            "3000\t-17\t4.50\n",
            "3000; -17; 4.5\n",
            "t_us:3000,counts:-17,command_v:4.5\n",
            "micros: 3000\tencoder: -17\tu: 4.5\n",
            "t_us=3000 counts=-17 command=4.5\n",
        ] {
            let columns = Columns::parse("t_us,counts,command_v").unwrap();
            let mut decoder = TextDecoder::new(Some(columns));
            assert_eq!(samples(events(&mut decoder, line)), [wanted], "{line}");
        }
    }

    #[test]
    fn given_columns_take_precedence_over_labels_and_a_conflict_is_no_sample() {
        let columns = Columns::parse("t_ms,counts,pwm").unwrap();
        let mut decoder = TextDecoder::new(Some(columns));
        let found = events(&mut decoder, "T:20 ENC:-17 PWM:255\nT=40 A0=1 ENC=3\n");
        assert!(matches!(&found[0], TextEvent::Sample(s) if s.time_us == Some(20_000)));
        assert!(matches!(
            &found[1],
            TextEvent::Skipped { why: Skipped::Clash { label, column: "pwm" }, .. } if label == "ENC"
        ));
    }

    #[test]
    fn lines_may_end_in_a_carriage_return_alone() {
        let columns = Columns::parse("t_us,counts").unwrap();
        let mut decoder = TextDecoder::new(Some(columns));
        let found = samples(events(&mut decoder, "1,2\r3001,5\r\n6001,8\r"));
        let counts: Vec<_> = found.iter().map(|s| s.counts).collect();
        assert_eq!((counts, decoder.longest_sample_line()), (vec![2, 5, 8], 8));
    }

    #[test]
    fn a_header_names_the_columns_and_banners_are_skipped() {
        let mut decoder = TextDecoder::new(None);
        let found = events(
            &mut decoder,
            "unt 12\nMotor lab v1.2 ready\nTime [us], Encoder, Temperature\n1,2,30\n\n4001,5,30\n",
        );
        assert!(matches!(found[0], TextEvent::Skipped { line: 1, .. }));
        assert!(matches!(found[1], TextEvent::Skipped { line: 2, .. }));
        assert!(matches!(&found[2], TextEvent::Header(c) if c.to_string() == "t_us,counts,-"));
        let samples = samples(found);
        assert_eq!(samples.len(), 2);
        assert_eq!((samples[1].time_us, samples[1].counts), (Some(4001), 5));
    }

    #[test]
    fn lines_without_known_columns_are_not_decoded() {
        let mut decoder = TextDecoder::new(None);
        let found = events(&mut decoder, "1 2 3\n");
        assert!(matches!(
            &found[0],
            TextEvent::Skipped { why: Skipped::ColumnsUnknown, text, .. } if text == "1 2 3"
        ));
    }

    #[test]
    fn a_torn_line_is_skipped_and_the_next_is_decoded() {
        let columns = Columns::parse("t_us,counts").unwrap();
        let mut decoder = TextDecoder::new(Some(columns));
        let found = events(&mut decoder, "300,1\n33\n900,3\n9x0,4\n");
        assert!(matches!(
            found[1],
            TextEvent::Skipped {
                why: Skipped::FieldCount {
                    expected: 2,
                    found: 1
                },
                line: 2,
                ..
            }
        ));
        assert_eq!(samples(found).len(), 2);
    }

    #[test]
    fn micros_and_sixteen_bit_counts_are_unwrapped() {
        let columns = Columns::parse("t_us,counts").unwrap();
        let mut decoder = TextDecoder::new(Some(columns));
        let found = samples(events(
            &mut decoder,
            "4294965000,32766\n704,-32767\n3704,-32760\n",
        ));
        let times: Vec<_> = found.iter().filter_map(|s| s.time_us).collect();
        assert_eq!(times, [4_294_965_000, 4_294_968_000, 4_294_971_000]);
        let counts: Vec<_> = found.iter().map(|s| s.counts).collect();
        assert_eq!(counts, [32766, 32769, 32776]);
    }

    #[test]
    fn counts_wider_than_sixteen_bits_do_not_wrap() {
        let columns = Columns::parse("counts").unwrap();
        let mut decoder = TextDecoder::new(Some(columns));
        let found = samples(events(&mut decoder, "32766\n32770\n32760\n-32768\n"));
        let counts: Vec<_> = found.iter().map(|s| s.counts).collect();
        assert_eq!(counts, [32766, 32770, 32760, -32768]);
    }

    #[test]
    fn an_endless_line_needs_the_memory_of_one_line() {
        let mut decoder = TextDecoder::new(None);
        for _ in 0..10 * MAX_LINE_BYTES {
            assert_eq!(decoder.push(b'7'), None);
        }
        assert!(decoder.line.capacity() <= 2 * MAX_LINE_BYTES);
        assert!(matches!(
            decoder.push(b'\n'),
            Some(TextEvent::Skipped {
                why: Skipped::TooLong,
                ..
            })
        ));
        assert!(matches!(events(&mut decoder, "5\n")[0], TextEvent::Sample(s) if s.counts == 5));
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_do_not_make_the_decoder_panic(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
            let mut decoder = TextDecoder::new(None);
            for byte in bytes {
                decoder.push(byte);
            }
        }

        #[test]
        fn printed_samples_are_read_back(
            rows in proptest::collection::vec((0u32.., any::<i32>(), -255i32..=255), 1..40),
            separator in prop_oneof![Just(","), Just("\t"), Just(" "), Just("; ")],
        ) {
            let columns = Columns::parse("t_us,counts,pwm").unwrap();
            let mut decoder = TextDecoder::new(Some(columns));
            let text: String = rows
                .iter()
                .map(|(t, n, pwm)| format!("{t}{separator}{n}{separator}{pwm}\r\n"))
                .collect();
            let found = samples(events(&mut decoder, &text));
            prop_assert_eq!(found.len(), rows.len());
            for (sample, (t, _, pwm)) in found.iter().zip(&rows) {
                prop_assert_eq!(sample.time_us.unwrap().rem_euclid(MICROS_WRAP), i64::from(*t));
                prop_assert_eq!(sample.command_pwm255, Some(f64::from(*pwm)));
            }
        }
    }
}
