//! The discrete state of the hybrid system, which selects the smooth equations of motion.

use crate::scalar::Scalar;

/// Mode of the current.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    /// It follows the voltage.
    Free,
    /// The voltage drop keeps it at 0.
    Blocked,
    /// It is at the driver's limit, or at the commanded value.
    Held,
    /// The circuit is open.
    Open,
}

/// Contact between the sides: flanks, with a spring in series if there is one, or a clutch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Contact {
    /// Rigid, or a spring without play.
    NoFlanks,
    /// No contact.
    Apart,
    /// The motor side pushes the load forward.
    Upper,
    /// The motor side pushes the load back.
    Lower,
    /// A gripping clutch.
    Gripped,
    /// A clutch slips, motor side ahead.
    SlipsAhead,
    /// A clutch slips, motor side behind.
    SlipsBack,
}

impl Contact {
    /// +1, -1, or 0 without contact.
    #[inline(always)]
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Upper => 1.0,
            Self::Lower => -1.0,
            _ => 0.0,
        }
    }

    /// Whether the sides are in contact: at a flank, or in a gripping clutch.
    #[inline(always)]
    pub(crate) fn is_in_contact(self) -> bool {
        matches!(self, Self::Upper | Self::Lower | Self::Gripped)
    }

    /// Direction of slip of a clutch, else 0.
    #[inline(always)]
    pub(crate) fn slips(self) -> f64 {
        match self {
            Self::SlipsAhead => 1.0,
            Self::SlipsBack => -1.0,
            _ => 0.0,
        }
    }
}

/// The discrete state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mode<S> {
    pub flow: Flow,
    /// Sign of the current if a drop or the limit depends on it, else 0.
    pub flow_sign: f64,
    /// Sign of the motor's torque, for friction that depends on it.
    pub torque_sign: f64,
    /// Each side's direction of slip: -1, +1, or 0 if it sticks.
    pub slip: [f64; 2],
    pub contact: Contact,
    /// Origin of each side's presliding friction.
    pub anchor: [Anchor<S>; 2],
}

/// A point on Dahl's friction curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Anchor<S> {
    /// Angle in rad.
    pub angle: S,
    /// Friction torque there in N m.
    pub friction: S,
    /// Its limit there: the friction of steady sliding in N m.
    pub sliding: S,
}

impl<S: Scalar> Anchor<S> {
    /// Without friction.
    pub fn at(angle: S) -> Self {
        Self {
            angle,
            friction: S::zero(),
            sliding: S::zero(),
        }
    }
}
