//! Renders a panel as text for a terminal: eight dots per character (Unicode braille).

use super::figure::{Panel, Series, Stroke, thinned, tick_label, ticks, widened};

/// ANSI colour codes of the series by index, in the order of the drawings' palette.
const ANSI: [&str; 7] = ["34", "33", "32", "35", "93", "36", "90"];

/// A panel as lines of text, `columns` wide and `rows` high (axes included), with colours, or with a digit for each
/// further series.
pub fn plot(panel: &Panel, x_label: &str, columns: usize, rows: usize, colours: bool) -> String {
    let x_range = panel
        .series
        .iter()
        .flat_map(|s| s.points.iter().map(|p| p.0))
        .filter(|x| x.is_finite())
        .fold(None, |range: Option<(f64, f64)>, x| {
            let (low, high) = range.unwrap_or((x, x));
            Some((low.min(x), high.max(x)))
        });
    let (Some(x_range), Some(scale)) = (x_range, panel.scale()) else {
        return format!("{}: nothing to plot\n", panel.y_label);
    };
    let x_range = if x_range.1 > x_range.0 {
        x_range
    } else {
        widened(x_range)
    };
    let y_range = widened(scale.range);
    let label_width = 8;
    let width = columns.saturating_sub(label_width + 1).max(10);
    let height = rows.saturating_sub(3).max(3);
    let mut canvas = Canvas::new(width, height);
    let mut drawn: Vec<(usize, &Series)> = lines(panel).enumerate().collect();
    // Without colours a line is identified by its digit; the first one, in dots, is drawn over the others.
    if !colours {
        drawn.reverse();
    }
    for (number, series) in drawn {
        let ink = if colours { series.colour } else { number };
        let points = thinned(&series.points, x_range, 2 * width);
        let place = |(x, y): (f64, f64)| {
            let column = (x - x_range.0) / (x_range.1 - x_range.0) * (2 * width - 1) as f64;
            let row = (y_range.1 - y) / (y_range.1 - y_range.0) * (4 * height - 1) as f64;
            (column.round() as i64, row.round() as i64)
        };
        let mut before: Option<(i64, i64)> = None;
        for point in points {
            if !(point.0.is_finite() && point.1.is_finite()) {
                before = None;
                continue;
            }
            let now = place(point);
            match (before, series.stroke) {
                (None, _) | (_, Stroke::Dots) => canvas.dot(now, ink),
                (Some(from), Stroke::Step | Stroke::FaintStep | Stroke::BroadStep) => {
                    canvas.line(from, (now.0, from.1), ink);
                    canvas.line((now.0, from.1), now, ink);
                }
                (Some(from), _) => canvas.line(from, now, ink),
            }
            before = Some(now);
        }
    }
    let mut out = legend(panel, colours);
    let y_ticks = ticks(y_range, (height / 3).max(2));
    let y_step = y_ticks.get(1).map_or(1.0, |second| second - y_ticks[0]);
    for row in 0..height {
        let (high, low) = (y_at(y_range, height, row), y_at(y_range, height, row + 1));
        let tick = y_ticks.iter().find(|&&tick| tick <= high && tick > low);
        let label = tick.map_or(String::new(), |&tick| tick_label(tick, y_step));
        out.push_str(&format!("{label:>label_width$}┤"));
        canvas.push_row(&mut out, row, colours);
        out.push('\n');
    }
    let (low, high) = (
        tick_label(x_range.0, x_range.1 / 100.0),
        tick_label(x_range.1, x_range.1 / 100.0),
    );
    let middle = width.saturating_sub(low.chars().count() + high.chars().count());
    out.push_str(&format!(
        "{:>label_width$} {low}{x_label:^middle$}{high}\n",
        ""
    ));
    out
}

fn y_at((low, high): (f64, f64), height: usize, row: usize) -> f64 {
    high - (high - low) * row as f64 / height as f64
}

fn legend(panel: &Panel, colours: bool) -> String {
    let names = lines(panel)
        .enumerate()
        .filter(|(_, series)| !series.name.is_empty())
        .map(|(number, series)| {
            let digit = digit(number).map(String::from);
            let sign = match series.stroke {
                _ if !colours => digit.as_deref().unwrap_or(DOTS),
                Stroke::Dots => "••",
                Stroke::Dashed => "╌╌",
                Stroke::Broad | Stroke::BroadStep => "━━",
                _ => "──",
            };
            painted(&format!("{sign} {}", series.name), series.colour, colours)
        });
    let names: Vec<_> = names.collect();
    format!("{}   {}\n", panel.y_label, names.join("   "))
}

fn lines(panel: &Panel) -> impl Iterator<Item = &Series> {
    panel.series.iter().filter(|one| !one.stroke.is_band())
}

/// Sign of the first series without colours.
const DOTS: &str = "\u{2836}\u{2836}";

/// Digit of a series without colours; the first one is drawn in dots.
fn digit(number: usize) -> Option<char> {
    (number > 0)
        .then(|| {
            u32::try_from(number)
                .ok()
                .and_then(|n| char::from_digit(n, 10))
        })
        .flatten()
}

fn painted(text: &str, colour: usize, colours: bool) -> String {
    if colours {
        format!("\u{1b}[{}m{text}\u{1b}[0m", ANSI[colour % ANSI.len()])
    } else {
        text.to_owned()
    }
}

