//! Units in which sketches print speeds.

/// Unit of a speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeedUnit {
    /// Turns a minute.
    Rpm,
    /// Not named: taken as turns a minute, which is said.
    Unsaid,
    /// rad/s.
    RadPerS,
    /// Degrees a second.
    DegPerS,
    /// Turns a second.
    RevPerS,
    /// Encoder counts a second.
    CountsPerS,
}

impl SpeedUnit {
    /// Turns a second in one of it, or counts a second.
    pub fn in_turns(self) -> Option<f64> {
        match self {
            Self::Rpm | Self::Unsaid => Some(1.0 / 60.0),
            Self::RadPerS => Some(1.0 / std::f64::consts::TAU),
            Self::DegPerS => Some(1.0 / 360.0),
            Self::RevPerS => Some(1.0),
            Self::CountsPerS => None,
        }
    }
}
