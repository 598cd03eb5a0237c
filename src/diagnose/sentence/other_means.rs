//! Measurements that separate causes which voltage and angle do not.
//!
//! Errors of the supply, of the resolution and of a motor constant have the same response. A voltmeter, or one turn
//! by hand, separates them.

use super::{capitalized, is_undescribed, listed, name, three};
use crate::diagnose::classes::members_of;
use crate::diagnose::report::{Cause, Diagnosis, Interval, NominalSource, Verdict};
use crate::motor::catalogue::ids;

/// Measurements for effects that others imitate exactly, or nearly so within tolerances.
const MEANS: [(&str, &str); 14] = [
    (
        ids::SUPPLY_ERROR,
        "measure the driver's supply voltage under load: gain = measured / assumed voltage",
    ),
    (
        ids::VOLTAGE_DROP,
        "measure the voltage at the motor's terminals while it turns: drop_v = commanded minus measured voltage",
    ),
    (
        ids::SUPPLY_SAG,
        "measure the supply's voltage and current with the motor at rest and turning at full duty: source_resistance_ohm = decrease of the voltage / increase of the current",
    ),
    (
        ids::RESOLUTION_ERROR,
        "turn the shaft ten turns by hand: counts_per_rev = a tenth of the counts",
    ),
    (
        ids::MISSED_COUNTS,
        "turn to a mark and back: probability = missing counts / counts travelled",
    ),
    (
        ids::CLOCK_ERROR,
        "time a long run with a stopwatch, or record the host's time: relative = (real time - board's time) / board's time",
    ),
    (
        ids::INERTIA,
        "weigh and measure what turns (inertia_kg_m2), or record with a known disc added",
    ),
    (
        ids::COULOMB_FRICTION,
        "measure the torque that just starts it, with a string and a weight: torque_nm = weight force times radius",
    ),
    (
        ids::VISCOUS_FRICTION,
        "let it coast with the motor's leads open: coefficient_nm_s_per_rad = inertia / time constant of the speed",
    ),
    (ids::CURRENT_LIMIT, "measure the current at stall (limit_a)"),
    (
        ids::WINDING_HEATING,
        "measure the resistance cold and hot: resistance_rise_per_w = relative rise / heating power",
    ),
    (
        ids::GRAVITY_LOAD,
        "weigh the load: torque_nm = weight force times its arm; or turn the motor's axis upright and record again",
    ),
    (
        ids::ENCODER_ECCENTRICITY,
        "compare the count with a mark over one slow turn: amplitude_rad = largest difference",
    ),
    (
        ids::ASYMMETRIC_FRICTION,
        "measure the starting torque both ways: ratio = (forward - reverse) / (forward + reverse)",
    ),
];

/// Steps other than a recording: for probable effects with a parameter at its bound, and for an ambiguous verdict without
/// a useful profile; `None` if there is none.
pub(super) fn other_means(diagnosis: &Diagnosis) -> Option<String> {
    let is_settled = matches!(diagnosis.verdict, Verdict::NoGap | Verdict::NoChange);
    if is_settled || is_undescribed(diagnosis) {
        return None;
    }
    let bounded = bounded(diagnosis);
    if !bounded.is_empty() {
        return Some(at_limit(diagnosis, &bounded));
    }
    if diagnosis.verdict != Verdict::Ambiguous || diagnosis.next_experiment.is_some() {
        return None;
    }
    match diagnosis.causes.iter().any(|cause| cause.immaterial) {
        true => Some(NOTHING_TO_SEPARATE.to_owned()),
        false => not_separated(diagnosis.causes.first()?),
    }
}

/// Probable effects with a parameter at its bound.
fn bounded(diagnosis: &Diagnosis) -> Vec<&Cause> {
    let is_bounded =
        |cause: &&Cause| cause.at_bound && cause.inclusion >= diagnosis.settings.identified;
    diagnosis.causes.iter().filter(is_bounded).collect()
}

/// Whether there is such an effect.
pub(crate) fn is_at_limit(diagnosis: &Diagnosis) -> bool {
    !bounded(diagnosis).is_empty()
}

const NOTHING_TO_SEPARATE: &str = "No recording is proposed: the probable effects remove less than a tenth of the held-out error that remains without them, so there is nothing to gain from separating them.";