/// Dots, two by four per character; each character has the colour or digit of its last dot.
struct Canvas {
    width: usize,
    height: usize,
    dots: Vec<u8>,
    colours: Vec<usize>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            dots: vec![0; width * height],
            colours: vec![0; width * height],
        }
    }

    fn dot(&mut self, (x, y): (i64, i64), colour: usize) {
        // Bit numbers of a braille character: the left column from the top, the right one, then the bottom row.
        const BITS: [[u8; 2]; 4] = [[0, 3], [1, 4], [2, 5], [6, 7]];
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else {
            return;
        };
        if x >= 2 * self.width || y >= 4 * self.height {
            return;
        }
        let cell = y / 4 * self.width + x / 2;
        self.dots[cell] |= 1 << BITS[y % 4][x % 2];
        self.colours[cell] = colour;
    }

    /// A line clipped to the canvas (Liang and Barsky, 1984), as spikes may lie far outside the scale.
    fn line(&mut self, from: (i64, i64), to: (i64, i64), colour: usize) {
        let sizes = [2 * self.width, 4 * self.height].map(|size| size as f64);
        let from = [from.0 as f64, from.1 as f64];
        let by = [to.0 as f64 - from[0], to.1 as f64 - from[1]];
        let steps = by[0].abs().max(by[1].abs()).max(1.0);
        let (mut first, mut last) = (0.0_f64, steps);
        for ((from, by), size) in from.into_iter().zip(by).zip(sizes) {
            let edges = [-0.5, size - 0.5].map(|edge| (edge - from) / by * steps);
            match by {
                0.0 if (-0.5..size).contains(&from) => (),
                0.0 => return,
                _ => {
                    first = first.max(edges[0].min(edges[1]).ceil());
                    last = last.min(edges[0].max(edges[1]).floor());
                }
            }
        }
        if first > last {
            return;
        }
        for step in 0..=(last - first) as usize {
            let step = first + step as f64;
            let at = |k: usize| (from[k] + (by[k] * step / steps).round()) as i64;
            self.dot((at(0), at(1)), colour);
        }
    }

    fn push_row(&self, out: &mut String, row: usize, colours: bool) {
        let cells = row * self.width..(row + 1) * self.width;
        let mut painted: Option<usize> = None;
        for cell in cells {
            let dots = self.dots[cell];
            let wanted = (colours && dots != 0).then_some(self.colours[cell]);
            if wanted != painted {
                if painted.is_some() {
                    out.push_str("\u{1b}[0m");
                }
                if let Some(colour) = wanted {
                    out.push_str(&format!("\u{1b}[{}m", ANSI[colour % ANSI.len()]));
                }
                painted = wanted;
            }
            out.push(match (dots, digit(self.colours[cell])) {
                (0, _) => ' ',
                (_, Some(digit)) if !colours => digit,
                (dots, _) => char::from_u32(0x2800 + u32::from(dots)).unwrap_or(' '),
            });
        }
        if painted.is_some() {
            out.push_str("\u{1b}[0m");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::Series;

    #[test]
    fn a_rising_line_goes_from_corner_to_corner() {
        let panel = Panel::new(
            "speed (RPM)",
            vec![Series::new("a", Stroke::Line, 0, &[0.0, 1.0], &[0.0, 1.0])],
        );
        let text = plot(&panel, "time (s)", 40, 10, false);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 9);
        let places = |line: &str| -> Vec<usize> {
            let dotted = line.chars().enumerate().filter(|(_, c)| *c > '\u{2800}');
            dotted.map(|(k, _)| k).collect()
        };
        assert!(places(lines[1]).contains(&39), "{text}");
        assert!(places(lines[7]).contains(&9), "{text}");
        assert!(lines.iter().all(|line| line.chars().count() <= 40));
    }

    #[test]
    fn an_empty_plot_is_reported() {
        let panel = Panel::new(
            "speed (RPM)",
            vec![Series::new("a", Stroke::Line, 0, &[0.0], &[f64::NAN])],
        );
        assert!(plot(&panel, "time (s)", 80, 20, true).contains("nothing to plot"));
    }

    fn drawn(from: (i64, i64), to: (i64, i64)) -> Vec<u8> {
        let mut canvas = Canvas::new(10, 5);
        canvas.line(from, to, 0);
        canvas.dots
    }

    /// Points far outside cost no time, and the visible part of the line is exact.
    #[test]
    fn a_line_beyond_the_plot_is_clipped_at_the_edge() {
        assert_eq!(drawn((3, 0), (i64::MAX, 0)), drawn((3, 0), (19, 0)));
        assert_eq!(drawn((3, -(1 << 40)), (3, 1 << 40)), drawn((3, 0), (3, 19)));
        assert_eq!(drawn((0, 0), (1 << 40, 1 << 40)), drawn((0, 0), (19, 19)));
        assert_eq!(
            drawn((5, 5), (5, 5))
                .iter()
                .filter(|dots| **dots != 0)
                .count(),
            1
        );
        for (from, to) in [
            ((-1, -5), (-1, 40)),
            ((i64::MIN, -1), (i64::MAX, -1)),
            ((25, 0), (40, 0)),
        ] {
            assert!(
                drawn(from, to).iter().all(|dots| *dots == 0),
                "{from:?} {to:?}"
            );
        }
    }
}
