//! Reader of the third shape of a diagnosis, `motorlab-diagnosis/3`: document in, claim out.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::claim::{Cause, Claim, ClaimedGap, EffectSet, Estimate, Word};

/// Name and number of the shape.
pub(super) const DIAGNOSIS_SHAPE: &str = "motorlab-diagnosis/3";

/// The keys of the document that a claim needs.
#[derive(Deserialize)]
pub(super) struct DiagnosisDocument {
    verdict: Word,
    probability: f64,
    effects: Vec<String>,
    causes: Vec<Included>,
    sets: Vec<EffectSet>,
    #[serde(default)]
    classes: Vec<Class>,
    #[serde(default)]
    gap: ClaimedGap,
    elapsed_s: Option<f64>,
}

#[derive(Deserialize)]
struct Included {
    effect: String,
    #[serde(default)]
    class: Option<String>,
    #[serde(default)]
    parameters: BTreeMap<String, Estimate>,
}

#[derive(Deserialize)]
struct Class {
    class: String,
    #[serde(default)]
    members: Vec<String>,
}

impl DiagnosisDocument {
    /// The claim: causes with their shares of the sets that contain them, `none` for the empty set.
    ///
    /// `outside_catalogue` states an error that no effect of the catalogue explains: the empty set is then `unknown`.
    /// `ambiguous` states the probability that any effect is present; the claim is the most probable non-empty set
    /// with the probabilities of the sets.
    pub(super) fn claim(self) -> Claim {
        let without_effects = match self.verdict {
            Word::OutsideCatalogue => "unknown",
            _ => "none",
        };
        let causes = self.causes(without_effects);
        let is_ambiguous = self.verdict == Word::Ambiguous;
        let effects = match is_ambiguous && self.effects.is_empty() {
            true => self.most_probable(),
            false => self.effects,
        };
        let is_counted = |set: &EffectSet| without_effects == "none" || !set.effects.is_empty();
        Claim {
            verdict: self.verdict,
            of_verdict: (!is_ambiguous).then_some(self.probability),
            effects,
            causes,
            stands_for_class: true,
            sets: self.sets.into_iter().filter(is_counted).collect(),
            gap: self.gap,
            elapsed_s: self.elapsed_s,
        }
    }

    /// The most probable non-empty set.
    fn most_probable(&self) -> Vec<String> {
        let with_effects = self.sets.iter().filter(|set| !set.effects.is_empty());
        let best = with_effects.max_by(|a, b| a.probability.total_cmp(&b.probability));
        best.map_or(Vec::new(), |set| set.effects.clone())
    }

    /// A set of two counts half for each of its effects, so that the causes sum to 1.
    fn causes(&self, without_effects: &str) -> Vec<Cause> {
        let mut shares: BTreeMap<&str, f64> = BTreeMap::new();
        for set in &self.sets {
            if set.effects.is_empty() {
                *shares.entry(without_effects).or_default() += set.probability;
            }
            for effect in &set.effects {
                *shares.entry(effect).or_default() += set.probability / set.effects.len() as f64;
            }
        }
        let of_class = |effect: &str| {
            let holds = |class: &&Class| class.members.iter().any(|member| member == effect);
            let stated = self.classes.iter().find(holds);
            stated.map(|class| class.class.clone())
        };
        let mut causes: Vec<Cause> = (shares.into_iter())
            .map(|(effect, probability)| {
                let stated = self.causes.iter().find(|cause| cause.effect == effect);
                Cause {
                    effect: effect.to_owned(),
                    probability,
                    parameters: stated.map_or(BTreeMap::new(), |cause| cause.parameters.clone()),
                    indistinguishable_from: Vec::new(),
                    class: (stated.and_then(|cause| cause.class.clone()))
                        .or_else(|| of_class(effect)),
                }
            })
            .collect();
        causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        causes
    }
}
