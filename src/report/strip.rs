//! Strip chart: thousands of values with their intervals in one small drawing, with one path for all dots and one for
//! all intervals.

use std::fmt::Write;

use super::escape::escaped;
use super::number::figure;

/// One value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Position.
    pub x: f64,
    /// The value.
    pub y: f64,
    /// Its interval.
    pub interval: Option<(f64, f64)>,
    /// Whether it is highlighted.
    pub is_marked: bool,
}

/// A strip chart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Strip {
    /// Quantity.
    pub title: String,
    /// Label of x.
    pub x_label: String,
    /// Tick labels.
    pub ticks: Vec<(f64, String)>,
    /// The values.
    pub dots: Vec<Dot>,
    /// Their median, and the largest deviation of an ordinary value.
    pub ordinary: Option<(f64, f64)>,
}

const HEIGHT: f64 = 210.0;
/// Least distance of vertical labels in pixels; others are left out.
const APART: f64 = 12.0;
/// Letters of a vertical label, and the width of one in pixels.
const LETTERS: usize = 14;
const LETTER: f64 = 6.5;
/// Above this number of labels they are vertical.
const LEVEL: usize = 3;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 44.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 10.0;
/// Values farther from the median than this multiple of the ordinary deviation are drawn at the edge, so that one bad
/// unit does not compress the others.
const SHOWN: f64 = 3.0;

impl Strip {
    /// The drawing for an HTML page with [`super::svg::STYLE`].
    pub fn inline(&self, width: u32) -> String {
        let width = f64::from(width);
        let height = self.height();
        let (x0, x1) = range(self.dots.iter().map(|dot| dot.x));
        let (y0, y1) = self.y_range();
        let ticks = [y0, 0.5 * (y0 + y1), y1];
        let numbers = distinct_numbers(ticks);
        let widest = numbers.iter().map(|number| number.chars().count()).max();
        let left = LEFT.max(8.0 + 7.0 * widest.unwrap_or(0) as f64);
        let x = |value: f64| left + (width - left - RIGHT) * (value - x0) / (x1 - x0);
        let foot = HEIGHT - BOTTOM;
        let y = |value: f64| foot - (foot - TOP) * ((value.clamp(y0, y1) - y0) / (y1 - y0));
        let title = escaped(&self.title);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\">\
             <text class=\"title\" x=\"4\" y=\"17\">{title}</text>"
        );
        if let Some((middle, far)) = self.ordinary {
            let (low, high) = (y(middle - far), y(middle + far));
            let _ = write!(
                out,
                "<rect x=\"{left}\" y=\"{high:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"var(--grid)\" fill-opacity=\".45\"/>\
                 <path class=\"mark\" d=\"M{left} {:.1}H{:.1}\"/>",
                width - left - RIGHT,
                low - high,
                y(middle),
                width - RIGHT
            );
        }
        let _ = write!(
            out,
            "<path class=\"frame\" d=\"M{left} {TOP}V{foot}H{:.1}\"/>",
            width - RIGHT
        );
        for (value, number) in ticks.into_iter().zip(numbers) {
            let _ = write!(
                out,
                "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 5.0,
                y(value) + 4.0,
                number
            );
        }
        let last = self.ticks.len().saturating_sub(1);
        if self.is_upright() {
            for (at, words) in self.written(&x) {
                let middle = x(at) + 4.0;
                let _ = write!(
                    out,
                    "<text class=\"tick\" transform=\"translate({middle:.1} {:.1}) rotate(-90)\" text-anchor=\"end\">{}</text>",
                    foot + 6.0,
                    escaped(&words)
                );
            }
        }
        let level = self.ticks.iter().enumerate();
        for (k, (at, words)) in level.filter(|_| !self.is_upright()) {
            let anchor = match k {
                0 => "start",
                k if k == last => "end",
                _ => "middle",
            };
            let _ = write!(
                out,
                "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                x(*at),
                foot + 15.0,
                escaped(words)
            );
        }
        let _ = write!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            0.5 * (left + width - RIGHT),
            height - 8.0,
            escaped(&self.x_label)
        );
        let mut bars = String::new();
        for dot in &self.dots {
            if let Some((low, high)) = dot
                .interval
                .filter(|(low, high)| low.is_finite() && high.is_finite())
            {
                let _ = write!(bars, "M{:.0} {:.0}V{:.0}", x(dot.x), y(low), y(high));
            }
        }
        if !bars.is_empty() {
            let _ = write!(
                out,
                "<path d=\"{bars}\" stroke=\"var(--c0)\" stroke-opacity=\".3\" fill=\"none\"/>"
            );
        }
        for (marked, colour, thick) in [(false, 0, 3), (true, 1, 6)] {
            let mut path = String::new();
            for dot in self.dots.iter().filter(|dot| dot.is_marked == marked) {
                let _ = write!(path, "M{:.0} {:.1}h0", x(dot.x), y(dot.y));
            }
            if !path.is_empty() {
                let _ = write!(
                    out,
                    "<path d=\"{path}\" stroke=\"var(--c{colour})\" stroke-width=\"{thick}\" stroke-linecap=\"round\" fill=\"none\"/>"
                );
            }
        }
        out.push_str("</svg>");
        out
    }

    /// Whether the labels are vertical.
    fn is_upright(&self) -> bool {
        self.ticks.len() > LEVEL
    }

    fn height(&self) -> f64 {
        let longest = self
            .ticks
            .iter()
            .map(|(_, words)| words.chars().count().min(LETTERS))
            .max();
        match self.is_upright() {
            true => HEIGHT - LETTER + LETTER * longest.unwrap_or(0) as f64,
            false => HEIGHT,
        }
    }

    /// The labels that fit: those of highlighted values first, then from the left.
    fn written(&self, x: &dyn Fn(f64) -> f64) -> Vec<(f64, String)> {
        let is_marked = |at: f64| self.dots.iter().any(|dot| dot.x == at && dot.is_marked);
        let (first, others): (Vec<_>, Vec<_>) =
            self.ticks.iter().partition(|tick| is_marked(tick.0));
        let mut written: Vec<(f64, String)> = Vec::new();
        for (at, words) in first.into_iter().chain(others) {
            if written
                .iter()
                .all(|(other, _)| (x(*other) - x(*at)).abs() >= APART)
            {
                let mut short: String = words.chars().take(LETTERS).collect();
                if short.len() < words.len() {
                    short.pop();
                    short.push('\u{2026}');
                }
                written.push((*at, short));
            }
        }
        written
    }

    fn y_range(&self) -> (f64, f64) {
        let (low, high) = range(self.dots.iter().map(|dot| dot.y));
        match self.ordinary {
            Some((middle, far)) if far > 0.0 => {
                let most = SHOWN * far;
                let (low, high) = (low.max(middle - most), high.min(middle + most));
                (low.min(middle - far), high.max(middle + far))
            }
            _ => (low, high),
        }
    }
}

