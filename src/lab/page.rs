//! The report: one offline HTML page for students and teachers.

mod figures;
mod ranking;

pub use figures::{recorded, residuals, sampled, step, step_responses};

use super::step_response::Curve;
use super::transfer::Pole;
use super::{Answer, Lab, Source};
use crate::export::{EQUATIONS, PARAMETERS};
use crate::report::comparison::figures_table;
use crate::report::demo::keys_words;
use crate::report::diagnosis::checks;
use crate::report::number::{change, figure, percent, rpm, rpm_or_unlimited, time};
use crate::report::{Page, Size};
use crate::units::rpm_from_rad_s;

/// Size of the drawings of Parts 1 and 2.
pub const TALL: Size = Size {
    width: 860,
    height: 620,
};

/// The report.
pub fn page(lab: &Lab) -> String {
    let mut page = Page::new("DC motor step response: the lab handout, answered");
    if !lab.findings.is_empty() {
        checks(&mut page, &lab.findings);
    }
    page.lead(&summary(lab));
    if let Source::VirtualBoard(board) = &lab.source {
        let keys = match keys_words(board) {
            none if none.is_empty() => none,
            keys => format!(" ({keys})"),
        };
        page.note(&format!(
            "No recording was given. The recordings of Part 3 come from motorlab's virtual board{keys}, a simulated motor behind the recorder's own protocol. They show the method, not a bench. Give your own with `--run step30.csv --run step3.csv`."
        ));
    }
    page.table(
        &["question", "answer"],
        &lab.answers
            .iter()
            .map(|answer| {
                let question = format!("{} {}", answer.number, answer.topic);
                vec![question, answer.short.clone()]
            })
            .collect::<Vec<_>>(),
    );
    page.note(
        "The handout numbers no questions: 1.2 is the second question of Part 1; letters are topics that its objectives name without asking. Every figure is computed from the motor file and the recordings.",
    );
    motor(&mut page, lab);
    part_1(&mut page, lab);
    part_2(&mut page, lab);
    part_3(&mut page, lab);
    page.section("Notes on the handout");
    page.list([
        "In its script the last two legend entries are exchanged: the curve drawn from w_2nd is named 1st order, the one from w_Tf is named 2nd order. Here each curve has the name of its model.",
        "Its list of parameters calls J an armature resistance; it is the inertia of rotor and load.",
    ]);
    page.finish()
}

fn summary(lab: &Lab) -> String {
    let short = |number: &str| {
        let answer = lab.answers.iter().find(|answer| answer.number == number);
        answer.map_or("", |answer| answer.short.as_str())
    };
    format!("{} {}", short("1.1"), short("1.2"))
}

fn motor(page: &mut Page, lab: &Lab) {
    page.section("The motor");
    page.verbatim(&EQUATIONS.join("\n"));
    let rows: Vec<Vec<String>> = PARAMETERS
        .iter()
        .map(|named| {
            vec![
                named.handout.to_owned(),
                named.symbol.to_owned(),
                named.value(&lab.parameters).to_string(),
                named.unit.to_owned(),
                named.meaning.to_owned(),
            ]
        })
        .collect();
    page.table(
        &["in the script", "symbol", "value", "unit", "meaning"],
        &rows,
    );
    if !lab.effects.is_empty() {
        page.note(&format!(
            "The motor file also has effects beyond the handout's models ({}). Parts 1 and 2 leave them out; Part 3 compares with and without them.",
            lab.effects.join(", ")
        ));
    }
}

fn answer(page: &mut Page, answer: &Answer) {
    let kind = if answer.number.ends_with(|c: char| c.is_ascii_digit()) {
        "Question"
    } else {
        "Topic"
    };
    page.subsection(&format!("{kind} {}: {}", answer.number, answer.topic));
    page.answer(&answer.short);
    page.list(&answer.because);
}

fn answers(page: &mut Page, lab: &Lab, part: char) {
    for found in lab
        .answers
        .iter()
        .filter(|answer| answer.number.starts_with(part))
    {
        answer(page, found);
    }
}

