//! Change detection: the difference between these runs and reference runs of the same axis.
//!
//! The reference runs are diagnosed first. The least-squares fit of their identified set is the nominal motor of
//! these runs and its covariance their prior: to second order the joint fit of both with all parameters shared,
//! except those that an effect widens.
//!
//! An effect in these runs may have been present before, if the reference runs do not show it. Each is therefore
//! judged by the joint score of both groups, each scored as in its own search: as an effect of these runs alone (free
//! by group) and as an effect of the motor of both (shared). Unless the first is confidently more probable, the effect
//! belongs to the reference, and these runs are searched again.

use nalgebra::DMatrix;

use super::budget::stated_floor;
use super::document::weighed;
use super::error::{DiagnoseError, name_of, usable};
use super::fit::Fit;
use super::intervals::covariance;
use super::model::{Base, Member, Model, ReferencePosterior};
use super::nested::{self, least_squares};
use super::pipeline::{Prepared, Searched, searched};
use super::report::ReferenceRuns;
use super::search::scored;
use super::segments::Segments;
use super::settings::conventions::SEARCH_SHARE;
use super::verdict::identified;
use super::{Options, Settings};
use crate::motor::Motor;
use crate::motor::fit::ParameterId;
use crate::recording::Run;

/// The score of a model of a group of runs in its own search, from these starts.
fn score(group: &Searched, base: &Base, model: &Model, starts: &[Vec<f64>]) -> Option<f64> {
    let found = scored(&group.segments, base, group.found.judge, model, starts)?;
    Some(found.score)
}

/// The search of these runs after reference runs, its prepared data, and the report of the reference.
pub(super) fn compared<'a>(
    mut prepared: Prepared<'a>,
    stated_floor_counts: f64,
    earlier: &[Run],
    motor: &Motor,
    options: &Options<'_>,
) -> Result<(Prepared<'a>, Searched, Option<ReferenceRuns>), DiagnoseError> {
    usable(&[&prepared.runs[..1], &earlier[..1]].concat())?;
    let settings = &options.settings;
    let mut then = Prepared::new(earlier, motor, settings, options.quick)?;
    // A motor has one set of parameters in both groups.
    let torque_identifiable = prepared.base.torque_identifiable || then.base.torque_identifiable;
    prepared.base.torque_identifiable = torque_identifiable;
    then.base.torque_identifiable = torque_identifiable;
    (options.progress)("diagnosing the reference runs");
    let floor = stated_floor(earlier, &then.all, &[], options.good_enough);
    let reference = searched(&then, floor.largest(), &[], &|_| (), &|share| {
        (options.done)(0.5 * SEARCH_SHARE * share);
    })?;
    let mut fit = identified_fit(&then, &reference, settings).ok_or(DiagnoseError::NoFit)?;
    loop {
        let (motor, posterior) = posterior_of(&reference.segments, &then.base, &fit);
        prepared.base = prepared.base.after(motor, posterior);
        let found = searched(
            &prepared,
            stated_floor_counts,
            &[],
            options.progress,
            &|share| {
                (options.done)(0.5 * SEARCH_SHARE * (1.0 + share));
            },
        )?;
        let both = (&then, &reference, &prepared, &found);
        if let Some(with) = shared(both, &fit, settings) {
            (options.progress)("sharing an effect with the reference runs");
            fit = with;
            continue;
        }
        (found.segments.work).add_all(&reference.segments.work);
        let names = earlier.iter().enumerate();
        let report = ReferenceRuns {
            runs: names.map(|(k, run)| name_of(k, run)).collect(),
            effects: fit.ids(),
            rms_counts: fit.rms(),
        };
        return Ok((prepared, found, Some(report)));
    }
}

fn identified_fit(then: &Prepared, found: &Searched, settings: &Settings) -> Option<Fit> {
    let Searched {
        segments,
        none,
        found,
        ..
    } = found;
    let named = identified(&weighed(&found.sets, settings), settings);
    let ids: Vec<&'static str> = named.iter().map(|one| one.effect).collect();
    let steps = nested::without_effects(segments, &then.base, none)?;
    let steps = nested::with_effects(segments, &then.base, steps, &ids, found);
    steps.into_iter().next_back().map(|step| step.fit)
}

