//! The document of a diagnosis, assembled from the search, the nested fits and the budget.

use std::collections::BTreeMap;

use super::budget::{HeldOut, Shares, median, regions, travel};
use super::classes::{class_of, members_of};
use super::error::name_of;
use super::fit::Fit;
use super::identifiable::identifiable;
use super::intervals::{covariance, interval};
use super::model::{Base, Model};
use super::nested::{self, Step};
use super::pipeline::{Prepared, Searched};
use super::report::{
    Alternative, BudgetStep, Cause, Diagnosis, EffectClass, EffectSet, Fitted, FloorParts, Gap,
    Interval, Place, PredictedRun, SHAPE, Scoring, Unexplained, Verdict,
};
use super::score::{effective_observations, likelihood, posterior};
use super::search::Scored;
use super::segments::Segments;
use super::settings::Settings;
use super::verdict::{BudgetShares, Identified, Weighed, identified, inclusion, joint, verdict};
use super::{Options, design, relevance, sentence};
use crate::motor::catalogue::{EffectParameter, Stage, find};
use crate::motor::fit::ParameterId;
use crate::recording::Run;

/// What is measured.
const METRIC: &str = "multi-step prediction error of the position over segments, initial states corrected, in counts RMS";
/// Effects below this inclusion probability are not listed. Convention.
const LISTED_FROM: f64 = 0.01;

