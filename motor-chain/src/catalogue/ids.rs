//! Ids of the effects, as files, documents and commands name them.
//!
//! ```
//! use motor_chain::catalogue::{find, ids};
//!
//! assert!(find(ids::BACKLASH).is_some());
//! ```

/// `asymmetric_dead_zone`
pub const ASYMMETRIC_DEAD_ZONE: &str = "asymmetric_dead_zone";
/// `asymmetric_friction`
pub const ASYMMETRIC_FRICTION: &str = "asymmetric_friction";
/// `asymmetric_gain`
pub const ASYMMETRIC_GAIN: &str = "asymmetric_gain";
/// `asymmetric_viscous`
pub const ASYMMETRIC_VISCOUS: &str = "asymmetric_viscous";
/// `asymmetric_voltage_drop`
pub const ASYMMETRIC_VOLTAGE_DROP: &str = "asymmetric_voltage_drop";
/// `backlash`
pub const BACKLASH: &str = "backlash";
/// `clock_error`
pub const CLOCK_ERROR: &str = "clock_error";
/// `coast_at_zero`
pub const COAST_AT_ZERO: &str = "coast_at_zero";
/// `cogging`
pub const COGGING: &str = "cogging";
/// `command_offset`
pub const COMMAND_OFFSET: &str = "command_offset";
/// `compliance`
pub const COMPLIANCE: &str = "compliance";
/// `constant_load`
pub const CONSTANT_LOAD: &str = "constant_load";
/// `coulomb_friction`
pub const COULOMB_FRICTION: &str = "coulomb_friction";
/// `current_limit`
pub const CURRENT_LIMIT: &str = "current_limit";
/// `dead_zone`
pub const DEAD_ZONE: &str = "dead_zone";
/// `edge_rate_loss`
pub const EDGE_RATE_LOSS: &str = "edge_rate_loss";
/// `encoder_eccentricity`
pub const ENCODER_ECCENTRICITY: &str = "encoder_eccentricity";
/// `gravity_load`
pub const GRAVITY_LOAD: &str = "gravity_load";
/// `inductance`
pub const INDUCTANCE: &str = "inductance";
/// `inertia`
pub const INERTIA: &str = "inertia";
/// `load_friction`
pub const LOAD_FRICTION: &str = "load_friction";
/// `magnet_weakening`
pub const MAGNET_WEAKENING: &str = "magnet_weakening";
/// `missed_counts`
pub const MISSED_COUNTS: &str = "missed_counts";
/// `presliding`
pub const PRESLIDING: &str = "presliding";
/// `pwm_freewheel`
pub const PWM_FREEWHEEL: &str = "pwm_freewheel";
/// `quadratic_drag`
pub const QUADRATIC_DRAG: &str = "quadratic_drag";
/// `resolution_error`
pub const RESOLUTION_ERROR: &str = "resolution_error";
/// `sample_jitter`
pub const SAMPLE_JITTER: &str = "sample_jitter";
/// `slipping_clutch`
pub const SLIPPING_CLUTCH: &str = "slipping_clutch";
/// `speed_filter`
pub const SPEED_FILTER: &str = "speed_filter";
/// `static_friction`
pub const STATIC_FRICTION: &str = "static_friction";
/// `stribeck`
pub const STRIBECK: &str = "stribeck";
/// `supply_error`
pub const SUPPLY_ERROR: &str = "supply_error";
/// `supply_sag`
pub const SUPPLY_SAG: &str = "supply_sag";
/// `torque_ripple`
pub const TORQUE_RIPPLE: &str = "torque_ripple";
/// `transport_delay`
pub const TRANSPORT_DELAY: &str = "transport_delay";
/// `viscous_friction`
pub const VISCOUS_FRICTION: &str = "viscous_friction";
/// `voltage_drop`
pub const VOLTAGE_DROP: &str = "voltage_drop";
/// `winding_heating`
pub const WINDING_HEATING: &str = "winding_heating";