/// Labels of an axis with the digits that distinguish them.
fn distinct_numbers(ticks: [f64; 3]) -> [String; 3] {
    let numbers = |digits| ticks.map(|value| figure(value, digits));
    let are_apart = |numbers: &[String; 3]| numbers[0] != numbers[1] && numbers[1] != numbers[2];
    let all = (3..9).map(numbers);
    all.into_iter().find(are_apart).unwrap_or(numbers(3))
}

/// Minimum and maximum; never empty.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let ends = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    match ends {
        (low, high) if low < high => (low, high),
        (low, high) if low == high => {
            // A twentieth of the value on each side; 0.5 for 0.
            let half = if low == 0.0 { 0.5 } else { 0.05 * low.abs() };
            (low - half, low + half)
        }
        _ => (0.0, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_numbers_are_distinct() {
        assert_eq!(
            distinct_numbers([0.9994, 0.9999, 1.0004]),
            ["0.9994", "0.9999", "1"]
        );
        assert_eq!(distinct_numbers([-1.0, 0.0, 1.0])[1], "0");
    }

    #[test]
    fn an_outlier_stays_on_the_drawing_and_does_not_set_the_scale() {
        let dot = |x, y| Dot {
            x,
            y,
            interval: None,
            is_marked: y > 10.0,
        };
        let strip = Strip {
            dots: vec![dot(0.0, 1.0), dot(1.0, 2.0), dot(2.0, 1e9)],
            ordinary: Some((1.5, 1.0)),
            ..Strip::default()
        };
        assert_eq!(strip.y_range(), (0.5, 4.5));
        // Computed by hand: the two ordinary values are a quarter of the height apart, 136 of 4.
        let drawn = strip.inline(360);
        assert!(drawn.contains("M58 149.0h0M204 115.0h0"), "{drawn}");
        assert!(drawn.contains("M350 30.0h0"), "{drawn}");
    }
}