/// Assembles the document; `None` where a model cannot be simulated.
pub(super) fn document(
    prepared: &Prepared,
    searched: &Searched,
    stated: FloorParts,
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
    let none = (weighed.iter().filter(|set| set.ids.is_empty()))
        .fold(0.0, |sum, set| sum + set.probability);
    (options.progress)("fitting the nested models");
    let ids: Vec<&'static str> = named.iter().map(|one| one.effect).collect();
    let without = nested::without_effects(segments, base, &searched.none)?;
    let mut steps = nested::with_effects(segments, base, without.clone(), &ids, found);
    // A parameter at a bound of its range in the reported fit is not identified.
    while let Some(bounded) = at_bound(&steps[steps.len() - 1].fit).first().copied()
        && named.iter().any(|one| one.effect == bounded)
    {
        named.retain(|one| one.effect != bounded);
        let ids: Vec<&'static str> = named.iter().map(|one| one.effect).collect();
        steps = nested::with_effects(segments, base, without.clone(), &ids, found);
    }
    (options.progress)("measuring the held-out error");
    let judged_on = held.unwrap_or(if prepared.subset.is_some() {
        all
    } else {
        segments
    });
    let errors = errors(
        base,
        segments,
        &steps,
        judged_on,
        held.is_some() || prepared.subset.is_some(),
    )?;
    let parts = FloorParts {
        rounding: searched.quantization,
        ..stated
    };
    let floor = parts.largest();
    let shares = Shares::new(judged_on, &errors, floor, settings);
    let last = steps.len() - 1;
    let n_eff = effective_observations(judged_on, &errors[0].residual);
    let is_at_floor =
        |m: usize| !relevance::exceeds(errors[m].mean_square(), floor * floor, n_eff, settings);
    // The relevance test is of the fitted error; cross-validation adds what the parameters do not know.
    let (_, least_left, _) = shares.left(last);
    let is_settled_at_floor = least_left <= 0.0 || !found.judge.is_relevant;
    let budget_shares = BudgetShares {
        is_nominal_at_floor: is_at_floor(0),
        parameters: shares.removed(1).0,
        effects: shares.between(1, last).0,
        beyond_parameters: shares.left(1).0,
        unexplained: if is_settled_at_floor {
            0.0
        } else {
            shares.left(last).0
        },
    };
    let mut said = verdict(&budget_shares, &named, none, settings);
    let is_named = matches!(said, Verdict::Effect | Verdict::Partial);
    // What the reference runs leave unexplained is no change either.
    let is_as_before = |mean_square: f64| {
        !relevance::exceeds(errors[1].mean_square(), mean_square, n_eff, settings)
    };
    if let Some(then) = &base.reference {
        said = match said {
            Verdict::Parameters if none < settings.identified => Verdict::Ambiguous,
            Verdict::NoGap | Verdict::Parameters => Verdict::NoChange,
            Verdict::OutsideCatalogue
                if none >= settings.confident || is_as_before(then.mean_square) =>
            {
                Verdict::NoChange
            }
            other => other,
        };
    }
    let probability = match said {
        Verdict::Effect | Verdict::Partial => joint(&weighed, &named),
        Verdict::Ambiguous => 1.0 - none,
        _ => none,
    };
    let best = &steps[last].fit;
    let reported = match said {
        Verdict::NoGap | Verdict::NoChange => &steps[0].fit,
        Verdict::Effect | Verdict::Partial => best,
        _ => &steps[1].fit,
    };
    let noise = likelihood(segments, base, best).noise;
    let at = if is_named { last } else { 1 };
    let (left, lo95, hi95) = shares.left(at);
    let unexplained = Unexplained {
        rms_counts: (errors[at].mean_square() - floor * floor).max(0.0).sqrt(),
        share: left,
        lo95,
        hi95,
        equivalent_torque_share: noise.strength,
        regions: regions(
            judged_on,
            &|run| name_of(run, held_run(options, runs, run)),
            &errors[at].residual,
            floor,
        ),
    };
    let (closed, closed_lo95, closed_hi95) = shares.closed(match said {
        Verdict::NoGap | Verdict::NoChange => 0,
        Verdict::Effect | Verdict::Partial => last,
        _ => 1,
    });
    let of_named: Vec<&'static str> = (steps[2..].iter().map(|step| step.name)).collect();
    let effects = if is_named { of_named } else { Vec::new() };
    let model = reported.model.motor(&reported.x);
    let place = place(&weighed, &unexplained, said, &effects);
    let mut diagnosis = Diagnosis {
        shape: SHAPE,
        verdict: said,
        sentence: String::new(),
        parts: Default::default(),
        probability,
        classes: if is_named {
            classes(&weighed, &named)
        } else {
            Vec::new()
        },
        budget: budget(
            &steps[..=at],
            &shares,
            &weighed,
            &unexplained,
            errors[at].rms(),
        ),
        causes: causes(
            segments,
            base,
            &found.sets,
            &weighed,
            is_named.then_some(best),
            &effects,
        ),
        sets: sets(&found.sets, &weighed),
        identifiable: identifiable(segments, base, reported, options.nominal_source),
        place,
        gap: gap(
            judged_on,
            &steps,
            &errors,
            at,
            parts,
            (closed, closed_lo95, closed_hi95),
            match (held.is_some(), prepared.subset.is_some()) {
                (true, _) => "held-out runs",
                (_, true) => "all segments; a stratified subset of them was fitted",
                _ => "cross-validation over segments",
            },
        ),
        base: base_parameters(segments, base, reported),
        effects,
        unexplained,
        note: String::new(),
        data: Vec::new(),
        next_experiment: None,
        steps: found.steps.clone(),
        scoring: scoring(found.best(), found.judge.is_likelihood, found.judge.n_eff),
        elapsed_s: 0.0,
        simulated_samples: 0,
        reference: None,
        nominal_source: options.nominal_source,
        predicted: predicted(judged_on, &errors),
        command_kind: base.kind,
        nominal: base.motor.clone(),
        model,
        refitted: steps[1].fit.model.motor(&steps[1].fit.x),
    };
    let is_settled = match said {
        Verdict::NoGap | Verdict::NoChange => true,
        Verdict::Effect | Verdict::Parameters => {
            probability >= settings.confident && diagnosis.classes.is_empty()
        }
        _ => false,
    };
    if !is_settled {
        (options.progress)("choosing what to record next");
        diagnosis.next_experiment = design::next_experiment(prepared, searched, &weighed);
    }
    diagnosis.note = sentence::note(
        &diagnosis,
        &outside(reported, settings),
        options.is_doubtful,
        segments.runs.iter().any(|run| run.is_closed_loop),
    );
    diagnosis.parts = sentence::parts(&diagnosis, asked);
    diagnosis.sentence = joined(&diagnosis.parts);
    Some(diagnosis)
}

