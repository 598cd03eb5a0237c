//! The page of a score.

use super::text::{
    confusion, coverage, effects, facts, headline, lead, misses, outside, reliability, strengths,
};
use super::{Score, Share};
use crate::report::table::Table;
use crate::report::{Figure, Matrix, Page, Panel, Series, Size, Stroke};

/// The page.
pub fn page(score: &Score) -> String {
    let mut page = Page::new("Blind: verdicts on sealed cases");
    page.lead(&lead(score));
    for fact in facts(score) {
        page.note(&fact);
    }
    page.note("Shares stand with their 95 % intervals (Wilson).");
    put(&mut page, "Figures", &headline(score));
    page.section("Confusion matrix (true x predicted)");
    page.matrix(
        &matrix(score),
        "Single effects, nothing, and outside the catalogue. Green: said as it is. The darker, the larger \
         the share of the row.",
    );
    put(&mut page, "By strength", &strengths(score));
    if score.by_strength.len() > 1 {
        page.figure(
            &strength_figure(score),
            Size::SMALL,
            "Single effects by the angle that they change. Dashed: 95 % intervals of what is right.",
        );
    }
    put(&mut page, "By effect", &effects(score));
    put(&mut page, "Outside the catalogue", &outside(score));
    put(&mut page, "Reliability", &reliability(score));
    if score.probabilities.reliability.len() > 1 {
        page.figure(
            &reliability_figure(score),
            Size::SMALL,
            "Probability said against the share that is right. On the dashed line probabilities hold.",
        );
    }
    page.section("Gap closed: said, and on the unseen run");
    page.figure(
        &gap_figure(score),
        Size::PAGE,
        "A dot a case; below the dashed line the claim exceeds the measured reduction. Shares below \u{2212}1 stand at \u{2212}1.",
    );
    put(&mut page, "Estimates", &coverage(score));
    confusion_text(&mut page, score);
    page.section(&format!("Missed ({})", misses(score).len()));
    page.list(misses(score));
    page.finish()
}

fn put(page: &mut Page, title: &str, table: &Table) {
    page.section(title);
    page.table(&table.names(), table.rows());
}

fn confusion_text(page: &mut Page, score: &Score) {
    page.section("Confusion matrix (true x predicted), as text");
    page.verbatim(&format!(
        "{}\n{}",
        confusion(score),
        super::text::confusion_key(score)
    ));
}

/// Rows and columns with cases; effects first.
fn matrix(score: &Score) -> Matrix {
    let confusion = &score.confusion;
    let in_row = |r: usize| confusion.counts[r].iter().any(|&n| n > 0);
    let in_column = |c: usize| confusion.counts.iter().any(|row| row[c] > 0);
    let named = |name: &String| confusion.rows.iter().position(|row| row == name);
    let rows: Vec<usize> = (0..confusion.rows.len()).filter(|&r| in_row(r)).collect();
    let columns: Vec<usize> = (0..confusion.columns.len())
        .filter(|&c| in_column(c) || named(&confusion.columns[c]).is_some_and(in_row))
        .collect();
    // For an outside cause the right verdict is `unknown`.
    let row_name = |r: &usize| match confusion.rows[*r].as_str() {
        "outside" => "unknown".to_owned(),
        name => name.to_owned(),
    };
    Matrix {
        title: "Cases".to_owned(),
        row_label: "true".to_owned(),
        column_label: "predicted".to_owned(),
        rows: rows.iter().map(row_name).collect(),
        columns: columns
            .iter()
            .map(|&c| confusion.columns[c].clone())
            .collect(),
        counts: rows
            .iter()
            .map(|&r| columns.iter().map(|&c| confusion.counts[r][c]).collect())
            .collect(),
    }
}

/// Shares over the logarithm of the strength, at the middle of each band.
fn strength_figure(score: &Score) -> Figure {
    let rows = &score.by_strength;
    let x: Vec<f64> = rows
        .iter()
        .map(|row| {
            let low = row.from_counts.max(0.5);
            let high = row.to_counts.unwrap_or(10.0 * low);
            (low * high).sqrt().log10()
        })
        .collect();
    let shares = |share: &dyn Fn(Share) -> Option<f64>, named: bool| -> Vec<f64> {
        let of_row = |row: &super::StrengthRow| match named {
            true => row.standing.named,
            false => row.standing.right,
        };
        rows.iter()
            .map(|row| share(of_row(row)).map_or(f64::NAN, |s| 100.0 * s))
            .collect()
    };
    let value = |share: Share| share.value();
    let low = |share: Share| share.interval95().map(|i| i.0);
    let high = |share: Share| share.interval95().map(|i| i.1);
    let series = vec![
        Series::new("right", Stroke::Line, 2, &x, &shares(&value, false)),
        Series::new("named outright", Stroke::Line, 0, &x, &shares(&value, true)),
        Series::new("", Stroke::Dashed, 2, &x, &shares(&low, false)),
        Series::new("", Stroke::Dashed, 2, &x, &shares(&high, false)),
    ];
    Figure {
        title: "Right by strength".to_owned(),
        x_label: "strength (log10 of counts RMS)".to_owned(),
        panels: vec![Panel::new("cases (%)", series).marked(100.0, "")],
    }
}

fn reliability_figure(score: &Score) -> Figure {
    let rows = &score.probabilities.reliability;
    let x: Vec<f64> = rows.iter().map(|row| row.mean_probability).collect();
    let of = |pick: &dyn Fn(Share) -> Option<f64>| -> Vec<f64> {
        rows.iter()
            .map(|row| pick(row.right).unwrap_or(f64::NAN))
            .collect()
    };
    let series = vec![
        Series::new("right", Stroke::Line, 2, &x, &of(&|s| s.value())),
        Series::new(
            "",
            Stroke::Dashed,
            2,
            &x,
            &of(&|s| s.interval95().map(|i| i.0)),
        ),
        Series::new(
            "",
            Stroke::Dashed,
            2,
            &x,
            &of(&|s| s.interval95().map(|i| i.1)),
        ),
        Series::new("as said", Stroke::Dashed, 6, &[0.0, 1.0], &[0.0, 1.0]),
    ];
    Figure {
        title: "Reliability".to_owned(),
        x_label: "probability said".to_owned(),
        panels: vec![Panel::new("share right", series)],
    }
}

fn gap_figure(score: &Score) -> Figure {
    let mut points: Vec<(f64, f64)> = score
        .cases
        .iter()
        .filter_map(|j| j.gap.and_then(|gap| gap.claimed.zip(gap.unseen)))
        .map(|(said, found)| (said.max(-1.0), found.max(-1.0)))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let cases = Series {
        name: "case".to_owned(),
        stroke: Stroke::Dots,
        colour: 0,
        points,
    };
    let kept = Series::new(
        "kept as said",
        Stroke::Dashed,
        6,
        &[-1.0, 1.0],
        &[-1.0, 1.0],
    );
    Figure {
        title: "Share of the gap closed".to_owned(),
        x_label: "said".to_owned(),
        panels: vec![Panel::new("on the unseen run", vec![cases, kept])],
    }
}
