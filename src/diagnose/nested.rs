//! The nested models of the error budget: nominal, re-identified parameters, with one identified effect after the
//! other.
//!
//! In: segments, the identified effects, fits of the search as starts. Out: one least-squares fit per step, each with
//! an error no larger than the one before. They are the only source of reported figures, intervals and motor files.

use super::fit::{Fit, Metric, fit};
use super::model::{Base, Member, Model};
use super::search::Found;
use super::segments::Segments;
use super::settings::solver::{CONVERGED, STARTS_PER_SET, WITHIN_OPTIMUM};
use crate::motor::catalogue::{catalogue, ids};
use crate::motor::fit::ParameterId;

#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// `nominal`, `parameters` or the id of an effect.
    pub name: &'static str,
    pub fit: Fit,
}

/// Plain least squares: every sample is an observation, so that the prior matters only where the data do not
/// determine a parameter.
pub(crate) fn least_squares(
    segments: &Segments,
    model: &Model,
    starts: &[Vec<f64>],
) -> Option<Fit> {
    let metric = Metric::LeastSquares;
    let found = fit(segments, model, starts, metric, CONVERGED, None)?;
    // Once more with initial damping: in a valley the first fit ends early.
    fit(segments, model, &[found.x], metric, CONVERGED, None)
}

/// The nominal model and the one with re-identified parameters.
pub(crate) fn without_effects(segments: &Segments, base: &Base, none: &Fit) -> Option<Vec<Step>> {
    let model = Model::new(base, Vec::new());
    let nominal = Fit::at(segments, &model, model.start())?;
    let refitted = least_squares(segments, &model, &[none.x.clone(), model.start()])?;
    let refitted = smaller(&nominal, refitted);
    Some(vec![
        Step {
            name: "nominal",
            fit: nominal,
        },
        Step {
            name: "parameters",
            fit: refitted,
        },
    ])
}

/// The same with these effects, in the order of the error that they remove; an effect that removes none ends the
/// list.
pub(crate) fn with_effects(
    segments: &Segments,
    base: &Base,
    mut steps: Vec<Step>,
    ids: &[&'static str],
    found: &Found,
) -> Vec<Step> {
    let mut left: Vec<Member> = ids.iter().filter_map(|id| member_of(found, id)).collect();
    let mut members: Vec<Member> = Vec::new();
    while !left.is_empty() {
        let before = steps.last().map(|step| step.fit.clone());
        let Some(before) = before else { break };
        let fits = left.iter().enumerate().filter_map(|(k, member)| {
            let mut with = members.clone();
            with.push(member.clone());
            Some((k, extended(segments, base, with, &before, found)?))
        });
        let best = fits.min_by(|a, b| a.1.square_sum().total_cmp(&b.1.square_sum()));
        // Except for the convergence of the fits, a larger model has no larger error than the one that it extends.
        let n = before.corrected.len() as f64;
        let most = before.square_sum() * (2.0 * WITHIN_OPTIMUM / n).exp();
        let Some((k, fit)) = best.filter(|(_, fit)| fit.square_sum() <= most) else {
            break;
        };
        members.push(left.remove(k));
        let name = members.last().map_or("", Member::id);
        steps.push(Step { name, fit });
    }
    steps
}

fn smaller(before: &Fit, fit: Fit) -> Fit {
    if fit.square_sum() <= before.square_sum() {
        fit
    } else {
        before.clone()
    }
}

/// A model fitted from the step before, and from every fit of the search with its effects.
fn extended(
    segments: &Segments,
    base: &Base,
    members: Vec<Member>,
    before: &Fit,
    found: &Found,
) -> Option<Fit> {
    let model = Model::new(base, members);
    let ids = model.ids();
    let mut starts = vec![model.start_from(&before.model, &before.x)];
    starts
        .extend(neutral(base, &model).map(|without| without.start_from(&before.model, &before.x)));
    // Lost edges: the same counts for a motor that is faster by their share.
    let motor = model.motor(&starts[0]);
    let lost = ParameterId::effect(ids::MISSED_COUNTS, "probability").and_then(|id| id.get(&motor));
    starts.extend(lost.map(|lost| model.faster(&starts[0], 1.0 - lost)));
    let has_all = |set: &&super::search::Scored| {
        let own = set.fit.ids();
        ids.iter().all(|id| own.contains(id))
    };
    // The same error with another prior: a base parameter that an effect widens, lost edges compensated by a faster
    // motor.
    let same = starts
        .iter()
        .filter_map(|x| Fit::at(segments, &model, x.clone()));
    let same: Vec<Fit> = same.collect();
    let others = found.sets.iter().filter(has_all).take(STARTS_PER_SET);
    starts.extend(others.map(|set| model.start_from(&set.fit.model, &set.fit.x)));
    let fitted = least_squares(segments, &model, &starts);
    let smaller = |a: &Fit, b: &Fit| a.square_sum().total_cmp(&b.square_sum());
    same.into_iter().chain(fitted).min_by(smaller)
}

/// The model with its last effect where it changes nothing: a start from which the error is that of the step before.
fn neutral(base: &Base, model: &Model) -> Option<Model> {
    let mut members = model.members.clone();
    let last = members.last_mut()?;
    let parameter = catalogue()[last.index].parameters.first()?;
    *last.values.first_mut()? = parameter.neutral(&base.motor.parameters)?.0;
    Some(Model::new(base, members))
}

/// An effect with the values of the best set that contains it, discrete values included.
fn member_of(found: &Found, id: &str) -> Option<Member> {
    found.sets.iter().find_map(|set| {
        let members = &set.fit.model.members;
        let place = members.iter().position(|member| member.id() == id)?;
        let mut member = members[place].clone();
        // Fitted values replace the start.
        let motor = set.fit.model.motor(&set.fit.x);
        if let Some(effect) = motor.effects.get(id) {
            member.values = effect.values[..member.values.len()].to_vec();
        }
        Some(member)
    })
}