pub(super) fn joined(parts: &[String; 4]) -> String {
    let parts: Vec<&str> = parts
        .iter()
        .map(String::as_str)
        .filter(|p| !p.is_empty())
        .collect();
    parts.join(" ")
}

fn held_run<'a>(options: &Options<'a>, runs: &'a [Run], run: usize) -> &'a Run {
    options
        .held_out
        .get(run)
        .unwrap_or(&runs[run.min(runs.len() - 1)])
}

/// Sets with their posterior probabilities.
pub(super) fn weighed(sets: &[Scored], settings: &Settings) -> Vec<Weighed> {
    let scores: Vec<f64> = sets.iter().map(|set| set.score).collect();
    let probabilities = posterior(&scores, settings.learning_rate);
    (sets.iter().zip(probabilities))
        .map(|(set, probability)| Weighed {
            ids: set.fit.ids(),
            probability,
            at_bound: at_bound(&set.fit),
        })
        .collect()
}

/// Effects with a parameter at a bound of its range.
fn at_bound(fit: &Fit) -> Vec<&'static str> {
    let parameters = fit.model.parameters.iter().zip(&fit.x);
    parameters
        .filter_map(|(parameter, x)| {
            let ParameterId::Effect(index, _) = parameter.id else {
                return None;
            };
            let near = 1e-6 * (parameter.hi - parameter.lo).abs();
            let is_at = *x <= parameter.lo + near || *x >= parameter.hi - near;
            is_at.then(|| crate::motor::catalogue::kind(index).id)
        })
        .collect()
}

/// Held-out residuals of each step: on other segments, or by cross-validation.
fn errors(
    base: &Base,
    segments: &Segments,
    steps: &[Step],
    judged_on: &Segments,
    is_other: bool,
) -> Option<Vec<HeldOut>> {
    let of = |(k, step): (usize, &Step)| {
        let fit = &step.fit;
        if is_other {
            return HeldOut::on(judged_on, &fit.model.motor(&fit.x));
        }
        Some(match k {
            0 => HeldOut {
                residual: fit.corrected.clone(),
            },
            _ => HeldOut::cross_validated(segments, base, fit),
        })
    };
    steps.iter().enumerate().map(of).collect()
}

fn budget(
    steps: &[Step],
    shares: &Shares,
    weighed: &[Weighed],
    unexplained: &Unexplained,
    rms_left: f64,
) -> Vec<BudgetStep> {
    let mut budget: Vec<BudgetStep> = (steps.iter().enumerate())
        .map(|(m, step)| {
            let (share, lo95, hi95) = shares.removed(m);
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
        rms_counts: rms_left,
        share: unexplained.share,
        lo95: unexplained.lo95,
        hi95: unexplained.hi95,
        alternatives: Vec::new(),
    });
    budget
}

/// Members of an effect's class that have a probability.
fn alternatives(id: &str, weighed: &[Weighed]) -> Vec<Alternative> {
    let members = class_of(id).map_or(&[][..], members_of);
    let mut found: Vec<Alternative> = (members.iter().filter(|member| **member != id))
        .map(|member| Alternative {
            effect: member,
            probability: inclusion(weighed, &[member]),
        })
        .filter(|one| one.probability >= LISTED_FROM)
        .collect();
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    found
}

fn classes(weighed: &[Weighed], named: &[Identified]) -> Vec<EffectClass> {
    let of = |one: &Identified| {
        let class = one.class?;
        let mut members: Vec<&'static str> = members_of(class)
            .iter()
            .copied()
            .filter(|id| inclusion(weighed, &[id]) >= LISTED_FROM)
            .collect();
        members.sort_by(|a, b| inclusion(weighed, &[b]).total_cmp(&inclusion(weighed, &[a])));
        Some(EffectClass {
            class,
            probability: one.probability,
            members,
        })
    };
    named.iter().filter_map(of).collect()
}

