//! Content of a plot, independent of its rendering: panels with series over one x axis.
//!
//! [`super::svg`] renders a figure as SVG, [`super::terminal`] as text.

/// Style of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// A line through the points.
    Line,
    /// A dashed line.
    Dashed,
    /// A value that is held until the next point, as a command or a count.
    Step,
    /// A faint step: raw data in the background.
    FaintStep,
    /// A broad, pale line in the background.
    Broad,
    /// A broad, pale step.
    BroadStep,
    /// A dot at each point.
    Dots,
    /// Lower end of a band; its upper end is the next series.
    Lower,
    /// Upper end of a band, shaded down to the series before.
    Upper,
}

impl Stroke {
    /// Whether it is an end of a band, which is not drawn as a line.
    pub fn is_band(self) -> bool {
        matches!(self, Self::Lower | Self::Upper)
    }
}

/// One curve. Points that are not finite are gaps.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Style.
    pub stroke: Stroke,
    /// Index of its colour in the palette, the same for the same quantity in all panels.
    pub colour: usize,
    /// Points (x, y) in ascending order of x.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series from two columns of equal length.
    pub fn new(
        name: impl Into<String>,
        stroke: Stroke,
        colour: usize,
        x: &[f64],
        y: &[f64],
    ) -> Self {
        Self {
            name: name.into(),
            stroke,
            colour,
            points: x.iter().copied().zip(y.iter().copied()).collect(),
        }
    }
}

/// A shaded interval of x.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Opacity, 0 to 1.
    pub strength: f64,
    /// Label.
    pub label: String,
}

/// One y axis and its curves.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Quantity and unit, such as `speed (RPM)`.
    pub y_label: String,
    /// The curves, drawn in this order.
    pub series: Vec<Series>,
    /// Height relative to the other panels.
    pub weight: f64,
    /// Horizontal reference lines with their names.
    pub marks: Vec<(f64, String)>,
    /// Vertical lines at restarts.
    pub starts: Vec<f64>,
    /// Shaded intervals in the background.
    pub bands: Vec<Band>,
    /// Whether isolated spikes are excluded from its scale.
    pub is_robust: bool,
}

impl Panel {
    /// A panel of weight 1.
    pub fn new(y_label: impl Into<String>, series: Vec<Series>) -> Self {
        Self {
            y_label: y_label.into(),
            series,
            weight: 1.0,
            marks: Vec::new(),
            starts: Vec::new(),
            bands: Vec::new(),
            is_robust: false,
        }
    }

    /// The panel with this height relative to the others.
    pub fn weighing(mut self, weight: f64) -> Self {
        self.weight = weight;
        self
    }

    /// The panel with a horizontal reference line.
    pub fn marked(mut self, y: f64, name: impl Into<String>) -> Self {
        self.marks.push((y, name.into()));
        self
    }

    /// The panel with vertical lines at restarts.
    pub fn restarting_at(mut self, starts: &[f64]) -> Self {
        self.starts = starts.to_vec();
        self
    }

    /// The panel with shaded intervals.
    pub fn shaded(mut self, bands: Vec<Band>) -> Self {
        self.bands = bands;
        self
    }

    /// The panel with a scale that excludes isolated spikes.
    pub fn robust(mut self) -> Self {
        self.is_robust = true;
        self
    }

    /// Minimum and maximum of y, marks included; `None` without finite values.
    pub fn y_range(&self) -> Option<(f64, f64)> {
        let values = self
            .series
            .iter()
            .flat_map(|s| s.points.iter().map(|p| p.1));
        range(values.chain(self.marks.iter().map(|mark| mark.0)))
    }
}

/// Panels in a column over one x axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    /// Short description.
    pub title: String,
    /// Quantity and unit of x, such as `time (s)`.
    pub x_label: String,
    /// Panels from top to bottom.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// Minimum and maximum of x over all panels; `None` without points.
    pub fn x_range(&self) -> Option<(f64, f64)> {
        let panels = self.panels.iter().flat_map(|panel| &panel.series);
        range(panels.flat_map(|s| s.points.iter().map(|p| p.0)))
    }
}

pub(super) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |range, v| {
        let (low, high) = range.unwrap_or((v, v));
        Some((f64::min(low, v), f64::max(high, v)))
    })
}

