//! The verdict as one sentence that a student understands.

use std::collections::BTreeMap;

use super::rivals::catalogue;
use super::ties::TIE;
use super::verdict::{Cause, Diagnosis, Regime, Region, Verdict};

/// A cause from this probability on is named where several are in play.
const IN_PLAY: f64 = 0.02;
/// Most causes that are named then.
const NAMED: usize = 4;

/// An effect beside something unknown is named from this probability on.
const BESIDE: f64 = 0.9;

/// A regime is named where it has at least this share of the gap.
const LEAST_SHARE: f64 = 0.25;

/// The sentence.
pub(super) fn sentence(diagnosis: &Diagnosis) -> String {
    let gap = &diagnosis.gap;
    let sure = sure(diagnosis.probability);
    let floor = format!("the encoder's own floor is {:.2}", gap.floor);
    let region = largest_regime(&diagnosis.place.regions)
        .filter(|(_, share)| *share >= LEAST_SHARE)
        .map(|(regime, share)| format!(", {:.0} % of it {}", 100.0 * share, regime.words()))
        .unwrap_or_default();
    match diagnosis.verdict {
        Verdict::NoGap => format!(
            "There is no gap to explain: the nominal model leaves {:.2} counts, {floor}.",
            gap.before
        ),
        Verdict::Parameters if gap.after_parameters >= gap.before => format!(
            "The model is right as it is ({sure}): it leaves {:.2} counts, and refitting its numbers does not make that less ({:.2} on data kept from the fit); {floor}.{}",
            gap.before,
            gap.after_parameters,
            hidden_behind_the_numbers(diagnosis)
        ),
        Verdict::Parameters => format!(
            "The model is right and its numbers are a little off ({sure}): refitting them brings the gap from {:.2} to {:.2} counts; {floor}.{}",
            gap.before,
            gap.after_parameters,
            hidden_behind_the_numbers(diagnosis)
        ),
        Verdict::Effect => format!(
            "The gap is {} ({sure}){region}: adding it closes {:.0} % of the gap, from {:.2} counts to {:.2}; refitting alone leaves {:.2}, {floor}.",
            in_words(&diagnosis.effects),
            // Rounded down: what is left must not be hidden.
            (100.0 * gap.closed.max(0.0)).floor(),
            gap.before,
            gap.after_effect,
            gap.after_parameters
        ),
        Verdict::Ambiguous if !perhaps_none(diagnosis).is_empty() => {
            let doubtful = perhaps_none(diagnosis);
            let others: Vec<_> = (diagnosis.effects.iter().copied())
                .filter(|id| !doubtful.iter().any(|cause| cause.effect == *id))
                .collect();
            let names: Vec<_> = doubtful.iter().map(|cause| cause.effect).collect();
            let is_hidden = |cause: &&Cause| cause.separation.is_some_and(|d| d < TIE);
            let but = if doubtful.iter().any(is_hidden) {
                "these runs cannot tell whether it is there"
            } else {
                "another law of the same effect could leave as little"
            };
            format!(
                "The gap is {}{region}. With {} beside it the gap goes from {:.2} counts to {:.2}, but {but}; {floor}.",
                in_words(&others),
                names.join(" and ").replace('_', " "),
                gap.before,
                gap.after_effect
            )
        }
        Verdict::Ambiguous => {
            let in_play = diagnosis.causes.iter().filter(|c| c.probability > IN_PLAY);
            let rivals: Vec<&str> = in_play
                .take(NAMED)
                .map(|cause| match cause.effect {
                    "none" => "no effect",
                    "unknown" => "something unknown",
                    id => id,
                })
                .collect();
            format!(
                "These runs cannot tell which of {} it is{region}; the likeliest brings the gap from {:.2} to {:.2} counts.",
                rivals.join(", ").replace('_', " "),
                gap.before,
                gap.after_effect
            )
        }
        Verdict::OutsideCatalogue => {
            let unknown = diagnosis.causes.iter().find(|c| c.effect == "unknown");
            let nearest = diagnosis.sets.first().map(|set| set.effects.join(" + "));
            let nearest = nearest
                .filter(|ids| !ids.is_empty())
                .map(|ids| {
                    let ids = ids.replace('_', " ");
                    format!(
                        " and {:.2} with the nearest of the catalogue ({ids})",
                        gap.after_effect
                    )
                })
                .unwrap_or_default();
            format!(
                "Something is there that no effect of the catalogue explains ({}){region}: the gap is {:.2} counts, {:.2} after refitting alone{nearest}.{}{}{}",
                self::sure(unknown.map_or(0.0, |cause| cause.probability)),
                gap.before,
                gap.after_parameters,
                swings(diagnosis),
                beside_it(diagnosis),
                part_of_it(diagnosis)
            )
        }
    }
}

