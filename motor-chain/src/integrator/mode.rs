//! The discrete state of the hybrid system: which of the smooth equations of motion hold.

use crate::scalar::Scalar;

/// Mode of the driver's current.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    /// It follows the voltage.
    Free,
    /// The voltage drop holds it at 0.
    Blocked,
    /// The driver holds it at its limit, or at what is commanded.
    Held,
    /// The circuit is open.
    Open,
}

/// Which flanks touch; in a transmission with a spring, through it. Or what a clutch does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Contact {
    /// There are none: rigid, or a spring.
    NoFlanks,
    /// Neither.
    Apart,
    /// The motor side pushes the load forward.
    Upper,
    /// The motor side pushes the load back.
    Lower,
    /// A clutch holds.
    Gripped,
    /// It slips, the motor side ahead.
    SlipsAhead,
    /// It slips, the motor side back.
    SlipsBack,
}

impl Contact {
    /// +1, -1, or 0 where nothing touches.
    #[inline(always)]
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Upper => 1.0,
            Self::Lower => -1.0,
            _ => 0.0,
        }
    }

    /// Whether the sides meet: at a flank, or in a clutch that holds.
    #[inline(always)]
    pub(crate) fn meets(self) -> bool {
        matches!(self, Self::Upper | Self::Lower | Self::Gripped)
    }

    /// Direction in which a clutch slips, 0 where none does.
    #[inline(always)]
    pub(crate) fn slips(self) -> f64 {
        match self {
            Self::SlipsAhead => 1.0,
            Self::SlipsBack => -1.0,
            _ => 0.0,
        }
    }
}

/// The discrete state: which smooth equations hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mode<S> {
    pub flow: Flow,
    /// Direction of the current where a drop or the limit depends on it, else 0.
    pub flow_sign: f64,
    /// Direction of the motor's torque, for friction that depends on it.
    pub torque_sign: f64,
    /// Each side's direction of slip: -1, +1, or 0 where it sticks.
    pub slip: [f64; 2],
    pub contact: Contact,
    /// From where each side's friction has been building up.
    pub anchor: [Anchor<S>; 2],
}

/// A point of Dahl's friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Anchor<S> {
    /// Angle in rad.
    pub angle: S,
    /// Friction torque there in N m.
    pub friction: S,
    /// Value that it approached there: the friction of steady sliding in N m.
    pub sliding: S,
}

impl<S: Scalar> Anchor<S> {
    /// No friction yet.
    pub fn at(angle: S) -> Self {
        Self {
            angle,
            friction: S::zero(),
            sliding: S::zero(),
        }
    }
}
