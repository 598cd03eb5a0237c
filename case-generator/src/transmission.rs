//! Torque between motor and load from their twist: flanks with a gap, a spring, a slipping clutch or a one-way
//! clutch.

use std::f64::consts::TAU;

use crate::friction::Bristles;
use crate::true_motor::Contact;

/// Natural frequency in Hz of two bodies on a stiff flank or a gripping clutch.
const CONTACT_HZ: f64 = 300.0;

/// Torque of the coupling for a twist and its rate.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Transmission {
    Flanks {
        half_gap: f64,
        stiffness: f64,
        damping: f64,
    },
    Spring {
        stiffness: f64,
        damping: f64,
    },
    Clutch {
        limit_nm: f64,
        bristles: Bristles,
    },
    OneWay {
        /// Twist at which the rollers begin to grip: it follows an overrunning load.
        seat: f64,
        stiffness: f64,
        damping: f64,
    },
}

impl Transmission {
    pub(crate) fn new(contact: Contact, reduced_inertia: f64) -> Self {
        let spring = |hz: f64, ratio: f64| {
            let rate = TAU * hz;
            (
                rate * rate * reduced_inertia,
                2.0 * ratio * rate * reduced_inertia,
            )
        };
        match contact {
            Contact::Flanks { gap_rad } => {
                let (stiffness, damping) = spring(CONTACT_HZ, 0.6);
                Self::Flanks {
                    half_gap: 0.5 * gap_rad,
                    stiffness,
                    damping,
                }
            }
            Contact::Spring {
                frequency_hz,
                damping_ratio,
            } => {
                let (stiffness, damping) = spring(frequency_hz, damping_ratio);
                Self::Spring { stiffness, damping }
            }
            Contact::Clutch { limit_nm } => {
                let (stiffness, _) = spring(CONTACT_HZ, 0.0);
                let bend = limit_nm / stiffness;
                Self::Clutch {
                    limit_nm,
                    bristles: Bristles::new(limit_nm, bend, reduced_inertia, 0.6),
                }
            }
            Contact::OneWay => {
                let (stiffness, damping) = spring(CONTACT_HZ, 0.6);
                Self::OneWay {
                    seat: 0.0,
                    stiffness,
                    damping,
                }
            }
        }
    }

    /// Torque in N m for a twist in rad and its rate, `h` seconds after the last call.
    pub(crate) fn torque(&mut self, twist: f64, rate: f64, h: f64) -> f64 {
        match self {
            Self::Flanks {
                half_gap,
                stiffness,
                damping,
            } => {
                if twist > *half_gap {
                    (*stiffness * (twist - *half_gap) + *damping * rate).max(0.0)
                } else if twist < -*half_gap {
                    (*stiffness * (twist + *half_gap) + *damping * rate).min(0.0)
                } else {
                    0.0
                }
            }
            Self::Spring { stiffness, damping } => *stiffness * twist + *damping * rate,
            Self::Clutch { limit_nm, bristles } => bristles.step(rate, *limit_nm, h),
            Self::OneWay {
                seat,
                stiffness,
                damping,
            } => {
                *seat = seat.min(twist);
                let grip = *stiffness * (twist - *seat);
                if grip > 0.0 {
                    (grip + *damping * rate).max(0.0)
                } else {
                    0.0
                }
            }
        }
    }
}