/// The fit of the reference with one more of the identified effects of these runs, unless the joint score assigns it
/// to these runs alone.
fn shared(
    (then, reference, now, found): (&Prepared, &Searched, &Prepared, &Searched),
    fit: &Fit,
    settings: &Settings,
) -> Option<Fit> {
    let named = identified(&weighed(&found.found.sets, settings), settings);
    let best = found.found.best();
    let of_reference = |fit: &Fit| {
        let known = reference.found.sets.iter().map(|set| &set.fit);
        let known = known.filter(|set| set.ids() == fit.ids());
        let starts = [fit].into_iter().chain(known);
        let starts: Vec<Vec<f64>> = starts
            .map(|from| fit.model.start_from(&from.model, &from.x))
            .collect();
        score(reference, &then.base, &fit.model, &starts)
    };
    let apart = of_reference(fit)? + best.score;
    // Each effect with its fitted values.
    let motor = best.fit.model.motor(&best.fit.x);
    let fitted = Member::of(&motor);
    let with_values = |own: &Member| fitted.iter().find(|one| one.index == own.index).cloned();
    let members: Vec<Member> = (best.fit.model.members.iter())
        .map(|own| with_values(own).unwrap_or_else(|| own.clone()))
        .collect();
    // The same prior odds of an effect, whichever model has it.
    let odds = |group: &Searched| group.found.judge.odds(1, settings);
    let is_new = |member: &&Member| {
        named.iter().any(|one| one.effect == member.id()) && !fit.ids().contains(&member.id())
    };
    let tried = members.iter().filter(is_new).filter_map(|member| {
        let with = fit.model.members.iter().chain([member]).cloned();
        let with = Model::new(&then.base, with.collect());
        let start_from = |from: &Fit| with.start_from(&from.model, &from.x);
        let starts = [with.start(), start_from(fit), start_from(&best.fit)];
        let with = least_squares(&reference.segments, &with, &starts)?;
        let (motor, posterior) = posterior_of(&reference.segments, &then.base, &with);
        let base = now.base.after(motor, posterior);
        let rest = members.iter().filter(|other| other.index != member.index);
        let rest = Model::new(&base, rest.cloned().collect());
        let starts = [rest.start(), rest.start_from(&best.fit.model, &best.fit.x)];
        let joint = of_reference(&with)? - odds(reference)
            + odds(found)
            + score(found, &base, &rest, &starts)?;
        Some((joint, with))
    });
    let best = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
    // Only a confident difference is a change.
    let odds = settings.confident / (1.0 - settings.confident);
    (settings.learning_rate * (apart - best.0) < odds.ln()).then_some(best.1)
}

/// The motor of the reference runs with its posterior.
fn posterior_of(segments: &Segments, base: &Base, fit: &Fit) -> (Motor, ReferencePosterior) {
    let motor = fit.model.motor(&fit.x);
    let parameters = &fit.model.parameters;
    let mut covariance: DMatrix<f64> = covariance(segments, base, fit);
    for (k, parameter) in parameters.iter().enumerate() {
        // A base parameter is relative to the motor's value, which is now the fitted one.
        if matches!(parameter.id, ParameterId::Nominal(_)) {
            covariance.row_mut(k).scale_mut(1.0 / fit.x[k]);
            covariance.column_mut(k).scale_mut(1.0 / fit.x[k]);
        }
    }
    let posterior = ReferencePosterior {
        effects: Member::of(&motor),
        parameters: (parameters.iter().zip(&fit.x))
            .filter(|(parameter, _)| matches!(parameter.id, ParameterId::Effect(..)))
            .map(|(parameter, x)| (*parameter, *x))
            .collect(),
        covariance,
        mean_square: fit.mean_square(),
    };
    (motor, posterior)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{motor_with, recording};
    use super::super::{Diagnosis, Verdict, diagnose};
    use super::*;

    fn against(runs: &[Run], reference: &[Run]) -> Diagnosis {
        let options = Options {
            reference,
            ..Options::default()
        };
        diagnose(runs, &Motor::default(), &options).expect("a diagnosis")
    }

    /// A motor whose friction differs from the file's in both groups: no change, though the file is wrong. With a
    /// dead zone in the later runs, that is the change.
    #[test]
    fn effects_of_the_reference_are_no_change() {
        let mut then = motor_with(&[("voltage_drop", &[0.6])]);
        then.parameters.coulomb_friction_nm *= 1.2;
        let reference = [recording(&then, 1500)];
        let same = against(&[recording(&then, 1200)], &reference);
        assert_eq!(same.verdict, Verdict::NoChange, "{}", same.sentence);
        let report = same.reference.expect("reference runs");
        assert_eq!(report.effects, ["voltage_drop"], "{report:?}");
        let mut now = then.clone();
        now.effects =
            motor_with(&[("voltage_drop", &[0.6]), ("backlash", &[0.05, 0.5, 0.0])]).effects;
        let other = against(&[recording(&now, 1200)], &reference);
        assert_eq!(other.effects, ["backlash"], "{}", other.sentence);
    }
}
