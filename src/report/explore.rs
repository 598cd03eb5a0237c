//! Data of a figure for the page's script: packed values in an attribute of the figure.
//!
//! Values are 16-bit integers between a curve's minimum and maximum, exact for counts where they fit; times are
//! 32-bit floats; both in base 64. The script is [uPlot](https://github.com/leeoniya/uPlot) 1.6.32 (MIT) and
//! `explore.js`.

use serde_json::{Value, json};

use super::figure::{Figure, Panel, Series, Stroke, widened};
use super::svg::Size;

/// uPlot with its licence, then the script that uses it.
pub(super) const SCRIPT: [&str; 3] = [
    include_str!("uplot/LICENSE"),
    include_str!("uplot/uPlot.iife.min.js"),
    include_str!("explore.js"),
];
/// Styles of uPlot and of the figures.
pub(super) const STYLE: [&str; 2] = [
    include_str!("uplot/uPlot.min.css"),
    ".wide.scrolls::before{content:'more columns: scroll sideways \\2192';position:sticky;left:0;font-size:.8rem;color:var(--faint)}\
figure.explored>.broad,figure.explored>.narrow,figure.explored>svg{display:none}\
.live .title{font-weight:600;font-size:.9rem;margin:.4rem 0}.live .axis{font-size:.8rem;margin:.5rem 0 0}\
.live .uplot,.live .u-wrap{max-width:100%}.live .u-legend{font-size:.75rem;text-align:left;margin:0}\
.live .u-legend th,.live .u-legend td{border:0;padding:.1rem .3rem .1rem 0;font-weight:400}.live .u-legend tr{margin-right:.6rem}\
.live .u-series.nameless{display:none}\
.live .u-select{background:color-mix(in srgb,var(--ink) 12%,transparent)}\
.live .bar{display:flex;flex-wrap:wrap;gap:.3rem;align-items:center;font-size:.8rem;color:var(--faint)}\
.live button{font:inherit;min-width:2rem;padding:.1rem .5rem;color:var(--ink);background:none;border:1px solid var(--grid);border-radius:4px;cursor:pointer}",
];

/// Most rows of a panel; more are reduced to their extremes. Half a megabyte for a figure of a dozen curves.
const ROWS: usize = 8000;
/// Number of integer steps; the two integers above mean `no value` and `no such row`.
const STEPS: f64 = 65533.0;
const ABSENT: u16 = 65534;
const GAP: u16 = 65535;
/// Most decimals of a value.
const MOST_DECIMALS: f64 = 100.0;
/// Height of the x axis below a panel in pixels.
const AXIS: f64 = 30.0;
/// Height of the x axis label and width of a y axis label in pixels.
const NAME: f64 = 18.0;
/// Least height of a panel without its axis in pixels.
const LOW: f64 = 70.0;

