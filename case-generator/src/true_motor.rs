//! The true motor: its parameters with the hidden effects. Neutral values mean no effect.

use crate::motor::Motor;
use crate::unmodelled::Unmodelled;

/// A ripple `amplitude sin(cycles angle + phase_rad)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Wave {
    pub(crate) amplitude: f64,
    pub(crate) cycles: f64,
    pub(crate) phase_rad: f64,
}

impl Wave {
    pub(crate) fn at(&self, angle: f64) -> f64 {
        if self.amplitude == 0.0 {
            0.0
        } else {
            self.amplitude * (self.cycles * angle + self.phase_rad).sin()
        }
    }
}

/// Coupling of motor and load as two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coupling {
    /// Share of the inertia on the load side.
    pub(crate) load_fraction: f64,
    /// Share of the friction on the load side.
    pub(crate) load_friction_share: f64,
    pub(crate) encoder_on_load: bool,
    pub(crate) contact: Contact,
}

/// Pulses of the bridge, between which current decays through diodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pulses {
    /// Their period over L/R.
    pub(crate) period_ratio: f64,
    /// The diodes lead back into the supply; else they short-circuit the motor in one direction.
    pub(crate) into_supply: bool,
}

/// Transmission of the torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Contact {
    /// Stiff flanks at half the gap on either side, which push and never pull.
    Flanks { gap_rad: f64 },
    /// A spring and damper of this frequency and damping ratio, the two bodies free.
    Spring {
        frequency_hz: f64,
        damping_ratio: f64,
    },
    /// A clutch that slips at this torque.
    Clutch { limit_nm: f64 },
    /// Rollers that grip in one direction, at any position, and let the load overrun.
    OneWay,
}

/// The motor's own parameters and the parameters of its hidden effects.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TrueMotor {
    pub(crate) motor: Motor,
    pub(crate) delay_s: f64,
    /// Lead of the motor relative to the logged commands.
    pub(crate) ahead_s: f64,
    pub(crate) dead_zone_v: f64,
    /// Forward and back.
    pub(crate) dead_zones_v: (f64, f64),
    pub(crate) drop_v: f64,
    /// Additional drops forward and back.
    pub(crate) drops_v: (f64, f64),
    pub(crate) gain_asymmetry: f64,
    /// Share of both motor constants that is lost at the stall's copper loss.
    pub(crate) magnet_drop: f64,
    pub(crate) source_resistance_ohm: f64,
    pub(crate) gain: f64,
    pub(crate) current_limit_a: f64,
    pub(crate) coasts: bool,
    pub(crate) pulses: Option<Pulses>,
    pub(crate) resistance_rise_per_w: f64,
    pub(crate) thermal_time_s: f64,
    pub(crate) torque_ripple: Wave,
    pub(crate) stribeck_nm: f64,
    pub(crate) stribeck_speed_rad_s: f64,
    pub(crate) friction_asymmetry: f64,
    /// Deflection at which dry friction slides; 0 for the hundredth of a count of plain dry friction.
    pub(crate) break_in_rad: f64,
    pub(crate) driving_fraction: f64,
    pub(crate) driven_fraction: f64,
    pub(crate) drag: f64,
    pub(crate) viscous_asymmetry: f64,
    /// Static friction, if it exceeds Coulomb friction.
    pub(crate) static_nm: f64,
    pub(crate) load_nm: f64,
    pub(crate) gravity: Wave,
    pub(crate) cogging: Wave,
    pub(crate) coupling: Option<Coupling>,
    pub(crate) miss_probability: f64,
    pub(crate) max_edge_rate_hz: f64,
    /// Edge rate at which half of the edges are lost, and the exponent.
    pub(crate) half_lost_hz: f64,
    pub(crate) loss_exponent: f64,
    /// Time constant of the filter of the logged speed; 0 for none.
    pub(crate) filter_s: f64,
    pub(crate) eccentricity: Wave,
    pub(crate) jitter_s: f64,
    pub(crate) clock_error: f64,
    pub(crate) unmodelled: Option<Unmodelled>,
}

impl TrueMotor {
    /// The motor without effects.
    pub(crate) fn without_effects(motor: Motor) -> Self {
        Self {
            motor,
            delay_s: 0.0,
            ahead_s: 0.0,
            dead_zone_v: 0.0,
            dead_zones_v: (0.0, 0.0),
            drop_v: 0.0,
            drops_v: (0.0, 0.0),
            gain_asymmetry: 0.0,
            magnet_drop: 0.0,
            source_resistance_ohm: 0.0,
            gain: 1.0,
            current_limit_a: f64::INFINITY,
            coasts: false,
            pulses: None,
            resistance_rise_per_w: 0.0,
            thermal_time_s: 1.0,
            torque_ripple: Wave::default(),
            stribeck_nm: 0.0,
            stribeck_speed_rad_s: 1.0,
            friction_asymmetry: 0.0,
            break_in_rad: 0.0,
            driving_fraction: 0.0,
            driven_fraction: 0.0,
            drag: 0.0,
            viscous_asymmetry: 0.0,
            static_nm: 0.0,
            load_nm: 0.0,
            gravity: Wave::default(),
            cogging: Wave::default(),
            coupling: None,
            miss_probability: 0.0,
            max_edge_rate_hz: f64::INFINITY,
            half_lost_hz: f64::INFINITY,
            loss_exponent: 1.0,
            filter_s: 0.0,
            eccentricity: Wave::default(),
            jitter_s: 0.0,
            clock_error: 0.0,
            unmodelled: None,
        }
    }
}
