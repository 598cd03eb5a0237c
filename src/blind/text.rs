//! A score as text and tables, for the terminal and for pages.

use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use super::{Judgement, Score, Share, TruthKind};
use crate::plain::{markdown_text, one_line};
use crate::report::table::Table;

/// Main figures with their targets: name, reached, target.
pub(super) fn headline(score: &Score) -> Table {
    let mut table = Table::new(["", "reached", "wanted"]);
    let mut row = |name: &str, reached: String, wanted: &str| {
        table.row([name.to_owned(), reached, wanted.to_owned()]);
    };
    row(
        "single effects named outright",
        score.singles.named.words(),
        "90 %",
    );
    row(
        "single effects right, ties stated included",
        score.singles.right.words(),
        "97 %",
    );
    row(
        "single effects besides, said to look like none in these runs",
        score.singles_hidden.words(),
        "",
    );
    row("pairs, both right", score.pairs.right.words(), "80 %");
    row(
        "pairs, one of two right",
        score.pairs_half_right.words(),
        "",
    );
    row(
        "false alarms where nothing is",
        score.false_alarms.words(),
        "at most 2 %",
    );
    row(
        "outside the catalogue, flagged",
        score.outside.flagged.words(),
        "90 %",
    );
    row(
        "outside, taken for an effect",
        score.outside.taken_for_an_effect.words(),
        "",
    );
    row(
        "Brier score of what is said",
        number(score.probabilities.brier, 3),
        "at most 0.05",
    );
    row(
        "Brier score over all causes (0 to 2)",
        number(score.probabilities.brier_all_causes, 3),
        "",
    );
    row(
        "log score of the truth (nats)",
        number(score.probabilities.log_score, 2),
        "",
    );
    row(
        "verdicts of 90 % and more, right",
        score.probabilities.right_from_90.words(),
        "90 %",
    );
    row(
        "95 % intervals that hold the truth",
        score.coverage.intervals.words(),
        "90 to 99 %",
    );
    row(
        "whole numbers right (cycles, sides)",
        score.coverage.whole_numbers.words(),
        "",
    );
    let gap = &score.gap;
    row(
        "unseen run, single effects, median (counts RMS)",
        format!(
            "{} ({} of the floor; nominal {}, the truth itself {})",
            number(gap.singles_after_counts, 3),
            number(gap.singles_after_over_floor, 2),
            number(gap.singles_before_counts, 1),
            number(gap.singles_truth_counts, 3)
        ),
        "1.5 of the floor",
    );
    row(
        "gap closed, median: said, on the unseen run",
        format!(
            "{}, {}",
            percent(gap.claimed_median),
            percent(gap.unseen_median)
        ),
        "",
    );
    row(
        "gap closed lies in the interval said",
        gap.in_interval.words(),
        "",
    );
    row(
        "time of a diagnosis (s): median, 90 %, longest",
        format!(
            "{}, {}, {}",
            number(score.time.median_s, 2),
            number(score.time.p90_s, 2),
            number(score.time.most_s, 2)
        ),
        "at most 2",
    );
    row(
        "ties stated (single effects)",
        score.ties.stated.words(),
        "",
    );
    row(
        "names in a tie: mean, most",
        format!(
            "{}, {}",
            number(score.ties.mean_names, 1),
            score.ties.most_names
        ),
        "",
    );
    row("cases without a diagnosis", score.failed.to_string(), "0");
    table
}

pub(super) fn effects(score: &Score) -> Table {
    let mut table = Table::new([
        "effect",
        "cases",
        "named",
        "right",
        "median strength",
        "taken for",
    ]);
    for row in &score.by_effect {
        let taken: Vec<String> = row
            .taken_for
            .iter()
            .map(|(name, times)| format!("{name} {times}"))
            .collect();
        table.row([
            row.effect.clone(),
            row.standing.right.of.to_string(),
            row.standing.named.percent(),
            row.standing.right.percent(),
            number(row.median_strength_counts, 1),
            taken.join(", "),
        ]);
    }
    table
}

