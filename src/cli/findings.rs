//! Findings about recordings in words, as several subcommands say them.

use crate::check::Finding;
use crate::report::number::figure;

/// One finding: what it is and what to do, and beneath it how much it weighs, where, and by which figures.
pub(super) fn words(finding: &Finding) -> String {
    let figures: Vec<String> = (finding.evidence.iter())
        .map(|(name, value)| format!("{name} = {}", figure(*value, 4)))
        .collect();
    format!(
        "{}\n  {} ({}), {}, {:.3} to {:.3} s: {}",
        finding.sentence(),
        finding.severity.word(),
        finding.id(),
        finding.run,
        finding.from_s,
        finding.to_s,
        figures.join(", ")
    )
}