/// Chosen effects beside others that these runs cannot tell from none and from nothing else, where these others are in no tie.
fn perhaps_none(diagnosis: &Diagnosis) -> Vec<&Cause> {
    let chosen = |cause: &&Cause| diagnosis.effects.contains(&cause.effect);
    let (doubtful, others): (Vec<&Cause>, Vec<&Cause>) = (diagnosis.causes.iter())
        .filter(chosen)
        .partition(|cause| cause.indistinguishable_from == ["none"]);
    if others.is_empty() || others.iter().any(|c| !c.indistinguishable_from.is_empty()) {
        return Vec::new();
    }
    doubtful
}

/// At which frequency something unknown swings if it does, as a sentence: of something unknown the shape that suits it best
/// need not be its law.
fn swings(diagnosis: &Diagnosis) -> String {
    match diagnosis.place.oscillation_hz {
        Some(hz) => format!(" Of all shapes a swing at {hz:.2} Hz suits it best."),
        None => String::new(),
    }
}

/// Which effects are there beside something unknown, as a sentence.
fn beside_it(diagnosis: &Diagnosis) -> String {
    let mut there: Vec<_> = (diagnosis.causes.iter())
        .filter(|cause| cause.stage.is_some() && cause.inclusion >= BESIDE)
        .collect();
    there.sort_by(|a, b| b.inclusion.total_cmp(&a.inclusion));
    if there.is_empty() {
        return String::new();
    }
    let named: Vec<String> = there
        .iter()
        .map(|cause| {
            let name = cause.effect.replace('_', " ");
            format!("{name} ({})", sure(cause.inclusion))
        })
        .collect();
    format!(" Beside it there is {}.", named.join(" and "))
}

/// Which effects may be part of what is unknown, as a sentence.
fn part_of_it(diagnosis: &Diagnosis) -> String {
    let mut causes = diagnosis.causes.iter();
    let unknown = causes.find(|cause| cause.effect == "unknown");
    let tied = unknown.map_or(&[][..], |unknown| &unknown.indistinguishable_from);
    if tied.is_empty() {
        return String::new();
    }
    format!(
        " It may be {} in part: these runs cannot tell.",
        tied.join(" and ").replace('_', " ")
    )
}

/// What these runs cannot tell from other numbers of the model, as a sentence.
fn hidden_behind_the_numbers(diagnosis: &Diagnosis) -> String {
    let none = diagnosis.causes.iter().find(|cause| cause.effect == "none");
    let tied = none.map_or(&[][..], |none| &none.indistinguishable_from);
    if tied.is_empty() {
        return String::new();
    }
    let names: Vec<String> = tied.iter().map(|id| id.replace('_', " ")).collect();
    format!(
        " A small effect of these would look the same in these runs: {}.",
        names.join(", ")
    )
}

/// Effects by name, each with what it is.
fn in_words(ids: &[&str]) -> String {
    let words: Vec<String> = ids
        .iter()
        .map(|id| {
            let name = id.replace('_', " ");
            match catalogue().iter().find(|kind| kind.id == *id) {
                Some(kind) => format!("{name}, {}", kind.summary),
                None => name,
            }
        })
        .collect();
    words.join("; and ")
}

/// A probability as a student reads it; nothing is certain.
fn sure(probability: f64) -> String {
    if probability > 0.99 {
        "more than 99 % sure".to_owned()
    } else {
        format!("{:.0} % sure", 100.0 * probability)
    }
}

/// The regime with the largest share of the gap.
fn largest_regime(regions: &[Region]) -> Option<(Regime, f64)> {
    let mut shares: BTreeMap<Regime, f64> = BTreeMap::new();
    for region in regions {
        *shares.entry(region.regime).or_default() += region.share;
    }
    shares.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))
}
