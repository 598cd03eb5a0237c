//! How far apart a truth and a rival are on a planned run once the rival is refitted to the truth: a straight line through where
//! it stands says too much where its numbers bend the prediction, and too little where they have bounds.

use nalgebra::{DMatrix, DVector};

use super::planned::{Planned, View, unseen_twin, unseen_variance};
use crate::diagnose::fit::{Base, Model, dot, response};
use crate::diagnose::settings::{MOST_UNSEEN, REFIT_SHARES, REFIT_STEPS};

/// A rival with numbers that it gives way to.
struct Refit<'a> {
    planned: &'a Planned,
    base: &'a Base,
    truth: &'a View,
    model: &'a Model,
    begun: DVector<f64>,
    known: &'a DMatrix<f64>,
}

/// Numbers of a model, and by how much its motor is its own twin.
#[derive(Debug, Clone)]
struct Numbers {
    x: Vec<f64>,
    more: f64,
}

impl Planned {
    /// The separation of a truth from a rival that is refitted, its numbers known to a precision: steps of Gauss and Newton, each as
    /// long as it lowers what is left.
    pub fn separation_refitted(
        &self,
        base: &Base,
        truth: &View,
        (model, x): (&Model, &[f64]),
        known: &DMatrix<f64>,
    ) -> Option<f64> {
        let begun = DVector::from_column_slice(x);
        let refit = Refit {
            planned: self,
            base,
            truth,
            model,
            begun,
            known,
        };
        let mut at = Numbers {
            x: x.to_vec(),
            more: 0.0,
        };
        let mut left = refit.square(&at)?;
        for _ in 0..REFIT_STEPS {
            let step = refit.step(&at)?;
            let shorter = REFIT_SHARES.into_iter().find_map(|share| {
                let next = refit.moved(&at, &step, share);
                let square = refit.square(&next)?;
                (square < left).then_some((next, square))
            });
            let Some((next, square)) = shorter else {
                break;
            };
            (at, left) = (next, square);
        }
        let scatter = self.scatter_of(truth, (model, &at.x));
        Some((left + scatter).sqrt())
    }
}

impl Refit<'_> {
    /// What is left of the difference, whitened, with what is known of the numbers.
    fn square(&self, at: &Numbers) -> Option<f64> {
        let motor = self.model.motor(&at.x);
        let starts = self.planned.starts();
        let predicted = match at.more {
            0.0 => response(&self.planned.pieces, &motor, &starts),
            more => response(&self.planned.pieces, &unseen_twin(&motor, more), &starts),
        }?;
        let predicted = self.planned.whitener.whiten(&predicted);
        let pairs = self.truth.prediction.iter().zip(&predicted);
        let difference: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
        let moved = DVector::from_column_slice(&at.x) - &self.begun;
        let told = (self.known * &moved).dot(&moved);
        Some(difference + told + at.more * at.more / unseen_variance(self.base))
    }

    fn step(&self, at: &Numbers) -> Option<DVector<f64>> {
        let numbers = (self.model, at.x.as_slice());
        let view = (self.planned).rival_with(self.base, numbers, at.more, self.known)?;
        let pairs = self.truth.prediction.iter().zip(&view.prediction);
        let difference: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
        let pull = self.known * (DVector::from_column_slice(&at.x) - &self.begun);
        let mut right = DVector::from_fn(view.columns.len(), |k, _| {
            dot(&view.columns[k], &difference) - pull.get(k).unwrap_or(&0.0)
        });
        if self.planned.is_absolute {
            right[at.x.len()] -= at.more / unseen_variance(self.base);
        }
        Some(view.solver?.solve(&right))
    }

    fn moved(&self, at: &Numbers, step: &DVector<f64>, share: f64) -> Numbers {
        let steps = at.x.iter().zip(step.iter());
        let mut x: Vec<f64> = steps.map(|(x, step)| x + share * step).collect();
        self.model.clamp(&mut x);
        let more = step.get(x.len()).map_or(0.0, |step| at.more + share * step);
        Numbers {
            x,
            more: more.clamp(-MOST_UNSEEN, MOST_UNSEEN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::planned::tests::{base, planned};
    use super::*;
    use crate::diagnose::fit::Member;

    /// The truth is the same model with another number of the rival's range: a refit leaves no more than what the prior has against
    /// it, a straight line leaves more.
    #[test]
    fn a_refit_goes_where_a_straight_line_does_not() {
        let base = base();
        let planned = planned(&base, None);
        let delay = |delay_s: f64| {
            let index = crate::motor::catalogue::find("transport_delay")
                .expect("an effect")
                .0;
            let values = vec![delay_s];
            let model = Model::new(&base, vec![Member { index, values }]);
            let numbers = model.start();
            (model, numbers)
        };
        let (truth, rival) = (delay(0.03), delay(0.012));
        let free = rival.0.precision.clone();
        let seen = planned.truth((&truth.0, &truth.1)).expect("a motor");
        let view = planned
            .rival(&base, (&rival.0, &rival.1), &free)
            .expect("a motor");
        let straight = planned.separation(&seen, &view);
        let refitted = planned
            .separation_refitted(&base, &seen, (&rival.0, &rival.1), &free)
            .expect("a motor");
        assert!(
            straight > 3.0 * refitted && refitted < 3.0,
            "{straight} {refitted}"
        );
    }
}
