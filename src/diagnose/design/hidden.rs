//! Effects that the runs so far would not show, however much they are there.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::planned::Planned;
use super::supposed::{Supposed, typical, with_first};
use crate::diagnose::fit::{Base, Fit, Member};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{HIDDEN_PLACES, TIE};
use crate::motor::catalogue::catalogue;

/// Effects of small and large magnitudes beside a fit.
#[derive(Debug)]
pub(super) struct Hidden<'a> {
    base: &'a Base,
    fit: &'a Fit,
    /// An effect stands here twice, or once where its other magnitude is seen.
    effects: Vec<(&'static str, Supposed)>,
}

impl<'a> Hidden<'a> {
    /// The effects that look like none on the runs that were recorded.
    pub fn from(pieces: &Pieces, base: &'a Base, fit: &'a Fit) -> Self {
        let numbers = (&fit.model, fit.x.as_slice());
        let kinds = catalogue().iter().enumerate();
        let has = |id| {
            base.motor.effects.get(id).is_some() || fit.model.members.iter().any(|m| m.id() == id)
        };
        let effects = (kinds.filter(|(_, kind)| !has(kind.id)))
            .flat_map(|(index, kind)| {
                let typical = typical(kind, base);
                HIDDEN_PLACES.map(|share| {
                    let values = with_first(kind, &typical, base, share);
                    let member = Member { index, values };
                    (kind.id, Supposed::beside(base, numbers, Some(member)))
                })
            })
            .collect();
        let all = Self { base, fit, effects };
        let recorded = all.separations(&Planned::recorded(pieces, base, fit), &fit.model.precision);
        let pairs = all.effects.into_iter().zip(recorded);
        Self {
            base,
            fit,
            effects: (pairs.filter(|(_, separation)| *separation < TIE))
                .map(|(effect, _)| effect)
                .collect(),
        }
    }

    /// Those that a planned run shows, and by how many standard deviations; the fit's numbers are as free as the runs so far leave
    /// them.
    pub fn shown(&self, planned: &Planned) -> Vec<(&'static str, f64)> {
        let separations = self.separations(planned, &self.fit.hessian);
        let ids = self.effects.iter().map(|(id, _)| *id);
        ids.zip(separations).filter(|(_, d)| *d >= TIE).collect()
    }

    /// Of each from the fit, whose numbers are known to a precision.
    fn separations(&self, run: &Planned, known: &DMatrix<f64>) -> Vec<f64> {
        let Some(without) = run.rival(self.base, (&self.fit.model, &self.fit.x), known) else {
            return vec![0.0; self.effects.len()];
        };
        let of = |(_, effect): &(&str, Supposed)| match run.truth(effect.numbers()) {
            Some(truth) => run.separation(&truth, &without),
            None => 0.0,
        };
        self.effects.par_iter().map(of).collect()
    }
}