/// All effects with a probability, their parameters from the reported fit where it has them, else from the most probable set.
fn causes(
    segments: &Segments,
    base: &Base,
    sets: &[Scored],
    weighed: &[Weighed],
    reported: Option<&Fit>,
    named: &[&'static str],
) -> Vec<Cause> {
    let mut ids: Vec<&'static str> = weighed.iter().flat_map(|set| set.ids.clone()).collect();
    ids.sort_unstable();
    ids.dedup();
    let mut found: Vec<Cause> = (ids.into_iter())
        .filter_map(|id| {
            let own = inclusion(weighed, &[id]);
            if own < LISTED_FROM && !named.contains(&id) {
                return None;
            }
            let class = class_of(id);
            let of_class = class.map_or(own, |class| inclusion(weighed, members_of(class)));
            let is_separated = own >= base.settings.confident * of_class;
            let from = reported.filter(|_| named.contains(&id));
            let from = from.or_else(|| {
                let set = sets.iter().find(|set| set.fit.ids().contains(&id));
                set.map(|set| &set.fit)
            })?;
            Some(Cause {
                effect: id,
                stage: find(id).map_or("", |(_, kind)| kind.stage.id()),
                inclusion: own,
                class: class.filter(|_| !is_separated),
                class_probability: (!is_separated).then_some(of_class),
                at_bound: at_bound(from).contains(&id),
                parameters: parameters(segments, base, from, id),
            })
        })
        .collect();
    // What is at a bound is no cause.
    found.sort_by(|a, b| (a.at_bound.cmp(&b.at_bound)).then(b.inclusion.total_cmp(&a.inclusion)));
    found
}

/// Parameters of one effect of a fit; of an effect that widens a base parameter, that parameter in SI.
fn parameters(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
    id: &'static str,
) -> BTreeMap<&'static str, Interval> {
    let covariance = covariance(segments, base, fit);
    let Some((index, kind)) = find(id) else {
        return BTreeMap::new();
    };
    let reference = |parameter: ParameterId, own: &EffectParameter| {
        let then = base.reference.as_ref()?;
        let known = then
            .parameters
            .iter()
            .find(|(known, _)| known.id == parameter);
        // What the reference does not have changes nothing there.
        let neutral = || own.neutral(&base.motor.parameters).map(|(value, _)| value);
        known.map(|(known, x)| known.value(*x)).or_else(neutral)
    };
    let mut found = BTreeMap::new();
    for (k, parameter) in fit.model.parameters.iter().enumerate() {
        match parameter.id {
            ParameterId::Effect(of, which) if of == index => {
                let mut one = interval(segments, fit, &covariance, k);
                one.reference = reference(parameter.id, &kind.parameters[which]);
                found.insert(kind.parameters[which].key, one);
            }
            ParameterId::Nominal(_)
                if base
                    .frees(id)
                    .is_some_and(|number| super::model::BASE[number] == parameter.id.key()) =>
            {
                let mut one = interval(segments, fit, &covariance, k);
                one.unit = kind.parameters[0].unit;
                one.reference = base.reference.as_ref().map(|_| parameter.unit);
                found.insert(kind.parameters[0].key, one);
            }
            _ => {}
        }
    }
    // Discrete values have no interval.
    let motor = fit.model.motor(&fit.x);
    for (parameter, value) in motor
        .effects
        .get(id)
        .iter()
        .flat_map(|effect| effect.parameters())
    {
        found.entry(parameter.key).or_insert(Interval {
            value,
            lo95: value,
            hi95: value,
            unit: parameter.unit,
            reference: None,
        });
    }
    found
}

fn sets(sets: &[Scored], weighed: &[Weighed]) -> Vec<EffectSet> {
    (sets.iter().zip(weighed))
        .map(|(set, weighed)| EffectSet {
            effects: weighed.ids.clone(),
            probability: weighed.probability,
            score: set.score,
            rms_counts: set.fit.rms(),
        })
        .collect()
}