fn polynomial(coefficients: [f64; 3]) -> String {
    let terms: Vec<String> = coefficients
        .iter()
        .zip([" s\u{b2}", " s", ""])
        .filter(|(coefficient, _)| **coefficient != 0.0)
        .map(|(coefficient, power)| format!("{}{power}", figure(*coefficient, 4)))
        .collect();
    terms.join(" + ")
}

fn poles(poles: &[Pole]) -> String {
    let written: Vec<String> = poles
        .iter()
        .map(|pole| match pole.im {
            0.0 => figure(pole.re, 5),
            im => format!(
                "{} {} {}i",
                figure(pole.re, 5),
                if im > 0.0 { "+" } else { "\u{2212}" },
                figure(im.abs(), 5)
            ),
        })
        .collect();
    written.join(", ")
}

fn part_1(page: &mut Page, lab: &Lab) {
    let part = &lab.part_1;
    page.section("Part 1: step response of first- and second-order models");
    page.paragraph(&format!(
        "A step of {} V at t = 0 from rest, simulated over {} with data every {}.",
        figure(lab.parameters.supply_v, 4),
        time(part.t_s.last().copied().unwrap_or(0.0)),
        time(super::step_response::PRINT_S),
    ));
    page.figure(
        &figures::step_responses(lab),
        TALL,
        "Above: the five curves of the handout's script. Below: how far the first order runs ahead of the second.",
    );
    page.subsection("Transfer functions");
    for curve in &part.curves {
        if let Some(function) = &curve.transfer_function {
            page.fraction(
                &format!("{}: \u{3c9}(s) / V(s) =", curve.name),
                &figure(function.numerator, 4),
                &polynomial(function.denominator),
            );
        }
    }
    page.table(
        &[
            "model",
            "poles (1/s)",
            "time constants",
            "steady speed",
            "rad/s",
            "simulation off closed form (RPM)",
        ],
        &part.curves.iter().map(curve_row).collect::<Vec<_>>(),
    );
    page.note(
        "Coulomb friction has no transfer function. While the shaft turns one way it acts as a voltage R Tf / Kt taken off the supply: same pole, lower speed.",
    );
    page.subsection("Damping terms of the motor at steady speed");
    let rows: Vec<Vec<String>> = part
        .damping
        .shares
        .iter()
        .map(|share| {
            vec![
                share.term.words().to_owned(),
                figure(share.torque_nm, 4),
                percent(share.share),
                rpm_or_unlimited(share.steady_without_rad_s),
                share.steady_error.map_or_else(|| "–".to_owned(), change),
                share
                    .time_constant_without_s
                    .map_or_else(|| "unlimited".to_owned(), time),
            ]
        })
        .collect();
    page.table(
        &[
            "term",
            "torque (N\u{a0}m)",
            "share of stall torque",
            "steady speed without it",
            "error",
            "time constant without it",
        ],
        &rows,
    );
    page.note(&format!(
        "All terms together: {} from a stall torque of {} N m.",
        rpm_or_unlimited(part.damping.steady_rad_s),
        figure(part.damping.stall_torque_nm, 4)
    ));
    answers(page, lab, '1');
}

fn curve_row(curve: &Curve) -> Vec<String> {
    let constants: Vec<String> = curve.time_constants_s.iter().map(|&s| time(s)).collect();
    vec![
        curve.name.to_owned(),
        poles(&curve.poles),
        if constants.is_empty() {
            "unlimited".to_owned()
        } else {
            constants.join(", ")
        },
        rpm_or_unlimited(curve.steady_speed_rad_s),
        curve
            .steady_speed_rad_s
            .map_or_else(|| "–".to_owned(), |speed| figure(speed, 4)),
        figure(rpm_from_rad_s(curve.off_closed_form_rad_s), 1),
    ]
}

