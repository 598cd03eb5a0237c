//! Title and legend of a drawing.

use std::fmt::Write;

use super::escape::escaped;
use super::figure::{Panel, Series, Stroke};
use super::svg::COLOURS;

/// Least left margin: the name of the y axis and four digits.
pub(super) const LEFT: f64 = 64.0;
/// Left margin for the name of the y axis, and the distance between a number and its panel.
const LEFT_MARGIN: f64 = 32.0;

/// Height of a row of the legend.
pub(super) const LEGEND_ROW: f64 = 18.0;

/// Left margin for these numbers; digits are 7 px wide.
pub(super) fn margin(numbers: impl Iterator<Item = String>) -> f64 {
    let widest = numbers.map(|number| number.chars().count()).max();
    LEFT.max(LEFT_MARGIN + 7.0 * widest.unwrap_or(0) as f64)
}

/// A title wrapped to the width; letters are 8 px wide.
pub(super) fn lines(title: &str, width: f64) -> Vec<String> {
    let letters = (width / 8.0) as usize;
    let mut lines: Vec<String> = Vec::new();
    for word in title.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Named series, each name once.
pub(super) fn legend_entries(panel: &Panel) -> Vec<&Series> {
    panel.series.iter().filter(|s| !s.name.is_empty()).collect()
}

/// Legend entries in rows that fit the width, with their x positions; letters are 6.6 px wide.
pub(super) fn legend_rows<'a>(entries: &[&'a Series], width: f64) -> Vec<Vec<(f64, &'a Series)>> {
    let mut rows: Vec<Vec<(f64, &Series)>> = Vec::new();
    let mut x = 0.0;
    for series in entries {
        let wide = 40.0 + 6.6 * series.name.chars().count() as f64;
        if rows.is_empty() || x + wide > width {
            rows.push(Vec::new());
            x = 0.0;
        }
        if let Some(row) = rows.last_mut() {
            row.push((x, series));
        }
        x += wide;
    }
    rows
}

pub(super) fn draw_legend(out: &mut String, entries: &[&Series], top: f64, width: f64) {
    for (k, row) in legend_rows(entries, width).into_iter().enumerate() {
        let y = top + LEGEND_ROW * k as f64 + 8.0;
        for (x, series) in row {
            let x = LEFT + x;
            let colour = series.colour % COLOURS;
            if series.stroke == Stroke::Dots {
                let _ = write!(
                    out,
                    "<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"var(--c{colour})\"/>",
                    x + 11.0
                );
            } else {
                // A faint curve is visible by its many strokes; a single stroke in the legend needs full strength.
                let dash_attribute = match series.stroke {
                    Stroke::Upper => " style=\"stroke-width:9;stroke-opacity:.2\"",
                    Stroke::FaintStep => " style=\"stroke-width:1;stroke-opacity:.8\"",
                    stroke => dash_attribute(stroke),
                };
                let _ = write!(
                    out,
                    "<path class=\"curve\" d=\"M{x:.1} {y:.1}h22\" stroke=\"var(--c{colour})\"{dash_attribute}/>"
                );
            }
            let _ = write!(
                out,
                "<text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                x + 28.0,
                y + 4.0,
                escaped(&series.name)
            );
        }
    }
}

pub(super) fn dash_attribute(stroke: Stroke) -> &'static str {
    match stroke {
        Stroke::Dashed => " stroke-dasharray=\"6 4\"",
        Stroke::FaintStep => " stroke-opacity=\".3\"",
        Stroke::Broad | Stroke::BroadStep => " style=\"stroke-width:5;stroke-opacity:.5\"",
        Stroke::Line | Stroke::Step | Stroke::Dots | Stroke::Lower | Stroke::Upper => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_numbers_do_not_touch_the_axis_name() {
        let left = |number: &str| margin([number.to_owned()].into_iter());
        assert_eq!(left("\u{2212}50"), LEFT);
        // The name's letters end 22 px from the edge. A number of 7 digits begins 6 px and its width before the
        // panel.
        assert!(left("\u{2212}100000") - 6.0 - 7.0 * 7.0 > 22.0);
    }
}
