//! Three tables of many diagnoses: one row per diagnosis, per cause, per parameter.
//!
//! Columns are stable: names and meanings do not change, and new ones are added before `written_by`.

use super::document::{BudgetStep, Cause, Document, Gap, Interval, Unexplained};
use super::identified::full_name;
use super::table::{Columns, Table};

/// Program that wrote a table: the last column, because CSV has no comments.
const WRITTEN_BY: &str = concat!("written by motorlab tabulate ", env!("CARGO_PKG_VERSION"));

/// The tables.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    /// A row per diagnosis.
    pub diagnoses: Table,
    /// A row per cause of a diagnosis.
    pub causes: Table,
    /// A row per identified parameter of a diagnosis.
    pub numbers: Table,
}

/// Tables of these diagnoses, in their order.
pub fn tables(documents: &[Document]) -> Tables {
    Tables {
        diagnoses: diagnoses(documents),
        causes: causes(documents),
        numbers: numbers(documents),
    }
}

fn diagnoses(documents: &[Document]) -> Table {
    let gap = |of: fn(&Gap) -> Option<f64>| move |d: &Document| d.gap.as_ref().and_then(of);
    let findings = |severity: &'static str| {
        move |d: &Document| {
            let found = d.data.iter().filter(|finding| finding.severity == severity);
            Some(found.count() as i64)
        }
    };
    let unexplained = |of: fn(&Unexplained) -> Option<f64>| {
        move |d: &Document| d.unexplained.as_ref().and_then(of)
    };
    Columns::of(documents)
        .text("document", |d| Some(d.document.clone()))
        .text("unit", |d| Some(d.unit()))
        .text("started", Document::started)
        .text("verdict", |d| Some(d.verdict.clone()))
        .number("probability", |d| Some(d.probability))
        .text("effects", |d| Some(d.effects.join("+")))
        .text("stage", |d| d.stage().map(str::to_owned))
        .text("sentence", |d| Some(d.sentence.clone()))
        .text("note", |d| Some(d.note.clone()))
        .text("likeliest_cause", |d| Some(d.most_probable()?.0))
        .number("likeliest_cause_probability", |d| {
            Some(d.most_probable()?.1)
        })
        .number("none_probability", Document::probability_of_none)
        .number("unknown_probability", |d| d.stated_probability("unknown"))
        .number("before_counts", gap(|gap| gap.before))
        .number("after_parameters_counts", gap(|gap| gap.after_parameters))
        .number("after_effect_counts", gap(|gap| gap.after_effect))
        .number("closed", gap(|gap| gap.closed))
        .number("closed_lo95", gap(|gap| gap.closed_lo95))
        .number("closed_hi95", gap(|gap| gap.closed_hi95))
        .number("floor_counts", gap(|gap| gap.floor))
        .number("wander_counts", gap(|gap| gap.random_load))
        .number("travel_counts", gap(|gap| gap.travel))
        .number("horizon_s", gap(|gap| gap.horizon_s))
        .number("fitted_before_counts", gap(|gap| gap.fitted.before))
        .number(
            "fitted_after_parameters_counts",
            gap(|gap| gap.fitted.after_parameters),
        )
        .number(
            "fitted_after_effect_counts",
            gap(|gap| gap.fitted.after_effect),
        )
        .whole("fatal_findings", findings("fatal"))
        .whole("warnings", findings("warning"))
        .whole("notes", findings("note"))
        .text("finding_ids", |d| {
            let ids: Vec<&str> = d.data.iter().map(|finding| finding.id.as_str()).collect();
            Some(ids.join("+"))
        })
        .text("next_profile", |d| {
            d.next_experiment.as_ref().map(|next| next.profile.clone())
        })
        .number("next_separation", |d| {
            d.next_experiment.as_ref()?.expected_separation
        })
        .whole("runs", |d| {
            some_runs(d).then(|| d.diagnosed().count() as i64)
        })
        .whole("samples", |d| {
            some_runs(d).then(|| d.diagnosed().map(|run| run.samples).sum())
        })
        .number("sample_time_s", |d| {
            d.diagnosed().next().map(|run| run.sample_time_s)
        })
        .number("duration_s", |d| {
            some_runs(d).then(|| d.diagnosed().map(|run| run.duration_s).sum())
        })
        .number("elapsed_s", |d| Some(d.elapsed_s))
        .text("shape", |d| Some(d.shape.clone()))
        .number("parameters_share", |d| d.budget_step("parameters")?.share)
        .number("unexplained_counts", unexplained(|left| left.rms_counts))
        .number("unexplained_share", unexplained(|left| left.share))
        .number("unexplained_lo95", unexplained(|left| left.lo95))
        .number("unexplained_hi95", unexplained(|left| left.hi95))
        .number(
            "equivalent_torque_share",
            unexplained(|left| left.equivalent_torque_share),
        )
        .text("written_by", |_| Some(WRITTEN_BY.to_owned()))
        .table()
}

