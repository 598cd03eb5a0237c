//! One panel of a drawing: grid, marks and curves.

use std::fmt::Write;

use super::escape::escaped;
use super::figure::{Band, Panel, Series, Stroke, thinned, tick_label, ticks, y_ticks};
use super::legend::dash_attribute;
use super::svg::COLOURS;

/// Position of a panel on the drawing and the ranges of its axes.
pub(super) struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    pub x_range: (f64, f64),
    pub y_range: (f64, f64),
}

impl Frame {
    fn x(&self, value: f64) -> f64 {
        let (low, high) = self.x_range;
        self.left + (value - low) / (high - low) * self.width
    }

    /// Values beyond the scale are drawn at the frame's edge.
    fn y(&self, value: f64) -> f64 {
        let (low, high) = self.y_range;
        let value = value.clamp(low, high);
        self.top + (high - value) / (high - low) * self.height
    }

    pub fn draw(&self, out: &mut String, panel: &Panel, words: Option<String>) {
        let (bottom, right) = (self.top + self.height, self.left + self.width);
        self.draw_bands(out, panel);
        let x_ticks = ticks(self.x_range, ((self.width / 60.0) as usize).clamp(3, 8));
        let x_step = x_ticks.get(1).map_or(1.0, |second| second - x_ticks[0]);
        for &tick in &x_ticks {
            let x = self.x(tick);
            let _ = write!(
                out,
                "<path class=\"grid\" d=\"M{x:.1} {:.1}V{bottom:.1}\"/>",
                self.top
            );
            let _ = write!(
                out,
                "<text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 15.0,
                tick_label(tick, x_step)
            );
        }
        for (tick, label) in y_ticks(self.y_range, self.height) {
            let y = self.y(tick);
            let _ = write!(
                out,
                "<path class=\"grid\" d=\"M{:.1} {y:.1}H{right:.1}\"/><text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                self.left,
                self.left - 6.0,
                y + 4.0,
                label
            );
        }
        for (value, name) in &panel.marks {
            let y = self.y(*value);
            let _ = write!(
                out,
                "<path class=\"mark\" d=\"M{:.1} {y:.1}H{right:.1}\"/><text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                self.left,
                right - 4.0,
                y - 4.0,
                escaped(name)
            );
        }
        for start in &panel.starts {
            let x = self.x(*start);
            let _ = write!(
                out,
                "<path class=\"mark\" d=\"M{x:.1} {:.1}V{bottom:.1}\"/>",
                self.top
            );
        }
        for pair in panel.series.windows(2) {
            if pair[1].stroke == Stroke::Upper {
                self.draw_between(out, &pair[0], &pair[1]);
            }
        }
        for series in panel.series.iter().filter(|one| !one.stroke.is_band()) {
            self.draw_series(out, series);
        }
        if let Some(words) = words {
            let _ = write!(
                out,
                "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                right - 4.0,
                self.top + 12.0,
                escaped(&words)
            );
        }
        let _ = write!(
            out,
            "<rect class=\"frame\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/><text transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.left,
            self.top,
            self.width,
            self.height,
            self.top + self.height / 2.0,
            escaped(&panel.y_label)
        );
    }

    /// Shades intervals of at least two pixels. A label that would overlap that of a stronger one is left out.
    fn draw_bands(&self, out: &mut String, panel: &Panel) {
        let mut bands: Vec<&Band> = panel.bands.iter().collect();
        bands.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        let mut taken: Vec<(f64, f64)> = Vec::new();
        for band in bands {
            let x = self.x(band.from);
            let width = (self.x(band.to) - x).max(2.0);
            let _ = write!(
                out,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{:.1}\" fill=\"var(--c1)\" fill-opacity=\"{:.2}\"/>",
                self.top,
                self.height,
                band.strength.clamp(0.0, 1.0)
            );
            let half = 3.5 * band.label.chars().count() as f64;
            let middle = (x + width / 2.0).min(self.left + self.width - half);
            let is_free = |(at, wide): &(f64, f64)| (at - middle).abs() >= wide + half;
            if half > 0.0 && taken.iter().all(is_free) {
                let _ = write!(
                    out,
                    "<text class=\"tick\" x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                    self.top + 12.0,
                    escaped(&band.label)
                );
                taken.push((middle, half));
            }
        }
    }

    fn draw_series(&self, out: &mut String, series: &Series) {
        let points = thinned(&series.points, self.x_range, self.width as usize);
        let colour = series.colour % COLOURS;
        if series.stroke == Stroke::Dots {
            let _ = write!(out, "<g fill=\"var(--c{colour})\">");
            for (x, y) in points
                .into_iter()
                .filter(|p| p.0.is_finite() && p.1.is_finite())
            {
                let _ = write!(
                    out,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2\"/>",
                    self.x(x),
                    self.y(y)
                );
            }
            out.push_str("</g>");
            return;
        }
        let mut path = String::new();
        let mut pen_down = false;
        for (x, y) in points {
            if !(x.is_finite() && y.is_finite()) {
                pen_down = false;
                continue;
            }
            let (px, py) = (self.x(x), self.y(y));
            let _ = match (pen_down, series.stroke) {
                (false, _) => write!(path, "M{px:.1} {py:.1}"),
                (true, Stroke::Step | Stroke::FaintStep | Stroke::BroadStep) => {
                    write!(path, "H{px:.1}V{py:.1}")
                }
                (true, _) => write!(path, "L{px:.1} {py:.1}"),
            };
            pen_down = true;
        }
        let _ = write!(
            out,
            "<path class=\"curve\" d=\"{path}\" stroke=\"var(--c{colour})\"{}/>",
            dash_attribute(series.stroke)
        );
    }

    /// Shades the area between two curves over the same x.
    fn draw_between(&self, out: &mut String, lower: &Series, upper: &Series) {
        let (columns, colour) = (self.width as usize, upper.colour);
        let lower = thinned(&lower.points, self.x_range, columns);
        let upper = thinned(&upper.points, self.x_range, columns);
        let is_gap = |point: &(f64, f64)| !point.1.is_finite();
        let mut path = String::new();
        for (low, high) in lower.split(is_gap).zip(upper.split(is_gap)) {
            let around = low.iter().chain(high.iter().rev());
            for (k, (x, y)) in around.enumerate() {
                let letter = if k == 0 { 'M' } else { 'L' };
                let _ = write!(path, "{letter}{:.1} {:.1}", self.x(*x), self.y(*y));
            }
            if !low.is_empty() {
                path.push('Z');
            }
        }
        let _ = write!(
            out,
            "<path d=\"{path}\" fill=\"var(--c{})\" fill-opacity=\".2\"/>",
            colour % COLOURS
        );
    }
}
