//! Bar charts with names, values and intervals.
//!
//! Name and value are above each bar, so that they need no separate width. Where they do not fit beside each other,
//! the name is wrapped and the value is on its own line.

use std::fmt::Write;

use super::escape::escaped;

/// One bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Name.
    pub name: String,
    /// Length.
    pub value: f64,
    /// The value as text.
    pub text: String,
    /// Its interval.
    pub interval: Option<(f64, f64)>,
    /// Index of its colour in the palette.
    pub colour: usize,
}

/// Scale from values to lengths: proportional, up to this value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale(pub f64);

impl Scale {
    /// Share of the full length, 0 to 1.
    pub fn share(self, value: f64) -> f64 {
        let share = value / self.0;
        if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        }
    }
}

/// Bars in rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Bars {
    /// Quantity.
    pub title: String,
    /// Scale from values to lengths.
    pub scale: Scale,
    /// Bars from the top.
    pub bars: Vec<Bar>,
}

const TITLE: f64 = 30.0;
const ROW: f64 = 36.0;
const THICK: f64 = 12.0;
const MARGIN: f64 = 8.0;
/// Height of an additional line of text.
const LINE: f64 = 16.0;
/// Width of a letter in [`super::svg::STYLE`]'s text, for the widest common fonts.
const LETTER: f64 = 7.0;

impl Bar {
    /// The name wrapped to this length; the value fits after the last line.
    fn lines(&self, long: f64) -> Vec<String> {
        let letters = |text: &str| text.chars().count();
        let most = (long / LETTER) as usize;
        let mut lines = vec![String::new()];
        for word in self.name.split(' ') {
            let last = lines.len() - 1;
            if lines[last].is_empty() {
                lines[last].push_str(word);
            } else if letters(&lines[last]) + 1 + letters(word) <= most {
                lines[last] += &format!(" {word}");
            } else {
                lines.push(word.to_owned());
            }
        }
        let beside = lines.last().map_or(0, |line| letters(line));
        if beside + 2 + letters(&self.text) > most {
            lines.push(String::new());
        }
        lines
    }
}

impl Bars {
    /// The drawing for an HTML page with [`super::svg::STYLE`].
    pub fn inline(&self, width: u32) -> String {
        let width = f64::from(width);
        let long = width - 2.0 * MARGIN;
        let lines: Vec<Vec<String>> = self.bars.iter().map(|bar| bar.lines(long)).collect();
        let further: usize = lines.iter().map(|lines| lines.len() - 1).sum();
        let height = TITLE + ROW * self.bars.len() as f64 + LINE * further as f64 + MARGIN;
        let title = escaped(&self.title);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\">\
             <text class=\"title\" x=\"{MARGIN}\" y=\"19\">{title}</text>"
        );
        let mut y = TITLE;
        for (bar, lines) in self.bars.iter().zip(&lines) {
            let x = |value: f64| MARGIN + long * self.scale.share(value);
            for (k, line) in lines.iter().enumerate() {
                let _ = write!(
                    out,
                    "<text x=\"{MARGIN}\" y=\"{:.1}\">{}</text>",
                    y + 13.0 + LINE * k as f64,
                    escaped(line)
                );
            }
            y += LINE * (lines.len() - 1) as f64;
            let top = y + 18.0;
            let _ = write!(
                out,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
                 <rect x=\"{MARGIN}\" y=\"{top:.1}\" width=\"{long:.1}\" height=\"{THICK}\" fill=\"var(--grid)\" fill-opacity=\".5\"/>\
                 <rect x=\"{MARGIN}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{THICK}\" fill=\"var(--c{})\"/>",
                width - MARGIN,
                y + 13.0,
                escaped(&bar.text),
                x(bar.value) - MARGIN,
                bar.colour
            );
            y += ROW;
            if let Some((low, high)) = bar.interval {
                let middle = top + THICK / 2.0;
                let _ = write!(
                    out,
                    "<path d=\"M{:.1} {middle:.1}H{:.1}M{:.1} {:.1}v{THICK}M{:.1} {:.1}v{THICK}\" stroke=\"var(--ink)\" stroke-width=\"1.5\"/>",
                    x(low),
                    x(high),
                    x(low),
                    top,
                    x(high),
                    top
                );
            }
        }
        out.push_str("</svg>");
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_follow_the_scale() {
        assert_eq!(Scale(4.0).share(1.0), 0.25);
        // Values that are not finite give a valid drawing.
        assert_eq!(Scale(1.0).share(f64::NAN), 0.0);
        assert_eq!(Scale(0.0).share(0.0), 0.0);
    }

    #[test]
    fn a_bar_is_as_long_as_its_share_and_names_are_escaped() {
        let bars = Bars {
            title: "shares".into(),
            scale: Scale(1.0),
            bars: vec![Bar {
                name: "<b>".into(),
                value: 0.5,
                text: "50 %".into(),
                interval: None,
                colour: 0,
            }],
        };
        let svg = bars.inline(216);
        assert!(svg.contains("width=\"100.0\"") && svg.contains("width=\"200.0\""));
        assert!(svg.contains("&lt;b&gt;") && !svg.contains("<b>"));
    }

    /// On a phone a long name and its value do not overlap.
    #[test]
    fn bars_that_do_not_fit_a_line_are_wrapped() {
        let bar = Bar {
            name: "with cogging + dead_zone + pwm_freewheel".into(),
            value: 0.5,
            text: "0.648 counts (0.334 to 0.941)".into(),
            interval: None,
            colour: 0,
        };
        assert_eq!(bar.lines(344.0), [bar.name.as_str(), ""]);
        assert_eq!(bar.lines(844.0), [bar.name.as_str()]);
        assert_eq!(
            bar.lines(210.0),
            ["with cogging + dead_zone +", "pwm_freewheel", ""]
        );
        let bars = Bars {
            title: "left".into(),
            scale: Scale(1.0),
            bars: vec![bar.clone(), bar],
        };
        let svg = bars.inline(360);
        assert!(svg.contains("viewBox=\"0 0 360 142\""), "{svg}");
        // Positions of names, values and bars from the top: 43, 59 and 64; 95, 111 and 116.
        for y in ["y=\"43.0\"", "y=\"59.0\"", "y=\"95.0\"", "y=\"111.0\""] {
            assert!(svg.contains(y), "{y}: {svg}");
        }
    }
}