fn part_2(page: &mut Page, lab: &Lab) {
    let part = &lab.part_2;
    page.section("Part 2: first order with discretization and delay");
    page.paragraph(
        "The first-order response with viscous friction is integrated to the position, turned into counts, rounded, read every TS and differenced, as in the handout's diagram. The true speed lies beneath.",
    );
    for sampled in &part.responses {
        page.figure(
            &figures::sampled(sampled, &lab.part_1),
            Size::SMALL,
            &format!(
                "TS = {} s: one count in one sample is {} rad/s = {}; the difference is {} late.",
                sampled.sample_time_s,
                figure(sampled.figures.one_count_rad_s, 4),
                rpm(sampled.figures.one_count_rad_s),
                time(sampled.figures.half_sample_s)
            ),
        );
    }
    let rows: Vec<Vec<String>> = part
        .responses
        .iter()
        .map(|sampled| {
            let figures = &sampled.figures;
            let or_none = |value: Option<String>| value.unwrap_or_else(|| "–".to_owned());
            vec![
                sampled.sample_time_s.to_string(),
                figure(figures.one_count_rad_s, 4),
                rpm(figures.one_count_rad_s),
                or_none(figures.one_count_of_steady.map(percent)),
                or_none(figures.counts_per_sample.map(|counts| figure(counts, 4))),
                or_none(figures.scatter_rad_s.map(rpm)),
                time(figures.half_sample_s),
                rpm(figures.delay_error_rad_s),
                rpm(figures.error_rad_s),
            ]
        })
        .collect();
    page.table(
        &[
            "TS (s)",
            "one count (rad/s)",
            "one count",
            "of steady speed",
            "counts a sample",
            "scatter RMS",
            "delay",
            "RMS error by delay",
            "RMS error, all",
        ],
        &rows,
    );
    page.subsection("Error of the speed by sample time");
    page.table(
        &["TS (s)", "RMS error over the step (RPM)"],
        &part
            .errors_by_sample_time
            .iter()
            .map(|(ts, error)| vec![ts.to_string(), figure(rpm_from_rad_s(*error), 3)])
            .collect::<Vec<_>>(),
    );
    page.subsection("Difference over several samples at the shorter TS");
    page.table(
        &[
            "samples",
            "one count",
            "delay",
            "RMS error over the step (RPM)",
        ],
        &part
            .spans
            .iter()
            .map(|span| {
                vec![
                    span.samples.to_string(),
                    rpm(span.one_count_rad_s),
                    time(span.delay_s),
                    figure(rpm_from_rad_s(span.error_rad_s), 3),
                ]
            })
            .collect::<Vec<_>>(),
    );
    answers(page, lab, '2');
}

fn part_3(page: &mut Page, lab: &Lab) {
    page.section("Part 3: recorded against simulated response");
    for laid in &lab.part_3 {
        let notes = &laid.overlay.figures.notes;
        page.subsection(&format!("{}: TS = {} s", laid.name(), laid.sample_time_s));
        for note in notes {
            page.note(note);
        }
        page.figure(
            &figures::step(laid),
            Size::SMALL,
            "The step: recorded samples as dots, simulated ones with and without friction as steps; all by the same difference of counts.",
        );
        page.figure(
            &figures::recorded(laid),
            Size {
                width: 860,
                height: 760,
            },
            "The whole recording. Gap: recorded less simulated position.",
        );
        page.figure(
            &figures::residuals(laid),
            Size::SMALL,
            "Position gap of every model: a speed that is off shows as a slope.",
        );
        let of_models: Vec<_> = laid.models.iter().map(|model| &model.figures).collect();
        let (mut names, mut rows) = figures_table(&of_models);
        names[0] = "model";
        for (row, model) in rows.iter_mut().zip(&laid.models) {
            row[0] = model.name.to_owned();
        }
        page.table(&names, &rows);
    }
    if let Some(diagnosis) = lab.missing.diagnosis() {
        ranking::section(page, diagnosis);
    }
    answers(page, lab, '3');
}