pub(super) fn strengths(score: &Score) -> Table {
    let mut table = Table::new(["strength (counts RMS)", "cases", "named", "right"]);
    for row in &score.by_strength {
        let band = match row.to_counts {
            Some(to) => format!("{} to {to}", row.from_counts),
            None => format!("{} and more", row.from_counts),
        };
        table.row([
            band,
            row.standing.right.of.to_string(),
            row.standing.named.percent(),
            row.standing.right.percent(),
        ]);
    }
    table
}

pub(super) fn outside(score: &Score) -> Table {
    let mut table = Table::new(["outside the catalogue", "cases", "flagged"]);
    for (id, share) in &score.outside.by_id {
        table.row([id.clone(), share.of.to_string(), share.percent()]);
    }
    table
}

pub(super) fn reliability(score: &Score) -> Table {
    let mut table = Table::new(["probability said", "verdicts", "mean said", "right"]);
    for row in &score.probabilities.reliability {
        table.row([
            format!("{:.2} to {:.2}", row.from, row.to),
            row.right.of.to_string(),
            format!("{:.3}", row.mean_probability),
            row.right.words(),
        ]);
    }
    table
}

pub(super) fn coverage(score: &Score) -> Table {
    let mut table = Table::new(["parameter", "estimates", "right"]);
    for (name, share) in &score.coverage.by_parameter {
        table.row([name.clone(), share.of.to_string(), share.percent()]);
    }
    table
}

/// The confusion matrix with numbered columns, without empty rows and columns.
pub(super) fn confusion(score: &Score) -> Table {
    let confusion = &score.confusion;
    let columns = used_columns(score);
    let mut names = vec!["true \\ predicted".to_owned()];
    names.extend(columns.iter().map(|c| (c + 1).to_string()));
    let mut table = Table::new(names);
    for (r, row) in confusion.counts.iter().enumerate() {
        if row.iter().all(|&count| count == 0) {
            continue;
        }
        let name = &confusion.rows[r];
        let number = confusion.columns.iter().position(|column| column == name);
        let mut cells = vec![match number {
            Some(number) => format!("{:>2} {name}", number + 1),
            None => format!("   {name}"),
        }];
        cells.extend(columns.iter().map(|&c| match row[c] {
            0 => "·".to_owned(),
            count => count.to_string(),
        }));
        table.row(cells);
    }
    table
}

/// Non-empty columns of the confusion matrix.
fn used_columns(score: &Score) -> Vec<usize> {
    let confusion = &score.confusion;
    let is_used = |c: &usize| confusion.counts.iter().any(|row| row[*c] > 0);
    (0..confusion.columns.len()).filter(is_used).collect()
}

/// Legend of the numbered columns.
pub(super) fn confusion_key(score: &Score) -> String {
    let columns = &score.confusion.columns;
    let words: Vec<String> = (used_columns(score).into_iter())
        .map(|c| format!("{} {}", c + 1, columns[c]))
        .collect();
    format!("Columns: {}.", words.join(", "))
}

/// Every wrong case with its details.
pub(super) fn misses(score: &Score) -> Vec<String> {
    let missed = score.cases.iter().filter(|j| !j.is_right());
    missed
        .map(|missed| one_line(&miss(missed)).into_owned())
        .collect()
}

fn miss(j: &Judgement) -> String {
    let mut text = format!("{}: {}", j.case, j.truth.words());
    for effect in &j.truth.effects {
        let mut facts: Vec<String> = Vec::new();
        if let Some(strength) = j.truth.strength_counts.get(&effect.id) {
            facts.push(format!("{strength:.1} counts"));
        }
        facts.extend(
            effect
                .parameters
                .iter()
                .map(|(name, value)| format!("{name} {value}")),
        );
        if !facts.is_empty() {
            text += &format!(" [{}: {}]", effect.id, facts.join(", "));
        }
    }
    if let Some(beyond) = j
        .truth
        .beyond_refit_counts
        .filter(|_| j.truth.kind != TruthKind::None)
    {
        text += &format!(", {beyond:.2} counts beyond a refit");
    }
    if let Some(failure) = &j.failure {
        return text + &format!(". No diagnosis: {failure}");
    }
    text += &format!(". Said: {} ({:.3})", j.said_in_words(), j.probability_said);
    text += &match j.rank_of_truth {
        Some(rank) => format!("; the truth has {:.2e}, place {rank}", j.probability_truth),
        None => "; the truth is not among the sets weighed".to_owned(),
    };
    let likeliest: Vec<String> = j
        .likeliest
        .iter()
        .map(|(name, p)| format!("{name} {p:.3}"))
        .collect();
    text + &format!("; likeliest: {}", likeliest.join(", "))
}