/// Effects with a parameter at its bound: the fitted value is no estimate, and no recording changes that.
fn at_limit(diagnosis: &Diagnosis, bounded: &[&Cause]) -> String {
    let names: Vec<String> = bounded.iter().map(|cause| name(cause.effect)).collect();
    let limits: Vec<Limit<'_>> = (bounded.iter())
        .flat_map(|cause| {
            cause
                .parameters
                .iter()
                .map(move |(key, value)| (cause, key, value))
        })
        .filter(|(.., value)| value.at_bound)
        .map(|(cause, key, value)| Limit::of(cause.effect, key, value))
        .collect();
    let at_bound: Vec<String> = limits.iter().map(Limit::words).collect();
    let measured: Vec<String> = match bounded {
        [only] => measurement(only.effect)
            .map(str::to_owned)
            .into_iter()
            .collect(),
        _ => measurements(bounded.iter().map(|cause| cause.effect)),
    };
    let is = match bounded {
        [_] => "is",
        _ => "are",
    };
    let names = listed(&names, "and");
    let measured = match measured.is_empty() {
        true => "Check the supply and the parameters of the motor file, from which the ranges follow. If a known value is beyond the range,".to_owned(),
        false => {
            let measured = capitalized(&measured.join("; "));
            match (limits.as_slice(), bounded) {
                ([only], [_]) if measured.contains(&format!("{} =", only.key)) => format!(
                    "{measured}. If you measure clearly {} than {}, {names} {is} not the only cause; if about that or {},",
                    only.inside(),
                    only.value,
                    only.beyond()
                ),
                _ => format!(
                    "{measured}. If the value is within the range, {names} {is} not the cause; if it is beyond,"
                ),
            }
        }
    };
    let template = match diagnosis.nominal_source {
        NominalSource::Given => "",
        _ => " (`motorlab motor --template -o motor.toml`)",
    };
    let sections: Vec<String> = (bounded.iter())
        .map(|cause| format!("[effects.{}]", cause.effect))
        .collect();
    let no_estimate = match at_bound.as_slice() {
        [] => format!("A parameter of {names} is at its bound, so it is no estimate."),
        [only] => format!("The fit of {only}, so it is no estimate."),
        all => format!(
            "The fit of {}, so these are no estimates.",
            listed(all, "and")
        ),
    };
    format!(
        "{no_estimate} {measured} write it into the motor file{template} under {} and diagnose again with --motor.",
        listed(&sections, "and")
    )
}

/// The bound of a parameter at which its fit ended.
struct Limit<'a> {
    effect: &'static str,
    key: &'a str,
    /// With its unit.
    value: String,
    is_upper: bool,
}

impl<'a> Limit<'a> {
    fn of(effect: &'static str, key: &'a str, fitted: &Interval) -> Self {
        let (key, fitted) = fitted.determined(key);
        let value = format!("{} {}", three(fitted.value), fitted.unit);
        Self {
            effect,
            key,
            value: value.trim_end().to_owned(),
            is_upper: fitted.hi95 - fitted.value <= fitted.value - fitted.lo95,
        }
    }

    fn words(&self) -> String {
        let Self { key, value, .. } = self;
        let bound = if self.is_upper { "upper" } else { "lower" };
        format!(
            "{key} ({}) ends at its {bound} bound of {value}",
            name(self.effect)
        )
    }

    fn inside(&self) -> &'static str {
        if self.is_upper { "less" } else { "more" }
    }

    fn beyond(&self) -> &'static str {
        if self.is_upper { "more" } else { "less" }
    }
}

/// Measurements that separate the members of a class, or an effect from parameters.
fn not_separated(likeliest: &Cause) -> Option<String> {
    let class = likeliest.class.map_or(&[][..], members_of);
    let others = class.iter().filter(|id| **id != likeliest.effect);
    let in_play: Vec<&'static str> = std::iter::once(&likeliest.effect)
        .chain(others)
        .copied()
        .collect();
    let measured = measurements(in_play.iter().copied());
    let names: Vec<String> = in_play.iter().map(|id| name(id)).collect();
    (!measured.is_empty()).then(|| {
        format!(
            "No profile within this supply separates {} well. By other means: {}.",
            listed(&names, "and"),
            measured.join("; ")
        )
    })
}

/// Known measurements for some effects, each with its effect.
fn measurements(ids: impl Iterator<Item = &'static str>) -> Vec<String> {
    ids.filter_map(|id| Some(format!("{} ({})", measurement(id)?, name(id))))
        .collect()
}

fn measurement(id: &str) -> Option<&'static str> {
    let known = MEANS.iter().find(|(known, _)| *known == id);
    known.map(|(_, measurement)| *measurement)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::catalogue::catalogue;

    #[test]
    fn every_name_is_one_of_the_catalogue() {
        for (id, _) in MEANS {
            assert!(catalogue().iter().any(|kind| kind.id == id), "{id}");
        }
    }
}