fn place(
    weighed: &[Weighed],
    unexplained: &Unexplained,
    said: Verdict,
    effects: &[&'static str],
) -> Place {
    let stage_of = |id: &str| find(id).map(|(_, kind)| kind.stage);
    let probability = |stage: Stage| -> f64 {
        let with = |set: &&Weighed| set.ids.iter().any(|id| stage_of(id) == Some(stage));
        f64::min(
            (weighed.iter().filter(with)).fold(0.0, |sum, set| sum + set.probability),
            1.0,
        )
    };
    let mut stages: Vec<&'static str> = (effects.iter())
        .filter_map(|id| stage_of(id).map(Stage::id))
        .collect();
    stages.dedup();
    Place {
        stage: (!stages.is_empty()).then(|| stages.join("+")),
        stage_probabilities: Stage::ALL
            .into_iter()
            .map(|stage| (stage.id(), probability(stage)))
            .collect(),
        regions: match said {
            Verdict::NoGap | Verdict::NoChange => Vec::new(),
            _ => unexplained.regions.clone(),
        },
    }
}

fn gap(
    judged_on: &Segments,
    steps: &[Step],
    errors: &[HeldOut],
    at: usize,
    parts: FloorParts,
    (closed, closed_lo95, closed_hi95): (f64, f64, f64),
    held_out: &str,
) -> Gap {
    let horizon = |segment: &super::segments::Segment| {
        let t_s = &judged_on.runs[segment.run].t_s;
        t_s[segment.to - 1] - t_s[segment.from]
    };
    Gap {
        metric: METRIC,
        horizon_s: median(judged_on.segments.iter().map(horizon).collect()),
        floor: parts.largest(),
        floor_parts: parts,
        travel: travel(judged_on),
        before: errors[0].rms(),
        after_parameters: errors[1].rms(),
        after_effect: errors[at].rms(),
        closed,
        closed_lo95,
        closed_hi95,
        fitted: Fitted {
            before: steps[0].fit.rms(),
            after_parameters: steps[1].fit.rms(),
            after_effect: steps[at].fit.rms(),
        },
        held_out: held_out.to_owned(),
    }
}

fn scoring(best: &Scored, is_likelihood: bool, n_eff: f64) -> Scoring {
    Scoring {
        score: if is_likelihood {
            "likelihood"
        } else {
            "scale_free"
        },
        effective_observations: n_eff,
        random_load_share: best.likelihood.noise.strength,
        whitened_squares: best.likelihood.squares,
    }
}

/// Base parameters as shares of the motor file's, with intervals.
fn base_parameters(
    segments: &Segments,
    base: &Base,
    fit: &Fit,
) -> BTreeMap<&'static str, Interval> {
    let covariance = covariance(segments, base, fit);
    let parameters = fit.model.parameters.iter().enumerate();
    parameters
        .filter(|(_, parameter)| matches!(parameter.id, ParameterId::Nominal(_)))
        .map(|(k, parameter)| {
            let mut one = interval(segments, fit, &covariance, k);
            for end in [&mut one.value, &mut one.lo95, &mut one.hi95] {
                *end /= parameter.unit;
            }
            (parameter.id.key(), one)
        })
        .collect()
}

/// Base parameters outside their tolerances that no effect widens, as shares of the motor file's.
fn outside(fit: &Fit, settings: &Settings) -> Vec<(&'static str, f64)> {
    let model: &Model = &fit.model;
    let freed: Vec<usize> = model
        .members
        .iter()
        .filter_map(|m| model.frees(m))
        .collect();
    let is_freed = |key: &str| freed.iter().any(|k| super::model::BASE[*k] == key);
    let off = model.off(&fit.x);
    (model.parameters.iter().zip(off).enumerate())
        .filter(|(_, (parameter, off))| {
            matches!(parameter.id, ParameterId::Nominal(_))
                && *off > settings.within_tolerances
                && !is_freed(parameter.id.key())
        })
        .map(|(k, (parameter, _))| (parameter.id.key(), fit.x[k]))
        .collect()
}

fn predicted(judged_on: &Segments, errors: &[HeldOut]) -> Vec<PredictedRun> {
    let shown = [0, 1, errors.len() - 1].map(|m| &errors[m].residual);
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