/// The tables with their titles, in a fixed order.
fn tables(score: &Score) -> [(&'static str, Table); 7] {
    [
        ("Figures", headline(score)),
        ("By strength", strengths(score)),
        ("By effect", effects(score)),
        ("Outside the catalogue", outside(score)),
        ("Confusion", confusion(score)),
        ("Reliability", reliability(score)),
        ("Estimates", coverage(score)),
    ]
}

/// The score as text.
pub fn text(score: &Score) -> String {
    let mut out = facts(score).join("\n") + "\n\n";
    for (title, table) in tables(score) {
        out += &format!("{title}\n{table}\n");
        if title == "Confusion" {
            out += &format!("{}\n\n", confusion_key(score));
        }
    }
    let misses = misses(score);
    out += &format!("Missed ({})\n", misses.len());
    for miss in misses {
        out += &format!("  {miss}\n");
    }
    out
}

/// The score in Markdown.
pub fn markdown(score: &Score) -> String {
    let mut out = markdown_text(&lead(score)) + "\n\n";
    for fact in facts(score) {
        out += &format!("- {}\n", markdown_text(&fact));
    }
    for (title, table) in tables(score) {
        out += &format!("\n## {title}\n\n{}", table.markdown());
        if title == "Confusion" {
            out += &format!("\n{}\n", markdown_text(&confusion_key(score)));
        }
    }
    let misses = misses(score);
    out += &format!("\n## Missed ({})\n\n", misses.len());
    for miss in misses {
        out += &format!("- {}\n", markdown_text(&miss));
    }
    out
}

/// Description of the set, and reservations.
pub(super) fn facts(score: &Score) -> Vec<String> {
    let set = &score.set;
    let mut facts = vec![format!(
        "{} cases, judged by {}",
        set.cases,
        set.diagnosers.join(" and ")
    )];
    if let Some(recipe) = &set.recipe {
        let mut words = format!(
            "made with --cases {} --seed {} --kind {}",
            recipe.cases, recipe.seed, recipe.kind
        );
        if recipe.other_motors {
            words += " --other-motors";
        }
        if recipe.random_torque_scale != 1.0 {
            words += &format!(" --random-load {}", recipe.random_torque_scale);
        }
        facts.push(words);
    }
    if set.for_tuning {
        facts.push(
            "a tuning set: its figures say how well tuning went and are not to be published"
                .to_owned(),
        );
    }
    if set.diagnosers.len() > 1 {
        facts.push(
            "the program was changed between verdicts: these figures are of no version".to_owned(),
        );
    }
    facts.push(format!(
        "labels opened {}; the chain of verdicts ended in {}",
        rfc3339(set.opened_at),
        set.head
    ));
    if !set.order_proved {
        facts.push(ORDER_UNPROVED.to_owned());
    }
    facts
        .iter()
        .map(|fact| one_line(fact).into_owned())
        .collect()
}

/// Limit of a score without the head of the chain.
pub const ORDER_UNPROVED: &str = "without --head the order is not proved: verdicts could have been changed after the labels \
     were seen, with the chain made anew; give the hash that `blind run` printed and you wrote down";

fn rfc3339(time: OffsetDateTime) -> String {
    time.format(&Rfc3339).unwrap_or_else(|_| time.to_string())
}

/// The summary sentence.
pub(super) fn lead(score: &Score) -> String {
    let mut parts = Vec::new();
    let mut part = |share: Share, words: &str| {
        if share.of > 0 {
            parts.push(format!("{} {words}", share.percent()));
        }
    };
    part(score.singles.right, "of single effects right");
    part(score.singles.named, "named outright");
    part(score.pairs.right, "of pairs right");
    part(score.outside.flagged, "of unknown effects flagged");
    part(score.false_alarms, "false alarms");
    format!("{} cases: {}.", score.set.cases, parts.join(", "))
}

pub(super) fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.digits$}"))
}

fn percent(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |value| format!("{:.1} %", 100.0 * value))
}