/// The figure in the script's format.
pub(super) fn data(figure: &Figure, size: Size) -> String {
    let weights: f64 = figure.panels.iter().map(|panel| panel.weight).sum();
    let last = figure.panels.len().saturating_sub(1);
    let mut times: Vec<(usize, String)> = Vec::new();
    let panels: Vec<Value> = (figure.panels.iter().enumerate())
        .map(|(k, panel)| {
            let rows = Rows::of(panel);
            let packed = base64(rows.x.iter().flat_map(|x| (*x as f32).to_le_bytes()));
            // Panels over the same times refer to the first of them.
            let same = times.iter().find(|(_, other)| *other == packed);
            let t = same.map_or_else(|| json!(packed), |(first, _)| json!(first));
            if same.is_none() {
                times.push((k, packed));
            }
            let scale = panel.scale();
            let (low, high) = widened(scale.map_or((0.0, 1.0), |scale| scale.range));
            json!({
                "y": panel.y_label,
                "h": (f64::from(size.height) * panel.weight / weights).max(LOW) + AXIS
                    + if k == last { NAME } else { 0.0 },
                "range": [low, high],
                "said": scale.and_then(|scale| scale.words()),
                "marks": panel.marks,
                "starts": panel.starts,
                "bands": panel.bands.iter().map(|band| json!([band.from, band.to, band.strength, band.label])).collect::<Vec<_>>(),
                "t": t,
                "s": panel.series.iter().zip(&rows.y).map(|(series, y)| curve(series, y)).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({ "title": figure.title, "x": figure.x_label, "panels": panels }).to_string()
}

/// The curves of a panel over one column of x.
struct Rows {
    x: Vec<f64>,
    /// One column per curve; `None` where it has no such x.
    y: Vec<Vec<Option<f64>>>,
}

impl Rows {
    fn of(panel: &Panel) -> Self {
        let all = Self::all(panel);
        let count = all.x.len();
        if count <= ROWS {
            return all;
        }
        // Every block keeps each curve's minimum and maximum, and a gap.
        let blocks = (ROWS / (3 * all.y.len().max(1))).max(1);
        let long = count.div_ceil(blocks);
        let mut kept = Vec::new();
        for from in (0..count).step_by(long) {
            let block = from..(from + long).min(count);
            let before = kept.len();
            for column in &all.y {
                let value = |k: &usize| column[*k].filter(|y| y.is_finite());
                let seen = || block.clone().filter(|k| value(k).is_some());
                kept.extend(seen().min_by(|a, b| {
                    column[*a]
                        .partial_cmp(&column[*b])
                        .unwrap_or(std::cmp::Ordering::Equal)
                }));
                kept.extend(seen().max_by(|a, b| {
                    column[*a]
                        .partial_cmp(&column[*b])
                        .unwrap_or(std::cmp::Ordering::Equal)
                }));
                let is_gap = |k: &usize| column[*k].is_some_and(|y| !y.is_finite());
                kept.extend(block.clone().find(is_gap));
            }
            if kept.len() == before {
                kept.push(from);
            }
        }
        kept.extend([0, count - 1]);
        kept.sort_unstable();
        kept.dedup();
        Self {
            x: kept.iter().map(|k| all.x[*k]).collect(),
            y: (all.y.iter())
                .map(|column| kept.iter().map(|k| column[*k]).collect())
                .collect(),
        }
    }

    fn all(panel: &Panel) -> Self {
        let xs = |series: &Series| -> Vec<f64> { series.points.iter().map(|p| p.0).collect() };
        let first = panel.series.first().map_or_else(Vec::new, xs);
        let is_finite = first.iter().all(|x| x.is_finite());
        if is_finite && panel.series.iter().all(|series| xs(series) == first) {
            let column = |series: &Series| series.points.iter().map(|p| Some(p.1)).collect();
            return Self {
                x: first,
                y: panel.series.iter().map(column).collect(),
            };
        }
        let mut x: Vec<f64> = (panel.series.iter().flat_map(xs))
            .filter(|x| x.is_finite())
            .collect();
        x.sort_by(f64::total_cmp);
        x.dedup();
        let column = |series: &Series| {
            let mut column = vec![None; x.len()];
            for (at, y) in &series.points {
                if let Ok(k) = x.binary_search_by(|x| x.total_cmp(at)) {
                    column[k] = Some(*y);
                }
            }
            column
        };
        let y = panel.series.iter().map(column).collect();
        Self { x, y }
    }
}

fn curve(series: &Series, y: &[Option<f64>]) -> Value {
    let finite = || y.iter().flatten().filter(|y| y.is_finite());
    let low = finite().copied().fold(f64::INFINITY, f64::min);
    let high = finite().copied().fold(f64::NEG_INFINITY, f64::max);
    let (low, span) = if low <= high {
        (low, high - low)
    } else {
        (0.0, 0.0)
    };
    let are_counts = span <= STEPS && finite().all(|y| y.fract() == 0.0);
    let step = match (are_counts, span > 0.0) {
        (true, _) | (_, false) => 1.0,
        _ => span / STEPS,
    };
    let pack = |y: &Option<f64>| match y {
        None => ABSENT,
        Some(y) if y.is_finite() => ((y - low) / step).round() as u16,
        Some(_) => GAP,
    };
    json!({
        "n": series.name,
        "k": match series.stroke {
            Stroke::Line => "line",
            Stroke::Dashed => "dash",
            Stroke::Step => "step",
            Stroke::FaintStep => "faint",
            Stroke::Broad => "broad",
            Stroke::BroadStep => "broadstep",
            Stroke::Dots => "dots",
            Stroke::Lower => "lower",
            Stroke::Upper => "upper",
        },
        "c": series.colour % super::svg::COLOURS,
        "lo": low,
        "step": step,
        "decimals": (-step.log10()).floor().clamp(-MOST_DECIMALS, MOST_DECIMALS) as i8,
        "v": base64(y.iter().flat_map(|y| pack(y).to_le_bytes())),
    })
}

/// Bytes in base 64 (RFC 4648, section 4), without a dependency.
fn base64(bytes: impl Iterator<Item = u8>) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> = bytes.collect();
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |k: usize| u32::from(three.get(k).copied().unwrap_or(0));
        let bits = (at(0) << 16) | (at(1) << 8) | at(2);
        for k in 0..4 {
            if k <= three.len() {
                out.push(char::from(LETTERS[(bits >> (18 - 6 * k)) as usize & 63]));
            } else {
                out.push('=');
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 4648, section 10.
    #[test]
    fn bytes_are_encoded_as_in_the_standard() {
        for (plain, packed) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.bytes()), packed);
        }
    }

    #[test]
    fn a_long_curve_keeps_its_peaks_and_integer_counts() {
        let x: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut y = vec![0.0; 100_000];
        (y[77_777], y[33_333]) = (9.0, -9.0);
        let panel = Panel::new("y", vec![Series::new("a", Stroke::Line, 0, &x, &y)]);
        let rows = Rows::of(&panel);
        assert!(rows.x.len() <= ROWS + 2, "{}", rows.x.len());
        assert!(rows.x.contains(&77_777.0) && rows.x.contains(&33_333.0));
        let packed = curve(&panel.series[0], &rows.y[0]);
        assert_eq!(
            (&packed["lo"], &packed["step"]),
            (&json!(-9.0), &json!(1.0))
        );
    }

    #[test]
    fn curves_of_different_times_share_a_column_and_keep_gaps() {
        let panel = Panel::new(
            "y",
            vec![
                Series::new("a", Stroke::Line, 0, &[0.0, 2.0], &[1.5, f64::NAN]),
                Series::new("b", Stroke::Line, 1, &[1.0, 2.0], &[3.0, 4.0]),
            ],
        );
        let rows = Rows::of(&panel);
        assert_eq!(rows.x, [0.0, 1.0, 2.0]);
        assert_eq!(rows.y[0][1], None);
        // 0 and the code of a gap, low byte first: 00 00, fe ff, ff ff.
        assert_eq!(curve(&panel.series[0], &rows.y[0])["v"], "AAD+////");
    }

    /// The data of a page without its figures are below 60 kB.
    #[test]
    fn the_inlined_library_is_small() {
        let uplot = SCRIPT[0].len() + SCRIPT[1].len() + STYLE[0].len();
        assert!(uplot <= 60_000, "{uplot}");
        assert!(
            SCRIPT
                .iter()
                .all(|part| !part.contains("</script") && !part.contains("*/\n*/"))
        );
    }
}
