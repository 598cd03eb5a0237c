//! Findings in a recording: plain data, serialised as `motorlab-check/1` lists it.

use std::collections::BTreeMap;

use serde::Serialize;

/// Kind of finding. The ids are those of the document.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The counts fall while the command is positive.
    EncoderReversed,
    /// Counts are multiples of 2 or 4, or the gain is off by that from the motor file.
    CountsScale,
    /// The position is in another unit than said.
    PositionUnit,
    /// The time is in another unit than said.
    TimeUnit,
    /// The motor moves later than the command column says.
    CommandEarly,
    /// The motor moves before the command column does.
    CommandLate,
    /// The command never changes.
    CommandConstant,
    /// The command lies beyond the supply.
    CommandBeyondSupply,
    /// The counter wrapped and was not unwrapped.
    CounterWrap,
    /// The counter may have wrapped unnoticed in a gap.
    WrapOverGap,
    /// The position leaps away and comes back: a failed read.
    MisreadPosition,
    /// The counter is set to 0 in mid-run.
    CounterReset,
    /// Rows after a pause hold the position from before it.
    StaleRows,
    /// The shaft stands still under a command that turned it before.
    OffUnderCommand,
    /// The logged speed is 0 in rows between two edges of the encoder.
    SpeedZeroBetweenEdges,
    /// The logged speed is kept from the last edge while nothing is commanded.
    SpeedKept,
    /// The logged speed or position is the mean of the last rows.
    MovingAverage,
    /// Fewer counts pass in one direction than in the other.
    LossInOneDirection,
    /// Samples are far apart.
    GapInTime,
    /// Counts fall behind at high speed.
    EdgesLostAtSpeed,
    /// One count of dither while the motor is off.
    DitherAtRest,
    /// The times contradict the stated sample time.
    SampleTimeContradicts,
    /// The board's clock runs at another rate than the host's.
    ClockRate,
    /// Position or command stands still where it cannot.
    ChannelStuck,
    /// The measured supply varies.
    SupplyVaries,
    /// The shaft turns before anything is commanded.
    StartsInMotion,
    /// Too few samples, or too little motion.
    TooShort,
}

/// How much a finding weighs. The order is that of a listing: the most severe comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// No diagnosis is valid before it is corrected.
    Fatal,
    /// An error that may lead to wrong conclusions.
    Warning,
    /// Worth knowing.
    Note,
}

impl Severity {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fatal => "fatal",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// One thing found in one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Kind of finding.
    pub id: Kind,
    /// How much it weighs.
    pub severity: Severity,
    /// Path of the run, or its number from 1.
    pub run: String,
    /// Where it begins, in s of the run's time.
    pub from_s: f64,
    /// Where it ends, in s of the run's time.
    pub to_s: f64,
    /// Message.
    pub message: String,
    /// The figures that say so; the names carry the units.
    pub evidence: BTreeMap<&'static str, f64>,
    /// Remedy: a flag, a key of the mapping, a wire.
    pub remedy: String,
}

impl Finding {
    /// Message and remedy as one sentence.
    pub fn sentence(&self) -> String {
        format!("{}; {}", self.message, self.remedy)
    }

    /// The id as the document has it.
    pub fn id(&self) -> String {
        match serde_json::to_value(self.id) {
            Ok(serde_json::Value::String(id)) => id,
            _ => String::new(),
        }
    }
}

/// Fatal findings of this run with their remedies; none if it is usable.
pub fn fatal_of<'a>(findings: &'a [Finding], run: &str) -> Option<&'a Finding> {
    let mut of_run = findings.iter().filter(|finding| finding.run == run);
    of_run.find(|finding| finding.severity == Severity::Fatal)
}

/// Whether one of them is fatal.
pub fn is_fatal(findings: &[Finding]) -> bool {
    (findings.iter()).any(|finding| finding.severity == Severity::Fatal)
}
