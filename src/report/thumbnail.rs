//! The curves of a panel in the size of a table row: no grid, the ends in numbers.

use std::fmt::Write;

use super::escape::escaped;
use super::figure::{Panel, Stroke, thinned, widened};
use super::legend::dash_attribute;
use super::number::figure;
use super::svg::COLOURS;

const WIDTH: f64 = 230.0;
const HEIGHT: f64 = 96.0;
/// Height for the range of the values above the curves, and for that of x below them.
const TOP: f64 = 16.0;
const BOTTOM: f64 = 16.0;

/// The drawing for an HTML page with [`super::svg::STYLE`]; `unit_x` is the unit of x.
pub(super) fn inline(panel: &Panel, unit_x: &str) -> String {
    let x = panel
        .series
        .iter()
        .flat_map(|s| s.points.iter().map(|p| p.0));
    let (first, last) = super::figure::range(x).unwrap_or((0.0, 1.0));
    let (x0, x1) = widened((first, last));
    let (low, high) = panel.scale().map_or((0.0, 1.0), |scale| scale.range);
    let (y0, y1) = widened((low, high));
    let name = escaped(&panel.y_label);
    let mut out = format!(
        "<svg class=\"plot thumbnail\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" role=\"img\" aria-label=\"{name}\">\
         <text class=\"tick\" x=\"2\" y=\"11\">{name}: {} to {}</text>",
        figure(low, 3),
        figure(high, 3)
    );
    for series in panel.series.iter().filter(|one| !one.stroke.is_band()) {
        let mut path = String::new();
        let mut is_down = false;
        for (at, value) in thinned(&series.points, (x0, x1), WIDTH as usize) {
            if !(at.is_finite() && value.is_finite()) {
                is_down = false;
                continue;
            }
            let px = WIDTH * (at - x0) / (x1 - x0);
            let py = TOP + (HEIGHT - TOP - BOTTOM) * (y1 - value.clamp(y0, y1)) / (y1 - y0);
            let _ = match (is_down, series.stroke) {
                (false, _) => write!(path, "M{px:.0} {py:.1}"),
                (true, Stroke::Step | Stroke::FaintStep | Stroke::BroadStep) => {
                    write!(path, "H{px:.0}V{py:.1}")
                }
                (true, _) => write!(path, "L{px:.0} {py:.1}"),
            };
            is_down = true;
        }
        let colour = series.colour % COLOURS;
        let _ = write!(
            out,
            "<path class=\"curve\" d=\"{path}\" stroke=\"var(--c{colour})\"{}/>",
            dash_attribute(series.stroke)
        );
    }
    let _ = write!(
        out,
        "<text class=\"tick\" x=\"{WIDTH}\" y=\"{:.0}\" text-anchor=\"end\">{} {unit_x}</text></svg>",
        HEIGHT - 3.0,
        figure(last - first, 2)
    );
    out
}
