//! Where the nominal motor comes from.

use serde::Serialize;

/// Where the parameters of the nominal motor come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NominalSource {
    /// A motor file, or a motor that the caller has.
    #[default]
    Given,
    /// The lab handout's motor: no motor file is given.
    Handout,
    /// A fit to the runs ([`nominal_fit`](crate::diagnose::nominal_fit)).
    Fit,
}
