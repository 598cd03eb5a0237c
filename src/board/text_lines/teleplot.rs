//! Lines of Teleplot, one per signal: `>counts:590:17` with milliseconds, `>counts:17§unit|flags` without; and of
//! MegunoLink, such as `{TIMEPLOT|DATA|counts|T|17}`.
//!
//! The signals of one time, or up to the first repetition, are combined into one labelled line.

#[derive(Debug, Clone, Copy)]
pub(super) struct Signal<'a> {
    name: &'a str,
    ms: Option<&'a str>,
    value: &'a str,
}

impl<'a> Signal<'a> {
    /// The signal of a line with a single sample.
    pub fn of(line: &'a str) -> Option<Self> {
        if let Some(rest) = line.strip_prefix("{TIMEPLOT") {
            return Self::of_megunolink(rest);
        }
        let (name, rest) = line.strip_prefix('>')?.split_once(':')?;
        let rest = rest.split(['|', '§']).next()?;
        let (ms, value) = match rest.split_once(':') {
            Some((ms, value)) => (Some(ms.trim()), value.trim()),
            None => (None, rest.trim()),
        };
        let is_number = |text: &str| text.parse::<f64>().is_ok();
        let is_one = ms.is_none_or(is_number) && is_number(value) && !name.contains(' ');
        is_one.then_some(Self { name, ms, value })
    }

    /// The text after `{TIMEPLOT`: a channel, if any, then the parts. Its time is that of the arrival.
    fn of_megunolink(rest: &'a str) -> Option<Self> {
        let (_, parts) = rest.strip_suffix('}')?.split_once("|DATA|")?;
        let (name, value) = parts.split_once("|T|")?;
        let name = name.split(':').next()?.trim();
        let value = value.trim();
        let is_one = value.parse::<f64>().is_ok() && !name.is_empty() && !name.contains(' ');
        is_one.then_some(Self {
            name,
            ms: None,
            value,
        })
    }
}

/// Signals of a line that is not complete.
#[derive(Debug, Clone, Default)]
pub(super) struct Teleplot {
    names: Vec<String>,
    ms: Option<String>,
    row: Row,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Row {
    pub text: String,
    /// Bytes of the signals' lines.
    pub wire_bytes: usize,
}

impl Teleplot {
    /// Adds a signal; returns the completed line if this one begins another.
    pub fn push(&mut self, signal: &Signal<'_>, wire_bytes: usize) -> Option<Row> {
        let comes_again = self.names.iter().any(|name| name == signal.name);
        let is_next = comes_again || self.ms.as_deref() != signal.ms;
        let whole = (is_next && !self.names.is_empty()).then(|| std::mem::take(&mut self.row));
        if is_next {
            self.names.clear();
            self.row.text = match signal.ms {
                Some(ms) => format!("t_ms:{ms}"),
                None => String::new(),
            };
            self.ms = signal.ms.map(str::to_owned);
        }
        self.names.push(signal.name.to_owned());
        self.row
            .text
            .push_str(&format!(" {}:{}", signal.name, signal.value));
        self.row.wire_bytes += wire_bytes;
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_with_one_time_are_one_line() {
        let mut teleplot = Teleplot::default();
        let mut rows = Vec::new();
        for line in [
            ">counts:10:5",
            ">pwm:10:80",
            ">counts:20:6",
            ">pwm:20:81|np",
            ">counts:30:7",
        ] {
            let signal = Signal::of(line).expect("a signal");
            rows.extend(teleplot.push(&signal, line.len() + 1));
        }
        let texts: Vec<&str> = rows.iter().map(|row| row.text.as_str()).collect();
        assert_eq!(
            texts,
            ["t_ms:10 counts:5 pwm:80", "t_ms:20 counts:6 pwm:81"]
        );
        assert_eq!(rows[0].wire_bytes, 24);
        let mut untimed = Teleplot::default();
        let rows: Vec<Row> = [">counts:5", ">pwm:80§%", ">counts:6"]
            .iter()
            .filter_map(|line| untimed.push(&Signal::of(line).expect("a signal"), 9))
            .collect();
        assert_eq!(rows[0].text, " counts:5 pwm:80");
        let mut megunolink = Teleplot::default();
        let rows: Vec<Row> = [
            "{TIMEPLOT|DATA|counts|T|5}",
            "{TIMEPLOT:M|DATA|pwm:b|T|-80.5}",
            "{TIMEPLOT|DATA|counts|T|6}",
        ]
        .iter()
        .filter_map(|line| megunolink.push(&Signal::of(line).expect("a signal"), 9))
        .collect();
        assert_eq!(rows[0].text, " counts:5 pwm:-80.5");
        assert!(Signal::of("{TIMEPLOT|CLEAR}").is_none());
        assert!(Signal::of("> counts").is_none() && Signal::of(">counts:up").is_none());
    }
}
