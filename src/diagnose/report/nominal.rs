//! Source of the nominal motor.

use serde::Serialize;

/// Source of the nominal motor's parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NominalSource {
    /// A motor file, or a motor of the caller.
    #[default]
    Given,
    /// The lab handout's motor, without a motor file.
    Handout,
    /// A fit to the runs ([`nominal_fit`](crate::diagnose::nominal_fit)).
    Fit,
}
