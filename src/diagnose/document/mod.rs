//! The document of a diagnosis, assembled from the search, the nested fits and the budget.

mod causes;
mod confirmed;

pub(crate) use causes::weighed;

use std::ops::Range;

use super::budget::{Shares, located, median, travel};
use super::command_units::CommandUnits;
use super::error::name_of;
use super::identifiable::identifiable;
use super::model::mean_square;
use super::nested::{self, Step};
use super::pipeline::{Prepared, Searched};
use super::report::{
    BudgetStep, CROSS_VALIDATION, Diagnosis, Fitted, FloorParts, Gap, HELD_OUT_RUNS, Place,
    PredictedRun, Quick, ReferenceRuns, SHAPE, Scoring, Unexplained, Verdict,
};
use super::score::likelihood;
use super::search::Found;
use super::segments::{Segment, Segments};
use super::settings::Settings;
use super::settings::conventions::{HELD_OUT_FROM, NEXT_FROM, SEARCH_SHARE};
use super::verdict::{Evidence, Weighed, identified, inclusion, probability, verdict};
use super::{Options, design, relevance, sentence};
use crate::motor::catalogue::{Stage, catalogue, find};
use crate::recording::Run;
use causes::{alternatives, base_parameters, causes, classes, outside, sets, settled};
use confirmed::{Confirmed, Data, Floors, confirmed};

/// Measured quantity.
const METRIC: &str = "multi-step prediction error of the position over segments, initial states corrected, in counts RMS";

