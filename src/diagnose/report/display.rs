//! A diagnosis as text: search, sets, budget, sentence.

use std::fmt;

use super::Diagnosis;

use crate::diagnose::settings::conventions::LISTED_FROM;

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for step in &self.steps {
            write!(f, "{step}")?;
        }
        let scoring = &self.scoring;
        writeln!(
            f,
            "score: {}, {:.0} effective observations, random load {:.4} of stall",
            scoring.score, scoring.effective_observations, scoring.random_load_share
        )?;
        for set in self
            .sets
            .iter()
            .filter(|set| set.probability >= LISTED_FROM)
        {
            let name = match set.effects.is_empty() {
                true => "none".to_owned(),
                false => set.effects.join("+"),
            };
            writeln!(
                f,
                "  P = {:.3}, score {:10.1}, {:8.3} counts RMS  {name}",
                set.probability, set.score, set.rms_counts
            )?;
        }
        for step in &self.budget {
            writeln!(
                f,
                "  {:24} {:8.3} counts RMS, share {:6.3} (95 % {:.3} to {:.3})",
                step.step, step.rms_counts, step.share, step.lo95, step.hi95
            )?;
        }
        writeln!(f, "{}", self.sentence)
    }
}
