//! Findings about a recording: plain data, serialized as `motorlab-check/1`.

use std::collections::BTreeMap;

use serde::Serialize;

/// Kind of finding. The ids are those of the document.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The counts fall while the command is positive.
    EncoderReversed,
    /// Counts are multiples of 2 or 4, or the travel differs from the motor file's by such a factor.
    CountsScale,
    /// The position is in another unit than stated.
    PositionUnit,
    /// The time is in another unit than stated.
    TimeUnit,
    /// The motor moves later than the command column.
    CommandEarly,
    /// The motor moves before the command column.
    CommandLate,
    /// The command never changes.
    CommandConstant,
    /// The command lies beyond the supply.
    CommandBeyondSupply,
    /// The counter wrapped and was not unwrapped.
    CounterWrap,
    /// The counter may have wrapped unnoticed in a pause.
    WrapOverGap,
    /// The position jumps and returns: a failed read.
    MisreadPosition,
    /// The counter is reset to 0 during the run.
    CounterReset,
    /// Rows after a pause hold the position from before it.
    StaleRows,
    /// The shaft rests under a command that turned it before.
    OffUnderCommand,
    /// The logged speed is 0 in rows between two edges of the encoder.
    SpeedZeroBetweenEdges,
    /// The logged speed keeps its last value while the command is 0.
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
    /// Position or command does not change where it must.
    ChannelStuck,
    /// The measured supply varies.
    SupplyVaries,
    /// The shaft turns before anything is commanded.
    StartsInMotion,
    /// Too few samples, or too little motion.
    TooShort,
}

/// Severity of a finding; the most severe is listed first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// No diagnosis is valid before it is corrected.
    Fatal,
    /// An error that may lead to wrong conclusions.
    Warning,
    /// Information.
    Note,
}

impl Severity {
    /// Name of the severity.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fatal => "fatal",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// One finding in one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Kind of finding.
    pub id: Kind,
    /// Severity.
    pub severity: Severity,
    /// Path of the run, or its number from 1.
    pub run: String,
    /// Begin in s of the run's time.
    pub from_s: f64,
    /// End in s of the run's time.
    pub to_s: f64,
    /// Message.
    pub message: String,
    /// Figures of evidence; the names carry the units.
    pub evidence: BTreeMap<&'static str, f64>,
    /// Remedy: a flag, a key of the mapping, a wire.
    pub remedy: String,
}

impl Finding {
    /// Message and remedy as one sentence.
    pub fn sentence(&self) -> String {
        format!("{}; {}", self.message, self.remedy)
    }

    /// The id in the document.
    pub fn id(&self) -> String {
        match serde_json::to_value(self.id) {
            Ok(serde_json::Value::String(id)) => id,
            _ => String::new(),
        }
    }
}

/// The first fatal finding of this run; none if it is usable.
pub fn fatal_of<'a>(findings: &'a [Finding], run: &str) -> Option<&'a Finding> {
    let mut of_run = findings.iter().filter(|finding| finding.run == run);
    of_run.find(|finding| finding.severity == Severity::Fatal)
}

/// Whether one of them is fatal.
pub fn is_fatal(findings: &[Finding]) -> bool {
    (findings.iter()).any(|finding| finding.severity == Severity::Fatal)
}