/// Assembles the document; `None` where a model cannot be simulated.
pub(super) fn document(
    prepared: &Prepared,
    searched: &Searched,
    (stated, reference): (FloorParts, Option<ReferenceRuns>),
    held: Option<&Segments>,
    options: &Options<'_>,
    asked: &str,
) -> Option<Diagnosis> {
    let Prepared { base, runs, .. } = prepared;
    let Searched {
        segments,
        all,
        found,
        ..
    } = searched;
    let settings = &base.settings;
    let weighed = weighed(&found.sets, settings);
    let mut named = identified(&weighed, settings);
    let empty = weighed.iter().find(|set| set.ids.is_empty());
    let none = empty.map_or(0.0, |set| set.probability);
    (options.progress)("fitting the nested models");
    (options.done)(SEARCH_SHARE);
    let without = nested::without_effects(segments, base, &searched.none)?;
    (options.progress)("measuring the held-out error");
    (options.done)(HELD_OUT_FROM);
    let judged_on = held.or(prepared.subset.as_ref().map(|_| all));
    let without_random = FloorParts {
        rounding: searched.quantization,
        ..stated
    };
    let data = Data {
        segments,
        judged_on,
        base,
        found,
        floor: without_random,
        has_held_out_runs: held.is_some(),
    };
    let Confirmed {
        steps,
        errors,
        floors:
            Floors {
                parts,
                counts: floors,
                shares,
            },
        n_eff,
        bounded,
        rejected,
    } = confirmed(&data, &without, &mut named, none)?;
    let judged_on = judged_on.unwrap_or(segments);
    let last = steps.len() - 1;
    let is_within = |m: usize, floor_square: f64| {
        !relevance::exceeds(mean_square(&errors[m]), floor_square, n_eff, settings)
    };
    // The relevance test is of the fitted error, to which cross-validation adds only the uncertainty of the parameters.
    let is_settled_at_floor =
        shares.left(last).1 <= 0.0 || (!found.judge.is_relevant && held.is_none());
    let evidence = Evidence {
        is_nominal_at_floor: is_within(0, floors[0] * floors[0]),
        parameters: shares.between(0, 1).0,
        beyond_parameters: shares.left(1).0,
        unexplained: if is_settled_at_floor {
            0.0
        } else {
            shares.left(last).0
        },
        identified: &named,
        none,
        is_as_reference: (base.reference.as_ref()).map(|then| is_within(1, then.mean_square)),
    };
    let verdict = verdict(&evidence, settings);
    let is_named = matches!(verdict, Verdict::Effect | Verdict::Partial);
    let probability = probability(verdict, &weighed, &named, none);
    let best = &steps[last].fit;
    // The step whose motor is reported.
    let shown = match verdict {
        Verdict::NoGap | Verdict::NoChange => 0,
        Verdict::Effect | Verdict::Partial => last,
        _ => 1,
    };
    let reported = &steps[shown].fit;
    let noise = likelihood(segments, base, best).noise;
    let at = if is_named { last } else { 1 };
    let floor = floors[at];
    let (left, lo95, hi95) = shares.left(at);
    let (regimes, regions) = located(
        judged_on,
        &|run| {
            let own = || &runs[run.min(runs.len() - 1)];
            name_of(run, options.held_out.get(run).unwrap_or_else(own))
        },
        &errors[at],
        floor,
    );
    let unexplained = Unexplained {
        rms_counts: (mean_square(&errors[at]) - floor * floor).max(0.0).sqrt(),
        share: left,
        lo95,
        hi95,
        equivalent_torque_share: noise.strength,
        regimes,
        regions,
    };
    let of_named: Vec<&'static str> = (steps[2..].iter().map(|step| step.name)).collect();
    let effects = if is_named { of_named } else { Vec::new() };
    let model = reported.model.motor(&reported.x);
    let place = place(&weighed, &unexplained, verdict, &effects);
    let mut diagnosis = Diagnosis {
        shape: SHAPE,
        verdict,
        sentence: String::new(),
        parts: Default::default(),
        probability,
        classes: if is_named {
            classes(&weighed, &named)
        } else {
            Vec::new()
        },
        budget: budget(&steps[..=at], &shares, &weighed, &unexplained),
        causes: causes(
            segments,
            base,
            &found.sets,
            &weighed,
            is_named.then_some(best),
            (&effects, &bounded, &rejected),
            CommandUnits::new(base, options.nominal_source),
        ),
        sets: sets(&found.sets, &weighed),
        identifiable: identifiable(segments, base, reported, options.nominal_source),
        place,
        gap: gap(
            judged_on,
            &steps,
            &errors,
            at,
            parts[at],
            shares.between(0, shown),
            match (held.is_some(), prepared.subset.is_some()) {
                (true, _) => HELD_OUT_RUNS.to_owned(),
                (_, true) => format!(
                    "all samples; {:.0} % of them were fitted",
                    100.0 * segments.len as f64 / all.len as f64
                ),
                _ => CROSS_VALIDATION.to_owned(),
            },
        ),
        base: base_parameters(segments, base, reported),
        effects,
        unexplained,
        quick: options.quick.then(|| Quick::new(segments.len, all.len)),
        note: String::new(),
        data: Vec::new(),
        next_experiment: None,
        steps: found.steps.clone(),
        scoring: scoring(found, segments, settings),
        settings: *settings,
        elapsed_s: 0.0,
        simulated_samples: 0,
        reference,
        nominal_source: options.nominal_source,
        predicted: predicted(judged_on, &errors),
        command_kind: base.kind,
        nominal: base.motor.clone(),
        model,
        refitted: steps[1].fit.model.motor(&steps[1].fit.x),
    };
    if sentence::no_recording_reason(&diagnosis).is_none() {
        (options.progress)("choosing what to record next");
        (options.done)(NEXT_FROM);
        let settled = settled(&diagnosis.causes, settings);
        diagnosis.next_experiment = design::next_experiment(prepared, searched, &weighed, &settled);
    }
    diagnosis.note = sentence::note(
        &diagnosis,
        &outside(reported, settings),
        &left_out(prepared, held, options),
        options.is_doubtful,
    );
    diagnosis.parts = sentence::parts(&diagnosis, asked);
    let parts = diagnosis.parts.iter().filter(|part| !part.is_empty());
    diagnosis.sentence = parts.cloned().collect::<Vec<_>>().join(" ");
    Some(diagnosis)
}

/// Intervals of the diagnosed and the held-out runs in which the drive was off under its command.
fn left_out(
    prepared: &Prepared,
    held: Option<&Segments>,
    options: &Options<'_>,
) -> Vec<sentence::LeftOut> {
    let of = |runs: &[Run], segments: &Segments| -> Vec<sentence::LeftOut> {
        let pairs = segments.runs.iter().zip(runs).enumerate();
        pairs
            .flat_map(|(k, (recording, run))| {
                let name = name_of(k, run);
                let at = |sample: usize| recording.t_s[sample];
                let interval = |off: &Range<usize>| (name.clone(), at(off.start), at(off.end - 1));
                recording.off.iter().map(interval).collect::<Vec<_>>()
            })
            .collect()
    };
    let mut intervals = of(prepared.runs, &prepared.all);
    intervals.extend(held.map_or_else(Vec::new, |held| of(options.held_out, held)));
    intervals
}

