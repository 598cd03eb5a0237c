//! Bars with their names and numbers, and an interval where there is one.
//!
//! Name and number stand above each bar, so that the drawing needs no width of its own.

use std::fmt::Write;

use super::escape::escaped;

/// One bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// What it is.
    pub name: String,
    /// How long it is.
    pub value: f64,
    /// The number as it is read.
    pub text: String,
    /// Ends of its interval.
    pub interval: Option<(f64, f64)>,
    /// Its colour: an index into the palette.
    pub colour: usize,
}

/// How values become lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// In proportion, from 0 to this value.
    Linear(f64),
    /// By the logarithm, between these values.
    Logarithmic(f64, f64),
}

impl Scale {
    /// Share of the full length, 0 to 1.
    pub fn share(self, value: f64) -> f64 {
        let share = match self {
            Self::Linear(most) => value / most,
            Self::Logarithmic(least, most) => (value / least).ln() / (most / least).ln(),
        };
        if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        }
    }
}

/// Bars one below the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Bars {
    /// What they show.
    pub title: String,
    /// How values become lengths.
    pub scale: Scale,
    /// From the top.
    pub bars: Vec<Bar>,
}

const TITLE: f64 = 30.0;
const ROW: f64 = 36.0;
const THICK: f64 = 12.0;
const MARGIN: f64 = 8.0;

impl Bars {
    /// The drawing, to be put into an HTML page that has [`super::svg::STYLE`].
    pub fn inline(&self, width: u32) -> String {
        let width = f64::from(width);
        let long = width - 2.0 * MARGIN;
        let height = TITLE + ROW * self.bars.len() as f64 + MARGIN;
        let title = escaped(&self.title);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\">\
             <text class=\"title\" x=\"{MARGIN}\" y=\"19\">{title}</text>"
        );
        for (k, bar) in self.bars.iter().enumerate() {
            let y = TITLE + ROW * k as f64;
            let x = |value: f64| MARGIN + long * self.scale.share(value);
            let top = y + 18.0;
            let _ = write!(
                out,
                "<text x=\"{MARGIN}\" y=\"{:.1}\">{}</text>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
                 <rect x=\"{MARGIN}\" y=\"{top:.1}\" width=\"{long:.1}\" height=\"{THICK}\" fill=\"var(--grid)\" fill-opacity=\".5\"/>\
                 <rect x=\"{MARGIN}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{THICK}\" fill=\"var(--c{})\"/>",
                y + 13.0,
                escaped(&bar.name),
                width - MARGIN,
                y + 13.0,
                escaped(&bar.text),
                x(bar.value) - MARGIN,
                bar.colour
            );
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
        assert_eq!(Scale::Linear(4.0).share(1.0), 0.25);
        assert!((Scale::Logarithmic(0.1, 1000.0).share(10.0) - 0.5).abs() < 1e-12);
        // Nothing that is not a number makes a drawing that is none.
        assert_eq!(Scale::Logarithmic(0.1, 10.0).share(f64::NAN), 0.0);
        assert_eq!(Scale::Linear(0.0).share(0.0), 0.0);
    }

    #[test]
    fn a_bar_is_as_long_as_its_share_and_names_are_escaped() {
        let bars = Bars {
            title: "shares".into(),
            scale: Scale::Linear(1.0),
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
}
