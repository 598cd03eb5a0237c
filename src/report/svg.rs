//! Renders a figure as SVG for light and dark pages.
//!
//! Colours are CSS variables with a light and a dark value each (the Okabe-Ito palette for colour-blind readers), so
//! that one drawing fits both. All text is escaped.

use std::fmt::Write;

use super::escape::escaped;
use super::figure::{Figure, Panel, Series, widened, y_ticks};
use super::frame::Frame;
use super::legend::{LEFT, LEGEND_ROW, draw_legend, legend_entries, legend_rows, lines, margin};

/// Colours of a drawing, light and dark; once per page or stand-alone drawing.
pub const STYLE: &str = "\
.plot{--ink:#1f2328;--faint:#6e7781;--grid:#d8dee4;--paper:#fff;--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#aa4499;--c4:#b58900;--c5:#3a93c7;--c6:#666}\
@media screen and (prefers-color-scheme:dark){.plot{--ink:#e6edf3;--faint:#9198a1;--grid:#30363d;--paper:#0d1117;--c0:#56b4e9;--c1:#ff8c42;--c2:#3ddc97;--c3:#e58fc8;--c4:#f0c808;--c5:#9ad1f5;--c6:#aaa}}\
.plot text{font:12px system-ui,-apple-system,'Segoe UI',sans-serif;fill:var(--ink)}\
.plot .tick{fill:var(--faint);font-size:11px}.plot .title{font-weight:600;font-size:14px}\
.plot .grid{stroke:var(--grid);stroke-width:1}.plot .frame{stroke:var(--faint);stroke-width:1;fill:none}\
.plot .mark{stroke:var(--faint);stroke-width:1;stroke-dasharray:2 3}\
.plot .curve{fill:none;stroke-width:1.6;stroke-linejoin:round}";

/// Size of the palette.
pub(super) const COLOURS: usize = 7;

/// Outer size of a drawing in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

impl Size {
    /// For a page or a README.
    pub const PAGE: Self = Self {
        width: 860,
        height: 520,
    };
    /// A single panel.
    pub const SMALL: Self = Self {
        width: 860,
        height: 300,
    };
    /// One of two side by side; fits a phone.
    pub const HALF: Self = Self {
        width: 420,
        height: 300,
    };
}

const RIGHT: f64 = 16.0;
const TITLE: f64 = 30.0;
const TITLE_LINE: f64 = 18.0;
const BOTTOM: f64 = 44.0;
/// Distance between panels, for the numbers of the x axis.
const BETWEEN: f64 = 30.0;

/// A stand-alone drawing with its own colours and background.
pub fn document(figure: &Figure, size: Size) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    out.push_str(&drawing(figure, size, true));
    out
}

/// A drawing for an HTML page with [`STYLE`].
pub fn inline(figure: &Figure, size: Size) -> String {
    drawing(figure, size, false)
}