fn budget(
    steps: &[Step],
    shares: &Shares,
    weighed: &[Weighed],
    unexplained: &Unexplained,
) -> Vec<BudgetStep> {
    let mut budget: Vec<BudgetStep> = (steps.iter().enumerate())
        .map(|(m, step)| {
            let (share, lo95, hi95) = match m {
                0 => shares.left(0),
                _ => shares.between(m - 1, m),
            };
            BudgetStep {
                step: step.name,
                rms_counts: shares.rms[m],
                share,
                lo95,
                hi95,
                alternatives: alternatives(step.name, weighed),
            }
        })
        .collect();
    budget.push(BudgetStep {
        step: "unexplained",
        rms_counts: shares.rms[steps.len() - 1],
        share: unexplained.share,
        lo95: unexplained.lo95,
        hi95: unexplained.hi95,
        alternatives: Vec::new(),
    });
    budget
}

fn place(
    weighed: &[Weighed],
    unexplained: &Unexplained,
    verdict: Verdict,
    effects: &[&'static str],
) -> Place {
    let probability = |stage: Stage| -> f64 {
        let of_stage = catalogue().iter().filter(|kind| kind.stage == stage);
        inclusion(weighed, &of_stage.map(|kind| kind.id).collect::<Vec<_>>())
    };
    let mut stages: Vec<&'static str> = (effects.iter())
        .filter_map(|id| find(id).map(|(_, kind)| kind.stage.id()))
        .collect();
    stages.dedup();
    Place {
        stage: (!stages.is_empty()).then(|| stages.join("+")),
        stage_probabilities: Stage::ALL
            .into_iter()
            .map(|stage| (stage.id(), probability(stage)))
            .collect(),
        regions: match verdict {
            Verdict::NoGap | Verdict::NoChange => Vec::new(),
            _ => unexplained.regions.clone(),
        },
    }
}

fn gap(
    judged_on: &Segments,
    steps: &[Step],
    errors: &[Vec<f64>],
    at: usize,
    parts: FloorParts,
    (closed, closed_lo95, closed_hi95): (f64, f64, f64),
    held_out: String,
) -> Gap {
    let horizon = |segment: &Segment| {
        let t_s = &judged_on.runs[segment.run].t_s;
        t_s[segment.to - 1] - t_s[segment.from]
    };
    let rms = |m: usize| mean_square(&errors[m]).sqrt();
    Gap {
        metric: METRIC,
        horizon_s: median(judged_on.segments.iter().map(horizon).collect()),
        floor: parts.largest(),
        floor_parts: parts,
        travel: travel(judged_on),
        before: rms(0),
        after_parameters: rms(1),
        after_effect: rms(at),
        closed,
        closed_lo95,
        closed_hi95,
        fitted: Fitted {
            before: steps[0].fit.rms(),
            after_parameters: steps[1].fit.rms(),
            // An effect that parameters imitate leaves as much, but for the convergence of the fits.
            after_effect: steps[at].fit.rms().min(steps[1].fit.rms()),
        },
        held_out,
    }
}

fn scoring(found: &Found, segments: &Segments, settings: &Settings) -> Scoring {
    let likelihood = &found.best().likelihood;
    Scoring {
        score: match found.judge.is_likelihood {
            true => "likelihood",
            false => "scale_free",
        },
        effective_observations: found.judge.n_eff,
        random_load_share: likelihood.noise.strength,
        whitened_squares: likelihood.squares,
        learning_rate: settings.learning_rate,
        closed_loop: segments.runs.iter().any(|run| run.is_closed_loop),
    }
}

fn predicted(judged_on: &Segments, errors: &[Vec<f64>]) -> Vec<PredictedRun> {
    let shown = [0, 1, errors.len() - 1].map(|m| &errors[m]);
    (judged_on.runs.iter().enumerate())
        .map(|(number, run)| {
            let own = || judged_on.segments.iter().filter(move |s| s.run == number);
            let mut gap_counts = [(); 3].map(|()| vec![f64::NAN; run.t_s.len()]);
            for segment in own() {
                for (gaps, residual) in gap_counts.iter_mut().zip(shown) {
                    gaps[segment.from..segment.to].copy_from_slice(&residual[segment.range()]);
                }
            }
            PredictedRun {
                run: number,
                gap_counts,
                starts: own().map(|segment| segment.from).collect(),
            }
        })
        .collect()
}
