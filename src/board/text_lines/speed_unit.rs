//! Units in which sketches print speeds.

/// Unit of a speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeedUnit {
    /// Revolutions per minute.
    Rpm,
    /// Not stated: assumed to be revolutions per minute, with a message.
    Unsaid,
    /// rad/s.
    RadPerS,
    /// Degrees a second.
    DegPerS,
    /// Revolutions per second.
    RevPerS,
    /// Encoder counts per second.
    CountsPerS,
}

impl SpeedUnit {
    /// Revolutions per second of one unit; `None` for counts per second.
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