fn drawing(figure: &Figure, size: Size, alone: bool) -> String {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">",
        escaped(&figure.title)
    );
    if alone {
        let _ = write!(
            out,
            "<style>{STYLE}</style><rect width=\"100%\" height=\"100%\" fill=\"var(--paper)\"/>"
        );
    }
    let title = lines(&figure.title, width - LEFT - RIGHT);
    for (k, line) in title.iter().enumerate() {
        let _ = write!(
            out,
            "<text class=\"title\" x=\"{LEFT}\" y=\"{}\">{}</text>",
            19.0 + TITLE_LINE * k as f64,
            escaped(line)
        );
    }
    let title_height = TITLE + TITLE_LINE * title.len().saturating_sub(1) as f64;
    let legends: Vec<Vec<&Series>> = figure.panels.iter().map(legend_entries).collect();
    let legend_height =
        |entries: &[&Series]| LEGEND_ROW * legend_rows(entries, width - LEFT - RIGHT).len() as f64;
    let fixed: f64 = title_height
        + BOTTOM
        + legends
            .iter()
            .map(|entries| legend_height(entries))
            .sum::<f64>()
        + BETWEEN * figure.panels.len().saturating_sub(1) as f64;
    let weights: f64 = figure.panels.iter().map(|panel| panel.weight).sum();
    let x_range = figure.x_range().unwrap_or((0.0, 1.0));
    let x_range = if x_range.1 > x_range.0 {
        x_range
    } else {
        widened(x_range)
    };
    let panel_height = |panel: &Panel| (height - fixed).max(40.0) * panel.weight / weights;
    let scales: Vec<_> = figure.panels.iter().map(Panel::scale).collect();
    let y_range = |k: usize| widened(scales[k].map_or((0.0, 1.0), |scale| scale.range));
    let numbers = figure.panels.iter().enumerate();
    let numbers = numbers.flat_map(|(k, panel)| y_ticks(y_range(k), panel_height(panel)));
    let left = margin(numbers.map(|(_, label)| label));
    let mut top = title_height;
    for (k, (panel, entries)) in figure.panels.iter().zip(&legends).enumerate() {
        draw_legend(&mut out, entries, top, width - LEFT - RIGHT);
        top += legend_height(entries);
        let panel_height = panel_height(panel);
        let scale = scales[k];
        let frame = Frame {
            left,
            top,
            width: width - left - RIGHT,
            height: panel_height,
            x_range,
            y_range: y_range(k),
        };
        frame.draw(&mut out, panel, scale.and_then(|scale| scale.words()));
        top += panel_height + BETWEEN;
    }
    let _ = write!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text></svg>",
        left + (width - left - RIGHT) / 2.0,
        height - 8.0,
        escaped(&figure.x_label)
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::Stroke;

    fn figure(name: &str) -> Figure {
        Figure {
            title: "step <b>&\"".into(),
            x_label: "time (s)".into(),
            panels: vec![Panel::new(
                "speed (RPM)",
                vec![Series::new(
                    name,
                    Stroke::Line,
                    0,
                    &[0.0, 1.0, 2.0],
                    &[0.0, f64::NAN, 50.0],
                )],
            )],
        }
    }

    #[test]
    fn text_from_outside_is_escaped() {
        let svg = document(&figure("<script>alert(1)</script>"), Size::PAGE);
        assert!(!svg.contains("<script>") && !svg.contains("<b>"));
        assert!(svg.contains("&lt;script&gt;"));
    }

    #[test]
    fn points_are_drawn_at_their_values() {
        // The x axis spans 0 to 2 over the frame's width; x = 2 is its right edge, x = 0 its left.
        let svg = inline(&figure("a"), Size::PAGE);
        let right = f64::from(Size::PAGE.width) - RIGHT;
        assert!(svg.contains(&format!("M{LEFT:.1} ")) && svg.contains(&format!("M{right:.1} ")));
    }

    #[test]
    fn a_long_title_is_wrapped() {
        assert_eq!(lines("one two three", 64.0), ["one two", "three"]);
        assert_eq!(lines("unbreakable", 8.0), ["unbreakable"]);
        let both = figure("a");
        let narrow = Size {
            width: 150,
            height: 300,
        };
        assert_eq!(inline(&both, narrow).matches("class=\"title\"").count(), 2);
        assert_eq!(
            inline(&both, Size::SMALL)
                .matches("class=\"title\"")
                .count(),
            1
        );
    }

    /// Every panel has at least two numbers on each axis, the lowest and flattest ones included.
    #[test]
    fn every_panel_has_a_scale() {
        let panel = |y: &[f64]| {
            let series = Series::new("a", Stroke::Step, 0, &[0.0, 1.0, 2.0], y);
            Panel::new("command (V)", vec![series]).weighing(0.1)
        };
        let both = Figure {
            panels: vec![panel(&[-4.5, 4.5, 4.5]), panel(&[3.0; 3])],
            ..figure("a")
        };
        let svg = inline(&both, Size::PAGE);
        let x_numbers = svg.matches("text-anchor=\"middle\">2.0<").count();
        assert_eq!(x_numbers, 2);
        let y_numbers = svg.matches("text-anchor=\"end\">").count();
        assert!(y_numbers >= 4, "{y_numbers}");
    }

    #[test]
    fn an_empty_figure_is_drawn() {
        let empty = Figure {
            panels: vec![Panel::new("nothing", Vec::new())],
            ..Figure::default()
        };
        assert!(document(&empty, Size::SMALL).ends_with("</svg>"));
    }
}