fn some_runs(document: &Document) -> bool {
    !document.runs.is_empty()
}

struct CauseRow<'a> {
    of: &'a Document,
    rank: usize,
    cause: &'a Cause,
}

impl CauseRow<'_> {
    /// The step of the error budget of this effect.
    fn step(&self) -> Option<&BudgetStep> {
        self.of.budget_step(&self.cause.effect)
    }
}

fn causes(documents: &[Document]) -> Table {
    let rows: Vec<CauseRow<'_>> = documents
        .iter()
        .flat_map(|of| {
            let causes = of.causes.iter().enumerate();
            causes.map(move |(k, cause)| CauseRow {
                of,
                rank: k + 1,
                cause,
            })
        })
        .collect();
    Columns::of(&rows)
        .text("document", |row| Some(row.of.document.clone()))
        .text("unit", |row| Some(row.of.unit()))
        .text("started", |row| row.of.started())
        .text("verdict", |row| Some(row.of.verdict.clone()))
        .whole("rank", |row| i64::try_from(row.rank).ok())
        .text("effect", |row| Some(row.cause.effect.clone()))
        .whole("named", |row| Some(i64::from(row.of.identifies(row.cause))))
        .text("stage", |row| row.cause.stage.clone())
        .number("probability", |row| Some(row.of.probability_of(row.cause)))
        .number("inclusion", |row| Some(row.cause.inclusion))
        .text("class", |row| row.cause.class.clone())
        .number("class_probability", |row| row.cause.class_probability)
        .text("indistinguishable_from", |row| {
            Some(row.cause.indistinguishable_from.join(" "))
        })
        .number("gain_nats", |row| {
            row.cause.evidence.and_then(|evidence| evidence.gain_nats)
        })
        .number("error_nats", |row| {
            row.cause.evidence.and_then(|evidence| evidence.error_nats)
        })
        .whole("gaining_pieces", |row| {
            row.cause.evidence.map(|evidence| evidence.gaining_segments)
        })
        .whole("pieces", |row| {
            row.cause.evidence.map(|evidence| evidence.segments)
        })
        .whole("at_bound", |row| row.cause.at_bound.map(i64::from))
        .number("removed_share", |row| row.step()?.share)
        .number("removed_share_lo95", |row| row.step()?.lo95)
        .number("removed_share_hi95", |row| row.step()?.hi95)
        .text("written_by", |_| Some(WRITTEN_BY.to_owned()))
        .table()
}

struct NumberRow<'a> {
    of: &'a Document,
    /// `None` for a base parameter.
    cause: Option<&'a Cause>,
    name: String,
    number: &'a Interval,
}

fn numbers(documents: &[Document]) -> Table {
    let rows: Vec<NumberRow<'_>> = documents
        .iter()
        .flat_map(|of| {
            let base = of.base.iter().map(move |(name, number)| NumberRow {
                of,
                cause: None,
                name: name.clone(),
                number,
            });
            let causes = of.causes.iter().flat_map(move |cause| {
                cause.parameters.iter().map(move |(key, number)| NumberRow {
                    of,
                    cause: Some(cause),
                    name: full_name(&cause.effect, key),
                    number,
                })
            });
            base.chain(causes)
        })
        .collect();
    Columns::of(&rows)
        .text("document", |row| Some(row.of.document.clone()))
        .text("unit", |row| Some(row.of.unit()))
        .text("started", |row| row.of.started())
        .text("cause", |row| row.cause.map(|cause| cause.effect.clone()))
        .whole("named", |row| {
            let cause = row.cause?;
            Some(i64::from(row.of.identifies(cause)))
        })
        .number("probability", |row| Some(row.of.probability_of(row.cause?)))
        .text("name", |row| Some(row.name.clone()))
        .number("value", |row| Some(row.number.value))
        .number("lo95", |row| Some(row.number.lo95))
        .number("hi95", |row| Some(row.number.hi95))
        .text("si_unit", |row| Some(row.number.unit.clone()))
        .number("inclusion", |row| Some(row.cause?.inclusion))
        .text("written_by", |_| Some(WRITTEN_BY.to_owned()))
        .table()
}
