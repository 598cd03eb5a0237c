//! Parameters of a document in the units that its runs determine.

use serde::Deserialize;

use super::document::{Document, Interval};
use crate::diagnose::without_assumed_unit;

/// Parameters that the runs determine whatever the resistance is.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Identifiable {
    pub(super) speed_per_volt: Interval,
    pub(super) time_constant_s: Interval,
    pub(super) friction_v: Interval,
    pub(super) electrical_time_constant_s: Option<Interval>,
    pub(super) si: Option<serde_json::Value>,
}

impl Document {
    /// The document with the identifiable parameters: without a known torque, values are in units of the command, and
    /// motor parameters are speed per volt, time constant and friction, not ratios to a model fitted to the same
    /// runs.
    pub(super) fn determined(mut self) -> Self {
        for cause in &mut self.causes {
            let parameters = std::mem::take(&mut cause.parameters).into_iter();
            let determined = parameters.map(|(key, number)| match number.in_command {
                Some(own) => (without_assumed_unit(&key).to_owned(), *own),
                None => (key, number),
            });
            cause.parameters = determined.collect();
        }
        let is_fitted = self.nominal_source.as_deref() == Some("fit");
        if let Some(known) = self.identifiable.take()
            && is_fitted
            && known.si.is_none()
        {
            let electrical = known.electrical_time_constant_s;
            let electrical = electrical.filter(|one| one.lo95 < one.hi95);
            let rows = [
                ("speed_per_volt", Some(known.speed_per_volt)),
                ("time_constant_s", Some(known.time_constant_s)),
                ("friction_v", Some(known.friction_v)),
                ("electrical_time_constant_s", electrical),
            ];
            let found = rows.into_iter();
            let found = found.filter_map(|(name, number)| Some((name.to_owned(), number?)));
            self.base = found.collect();
        }
        self
    }

    /// Whether a parameter is a ratio to the motor file's value.
    pub fn is_relative(&self, name: &str) -> bool {
        self.base
            .get(name)
            .is_some_and(|number| number.unit.is_empty())
    }
}
