//! The page of a planned recording: the effects that it shows and separates, as a heatmap.

use std::fmt::Write;

use super::Page;
use super::escape::escaped;
use super::number::figure;
use crate::diagnose::{Isolability, Pair};

/// Separation above which two effects are clearly separated, in standard deviations.
pub const CLEAR: f64 = 10.0;
/// Separation with the lightest shade.
const MOST: f64 = 10.0 * CLEAR;
/// Side of a cell and space for the names, in pixels.
const CELL: f64 = 17.0;
const NAMES: f64 = 165.0;
/// Height of the colour scale.
const LEGEND: f64 = 44.0;
/// Steps of the colour scale.
const STEPS: usize = 24;
/// Most pairs listed.
const LISTED: usize = 60;

/// The page; `command` is the command line that records the plan.
pub fn page(found: &Isolability, command: &str) -> String {
    let mut page = Page::new("Effects that a planned recording separates");
    page.lead(&lead(found));
    page.paragraph("Record it:");
    page.verbatim(command);
    page.drawing(
        &heatmap(found),
        "Separation D of each effect from each other one in standard deviations, from the pair's less favourable side. Full colour: a recording of this profile does not separate them. The row and column of none: whether the effect is visible at all.",
    );
    let rows = |pairs: &[Pair], is_pair: bool| -> Vec<Vec<String>> {
        let row = |pair: &Pair| match is_pair {
            true => vec![
                pair.a.to_owned(),
                pair.b.to_owned(),
                figure(pair.separation, 3),
            ],
            false => vec![pair.a.to_owned(), figure(pair.separation, 3)],
        };
        pairs.iter().take(LISTED).map(row).collect()
    };
    page.section("Not visible");
    match found.cannot_see.is_empty() {
        true => page.answer("None: every effect is visible."),
        false => page.table(
            &["effect", "separation D from none"],
            &rows(&found.cannot_see, false),
        ),
    }
    page.section("Visible, but not separable");
    match found.cannot_tell_apart.is_empty() {
        true => page.answer("None: every pair of visible effects is separable."),
        false => page.table(
            &["effect", "other effect", "separation D"],
            &rows(&found.cannot_tell_apart, true),
        ),
    }
    if found.cannot_tell_apart.len() > LISTED {
        page.note(&format!(
            "{} more pairs are in the JSON.",
            found.cannot_tell_apart.len() - LISTED
        ));
    }
    page.note(&format!(
        "D: how far the predictions of the two differ at typical magnitudes, after the parameters of the rival are fitted. Below {} they are not separable.",
        found.tie_below
    ));
    page.finish()
}

fn lead(found: &Isolability) -> String {
    let effects = found.effects.len().saturating_sub(1);
    let visible = effects - found.cannot_see.len();
    let pairs = visible * visible.saturating_sub(1) / 2;
    format!(
        "{} at {} V, {} samples every {} s: {visible} of {effects} effects are visible, and {} of their {pairs} pairs separable.",
        found.profile,
        found.supply_v,
        found.samples,
        found.sample_time_s,
        pairs.saturating_sub(found.cannot_tell_apart.len())
    )
}

/// Shade of a separation: 1 at the threshold and below, 0 at ten times `CLEAR`.
fn darkness(separation: f64, tie_below: f64) -> f64 {
    let share = (separation.max(tie_below) / tie_below).ln() / (MOST / tie_below).ln();
    if share.is_finite() {
        1.0 - share.clamp(0.0, 1.0)
    } else {
        0.0
    }
}

fn heatmap(found: &Isolability) -> String {
    let n = found.effects.len();
    let side = CELL * n as f64;
    let (width, height) = (NAMES + side + 8.0, NAMES + side + LEGEND);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\" style=\"min-width:{:.0}px;max-width:{width}px\" role=\"img\" aria-label=\"separation of effects\">",
        0.7 * width
    );
    for (i, effect) in found.effects.iter().enumerate() {
        let middle = NAMES + CELL * (i as f64 + 0.5) + 4.0;
        let name = escaped(effect);
        let _ = write!(
            out,
            "<text class=\"tick\" x=\"{:.1}\" y=\"{middle:.1}\" text-anchor=\"end\">{name}</text><text class=\"tick\" transform=\"translate({middle:.1} {:.1}) rotate(-90)\">{name}</text>",
            NAMES - 5.0,
            NAMES - 5.0
        );
        for j in (0..n).filter(|j| *j != i) {
            let separation = found.between(i, j);
            let _ = write!(
                out,
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"var(--c1)\" fill-opacity=\"{:.2}\" stroke=\"var(--grid)\" stroke-width=\".5\"><title>{name}, {}: D = {}</title></rect>",
                NAMES + CELL * j as f64,
                NAMES + CELL * i as f64,
                darkness(separation, found.tie_below),
                escaped(found.effects[j]),
                figure(separation, 3)
            );
        }
    }
    // A logarithmic scale with the threshold, `CLEAR`, and ten times that.
    let (top, long) = (NAMES + side + 12.0, side.min(260.0));
    let ratio = MOST / found.tie_below;
    for k in 0..STEPS {
        let share = k as f64 / (STEPS - 1) as f64;
        let _ = write!(
            out,
            "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"10\" fill=\"var(--c1)\" fill-opacity=\"{:.2}\"/>",
            NAMES + long * k as f64 / STEPS as f64,
            long / STEPS as f64,
            darkness(found.tie_below * ratio.powf(share), found.tie_below)
        );
    }
    for value in [found.tie_below, CLEAR, MOST] {
        let x = NAMES + long * (value / found.tie_below).ln() / ratio.ln();
        let _ = write!(
            out,
            "<path class=\"frame\" d=\"M{x:.1} {top:.1}v13\"/><text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{value}</text>",
            top + 24.0
        );
    }
    let _ = write!(
        out,
        "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">separation D</text></svg>",
        NAMES - 12.0,
        top + 10.0
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inseparable_effects_are_darkest_and_separable_ones_unshaded() {
        assert_eq!(darkness(0.0, 3.0), 1.0);
        assert_eq!(darkness(3.0, 3.0), 1.0);
        assert_eq!(darkness(100.0, 3.0), 0.0);
        assert_eq!(darkness(f64::INFINITY, 3.0), 0.0);
        let clear = darkness(CLEAR, 3.0);
        assert!(clear > 0.3 && clear < 0.8, "{clear}");
    }
}