/// A range that is never empty: a single value is extended on both sides.
pub fn widened((low, high): (f64, f64)) -> (f64, f64) {
    let room = (high - low) * 0.05;
    if room > 0.0 {
        (low - room, high + room)
    } else {
        let room = (low.abs() * 0.1).max(0.5);
        (low - room, high + room)
    }
}

/// Round values (1, 2 or 5 times a power of ten) within a range, about `wanted` of them.
pub fn ticks((low, high): (f64, f64), wanted: usize) -> Vec<f64> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) || wanted == 0 {
        return Vec::new();
    }
    let rough = span / wanted as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| *step >= rough * 0.999)
        .unwrap_or(10.0 * power);
    // A range that ends at a round value has a tick there in spite of rounding.
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).take(1000).map(|k| k as f64 * step).collect()
}

/// A tick's value with the digits that its neighbours need.
pub fn tick_label(value: f64, step: f64) -> String {
    let digits = (-step.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let value = if value.abs() < step.abs() * 1e-9 {
        0.0
    } else {
        value
    };
    if value.abs() >= 1e6 {
        return format!("{value:.1e}");
    }
    format!("{value:.digits$}").replace('-', "\u{2212}")
}

/// Labelled ticks of a y axis of this height in pixels.
pub fn y_ticks(range: (f64, f64), height: f64) -> Vec<(f64, String)> {
    let wanted = ((height / 40.0) as usize).max(3);
    let mut at = ticks(range, wanted);
    // A single number is no scale.
    if at.len() < 2 {
        at = ticks(range, 2 * wanted);
    }
    let step = at.get(1).map_or(1.0, |second| second - at[0]);
    at.iter()
        .map(|&tick| (tick, tick_label(tick, step)))
        .collect()
}

/// At most five points per pixel column (first, lowest, highest, a gap, last): a long run is drawn quickly and
/// identically.
pub fn thinned(points: &[(f64, f64)], x_range: (f64, f64), columns: usize) -> Vec<(f64, f64)> {
    if points.len() <= 4 * columns {
        return points.to_vec();
    }
    let scale = columns as f64 / (x_range.1 - x_range.0);
    let column = |x: f64| ((x - x_range.0) * scale).floor();
    let mut out = Vec::with_capacity(4 * columns);
    for group in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let finite = || (0..group.len()).filter(|&k| group[k].1.is_finite());
        let lowest = finite().min_by(|&a, &b| group[a].1.total_cmp(&group[b].1));
        let highest = finite().max_by(|&a, &b| group[a].1.total_cmp(&group[b].1));
        let gap = (0..group.len()).find(|&k| !group[k].1.is_finite());
        let mut kept = vec![
            0,
            lowest.unwrap_or(0),
            highest.unwrap_or(0),
            gap.unwrap_or(0),
            group.len() - 1,
        ];
        kept.sort_unstable();
        kept.dedup();
        out.extend(kept.into_iter().map(|k| group[k]));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(
            ticks((0.0, 1.0), 5),
            [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]
        );
        assert_eq!(ticks((-48.0, 51.0), 4), [0.0, 50.0]);
        assert_eq!(ticks((0.0, 0.3), 6).len(), 7);
        assert!(ticks((3.0, 3.0), 4).is_empty());
        assert_eq!(tick_label(0.6000000000000001, 0.2), "0.6");
        assert_eq!(tick_label(-50.0, 50.0), "\u{2212}50");
    }

    #[test]
    fn thinning_keeps_every_peak() {
        let mut points: Vec<_> = (0..100_000).map(|k| (f64::from(k), 0.0)).collect();
        points[77_777].1 = 9.0;
        points[33_333].1 = -9.0;
        points[33_340].1 = f64::NAN;
        let thin = thinned(&points, (0.0, 100_000.0), 500);
        assert!(thin.len() <= 2500 && thin.iter().any(|point| point.1.is_nan()));
        assert!(thin.contains(&(77_777.0, 9.0)) && thin.contains(&(33_333.0, -9.0)));
    }

    #[test]
    fn gaps_do_not_widen_the_range() {
        let series = Series::new(
            "a",
            Stroke::Line,
            0,
            &[0.0, 1.0, 2.0],
            &[1.0, f64::NAN, 3.0],
        );
        assert_eq!(Panel::new("y", vec![series]).y_range(), Some((1.0, 3.0)));
    }
}
