//! The effects of the catalogue: ids, drawn magnitudes, and their changes of the motor.
//!
//! Ids and names of parameters are those of motorlab's motor files, repeated here because no code is shared.
//! Magnitudes are drawn over the catalogue's ranges, log-uniformly if a range spans more than a factor of three. An
//! effect that is a change of one of the motor's parameters exceeds three standard deviations of its tolerance.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::motor::{Motor, NOMINAL_SIGMA, four_digits};
use crate::true_motor::{Contact, Coupling, Pulses, TrueMotor, Wave};
use crate::unmodelled::Unmodelled;

/// Ids of the catalogue, in the order of the signal chain.
pub const CATALOGUE: [&str; 27] = [
    "transport_delay",
    "dead_zone",
    "voltage_drop",
    "supply_sag",
    "supply_error",
    "current_limit",
    "coast_at_zero",
    "inductance",
    "winding_heating",
    "torque_ripple",
    "coulomb_friction",
    "viscous_friction",
    "inertia",
    "stribeck",
    "asymmetric_friction",
    "presliding",
    "load_friction",
    "quadratic_drag",
    "gravity_load",
    "cogging",
    "backlash",
    "compliance",
    "resolution_error",
    "missed_counts",
    "encoder_eccentricity",
    "sample_jitter",
    "clock_error",
];

/// Effects added to the catalogue since the sets of [`crate::plan`] were fixed: drawn only by name.
pub const LATER: [&str; 12] = [
    "asymmetric_viscous",
    "static_friction",
    "constant_load",
    "edge_rate_loss",
    "speed_filter",
    "asymmetric_dead_zone",
    "asymmetric_voltage_drop",
    "asymmetric_gain",
    "magnet_weakening",
    "command_offset",
    "pwm_freewheel",
    "slipping_clutch",
];

/// An effect with its true parameters, in SI under the names of a motor file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Id of the catalogue, or one of [`crate::OUTSIDE`].
    pub id: String,
    /// True values.
    pub parameters: BTreeMap<String, f64>,
}

fn log_uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    (rng.random_range(low.ln()..high.ln())).exp()
}

/// A factor from the range outside the tolerance.
fn clear_factor(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    loop {
        let factor = log_uniform(rng, low, high);
        if factor.ln().abs() > 3.0 * NOMINAL_SIGMA {
            return factor;
        }
    }
}

fn phase(rng: &mut impl Rng) -> f64 {
    rng.random_range(0.0..TAU)
}

fn side(rng: &mut impl Rng) -> f64 {
    f64::from(u8::from(rng.random_bool(0.5)))
}

impl Effect {
    /// Draws the magnitudes of a catalogue effect for this motor.
    ///
    /// # Panics
    /// If `id` is neither in [`CATALOGUE`], in [`LATER`] nor in [`crate::OUTSIDE`]; callers check names first.
    pub(crate) fn draw(id: &str, motor: &Motor, rng: &mut impl Rng) -> Self {
        let m = motor;
        let tf = m.coulomb_friction_nm;
        let count = m.count_rad();
        let values: Vec<(&str, f64)> = match id {
            "transport_delay" => vec![("delay_s", log_uniform(rng, 0.0003, 0.09))],
            "dead_zone" => vec![("threshold_v", rng.random_range(0.2..1.5))],
            "voltage_drop" => vec![("drop_v", log_uniform(rng, 0.1, 1.5))],
            "supply_sag" => vec![(
                "source_resistance_ohm",
                log_uniform(rng, 0.05, 1.0) * m.resistance_ohm,
            )],
            "supply_error" => vec![("gain", clear_factor(rng, 0.7, 1.3))],
            "current_limit" => {
                vec![("limit_a", rng.random_range(0.2..0.8) * m.stall_current_a())]
            }
            "coast_at_zero" => vec![],
            "inductance" => vec![(
                "inductance_h",
                log_uniform(rng, 0.001, 0.03) * m.resistance_ohm,
            )],
            "winding_heating" => {
                // Up to +40 % at a quarter of the stall power.
                let rise = log_uniform(rng, 0.04, 0.4);
                let power = 0.25 * m.supply_v * m.supply_v / m.resistance_ohm;
                vec![
                    ("resistance_rise_per_w", rise / power),
                    ("time_constant_s", log_uniform(rng, 1.0, 120.0)),
                ]
            }
            "torque_ripple" => vec![
                ("amplitude", log_uniform(rng, 0.01, 0.25)),
                ("cycles_per_rev", f64::from(rng.random_range(2..=30))),
                ("phase_rad", phase(rng)),
            ],
            "coulomb_friction" => vec![("torque_nm", clear_factor(rng, 0.5, 5.0) * tf)],
            "viscous_friction" => vec![(
                "coefficient_nm_s_per_rad",
                clear_factor(rng, 1.0, 10.0) * m.viscous_friction_nm_s_per_rad,
            )],
            "inertia" => vec![(
                "inertia_kg_m2",
                clear_factor(rng, 0.3, 4.0) * m.inertia_kg_m2,
            )],
            "stribeck" => vec![
                ("extra_torque_nm", log_uniform(rng, 0.3, 4.0) * tf),
                ("stribeck_speed_rad_s", log_uniform(rng, 0.1, 2.0)),
            ],
            "asymmetric_friction" => {
                let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                vec![("ratio", sign * log_uniform(rng, 0.05, 0.8))]
            }
            "presliding" => vec![("break_in_angle_rad", log_uniform(rng, 0.5, 10.0) * count)],
            "load_friction" => vec![
                ("driving_fraction", rng.random_range(0.0..0.5)),
                ("driven_fraction", rng.random_range(0.0..0.5)),
            ],
            "quadratic_drag" => vec![(
                "coefficient_nm_s2_per_rad2",
                log_uniform(rng, 0.1, 2.0) * m.viscous_friction_nm_s_per_rad / m.top_speed_rad_s(),
            )],
            "gravity_load" => vec![
                ("torque_nm", log_uniform(rng, 0.3, 5.0) * tf),
                ("phase_rad", phase(rng)),
            ],
            "cogging" => vec![
                ("torque_nm", log_uniform(rng, 0.3, 4.0) * tf),
                ("cycles_per_rev", f64::from(rng.random_range(2..=30))),
                ("phase_rad", phase(rng)),
            ],
            "backlash" => vec![
                ("gap_rad", log_uniform(rng, 0.5, 10.0).to_radians()),
                ("load_fraction", rng.random_range(0.05..0.9)),
                ("encoder_side", side(rng)),
            ],
            "compliance" => vec![
                ("frequency_hz", log_uniform(rng, 1.0, 50.0)),
                ("damping_ratio", log_uniform(rng, 0.02, 0.5)),
                ("load_fraction", rng.random_range(0.05..0.9)),
                ("encoder_side", side(rng)),
            ],
            "resolution_error" => {
                const ENCODERS: [f64; 8] =
                    [360.0, 400.0, 500.0, 720.0, 1000.0, 1024.0, 1440.0, 2000.0];
                let other = ENCODERS.map(|n| n * m.counts_per_rev / 720.0);
                let far: Vec<f64> = other
                    .into_iter()
                    .filter(|n| (n / m.counts_per_rev).ln().abs() > 3.0 * NOMINAL_SIGMA)
                    .collect();
                vec![("counts_per_rev", far[rng.random_range(0..far.len())])]
            }
            "missed_counts" => {
                let top_rate = m.top_speed_rad_s() / count;
                let limited = rng.random_bool(0.3);
                vec![
                    (
                        "probability",
                        if limited {
                            0.0
                        } else {
                            log_uniform(rng, 0.001, 0.05)
                        },
                    ),
                    (
                        "max_rate_hz",
                        if limited {
                            rng.random_range(0.5..0.95) * top_rate
                        } else {
                            0.0
                        },
                    ),
                ]
            }
            "encoder_eccentricity" => vec![
                ("amplitude_rad", log_uniform(rng, 0.3, 6.0) * count),
                ("phase_rad", phase(rng)),
            ],
            // Up to one sample time of the fast runs; the slow one has the same.
            "sample_jitter" => vec![("spread_s", log_uniform(rng, 0.00015, 0.003))],
            "clock_error" => {
                let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                vec![("relative", sign * log_uniform(rng, 0.001, 0.1))]
            }
            "asymmetric_viscous" => {
                let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                vec![("ratio", sign * log_uniform(rng, 0.05, 0.8))]
            }
            "static_friction" => vec![("torque_nm", log_uniform(rng, 1.1, 4.0) * tf)],
            "constant_load" => {
                let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                vec![("torque_nm", sign * log_uniform(rng, 0.1, 3.0) * tf)]
            }
            "edge_rate_loss" => vec![
                (
                    "rate_hz",
                    log_uniform(rng, 0.7, 1.5) * m.top_speed_rad_s() / count,
                ),
                ("exponent", log_uniform(rng, 2.0, 40.0)),
            ],
            "speed_filter" => vec![("time_constant_s", log_uniform(rng, 0.001, 0.2))],
            "asymmetric_dead_zone" => vec![
                ("positive_v", rng.random_range(0.05..0.4) * m.supply_v),
                ("negative_v", rng.random_range(0.05..0.4) * m.supply_v),
            ],
            "asymmetric_voltage_drop" => vec![
                ("positive_v", log_uniform(rng, 0.02, 0.3) * m.supply_v),
                ("negative_v", log_uniform(rng, 0.02, 0.3) * m.supply_v),
            ],
            "asymmetric_gain" => {
                let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                vec![("ratio", sign * log_uniform(rng, 0.01, 0.3))]
            }
            "magnet_weakening" => vec![
                ("drop", log_uniform(rng, 0.02, 0.6)),
                ("time_constant_s", log_uniform(rng, 1.0, 120.0)),
            ],
            // Up to five samples of the fast runs.
            "command_offset" => vec![("offset_s", log_uniform(rng, 0.0003, 0.015))],
            "pwm_freewheel" => vec![
                ("period_ratio", log_uniform(rng, 0.1, 20.0)),
                ("into_supply", side(rng)),
            ],
            "slipping_clutch" => vec![
                (
                    "torque_nm",
                    rng.random_range(0.1..0.8) * m.torque_constant_nm_per_a * m.stall_current_a(),
                ),
                ("load_share", rng.random_range(0.05..0.9)),
            ],
            outside => Unmodelled::draw(outside, motor, rng),
        };
        Self {
            id: id.to_owned(),
            parameters: values
                .into_iter()
                .map(|(name, value)| (name.to_owned(), four_digits(value)))
                .collect(),
        }
    }

    /// The same with a separately drawn division of friction between motor and load, if there are two bodies.
    pub(crate) fn with_friction_elsewhere(mut self, rng: &mut impl Rng) -> Self {
        if matches!(self.id.as_str(), "backlash" | "compliance") {
            let weight = four_digits(log_uniform(rng, 0.1, 10.0));
            self.parameters
                .insert("load_friction_weight".to_owned(), weight);
        }
        self
    }

    fn value(&self, name: &str) -> f64 {
        self.parameters.get(name).copied().unwrap_or(0.0)
    }

    fn wave(&self, amplitude: &str) -> Wave {
        Wave {
            amplitude: self.value(amplitude),
            cycles: self
                .parameters
                .get("cycles_per_rev")
                .copied()
                .unwrap_or(1.0),
            phase_rad: self.value("phase_rad"),
        }
    }

    /// Adds the effect to a motor.
    pub(crate) fn apply(&self, hidden: &mut TrueMotor) {
        match self.id.as_str() {
            "transport_delay" => hidden.delay_s = self.value("delay_s"),
            "dead_zone" => hidden.dead_zone_v = self.value("threshold_v"),
            "voltage_drop" => hidden.drop_v = self.value("drop_v"),
            "asymmetric_dead_zone" => {
                hidden.dead_zones_v = (self.value("positive_v"), self.value("negative_v"));
            }
            "asymmetric_voltage_drop" => {
                hidden.drops_v = (self.value("positive_v"), self.value("negative_v"));
            }
            "asymmetric_gain" => hidden.gain_asymmetry = self.value("ratio"),
            "magnet_weakening" => {
                hidden.magnet_drop = self.value("drop");
                hidden.thermal_time_s = self.value("time_constant_s");
            }
            "supply_sag" => hidden.source_resistance_ohm = self.value("source_resistance_ohm"),
            "supply_error" => hidden.gain = self.value("gain"),
            "current_limit" => hidden.current_limit_a = self.value("limit_a"),
            "coast_at_zero" => hidden.coasts = true,
            "inductance" => hidden.motor.inductance_h = self.value("inductance_h"),
            "winding_heating" => {
                hidden.resistance_rise_per_w = self.value("resistance_rise_per_w");
                hidden.thermal_time_s = self.value("time_constant_s");
            }
            "torque_ripple" => hidden.torque_ripple = self.wave("amplitude"),
            "coulomb_friction" => hidden.motor.coulomb_friction_nm = self.value("torque_nm"),
            "viscous_friction" => {
                hidden.motor.viscous_friction_nm_s_per_rad = self.value("coefficient_nm_s_per_rad");
            }
            "inertia" => hidden.motor.inertia_kg_m2 = self.value("inertia_kg_m2"),
            "stribeck" => {
                hidden.stribeck_nm = self.value("extra_torque_nm");
                hidden.stribeck_speed_rad_s = self.value("stribeck_speed_rad_s");
            }
            "asymmetric_friction" => hidden.friction_asymmetry = self.value("ratio"),
            "presliding" => hidden.break_in_rad = self.value("break_in_angle_rad"),
            "load_friction" => {
                hidden.driving_fraction = self.value("driving_fraction");
                hidden.driven_fraction = self.value("driven_fraction");
            }
            "quadratic_drag" => hidden.drag = self.value("coefficient_nm_s2_per_rad2"),
            "gravity_load" => hidden.gravity = self.wave("torque_nm"),
            "cogging" => hidden.cogging = self.wave("torque_nm"),
            "backlash" => {
                let gap_rad = self.value("gap_rad");
                hidden.coupling = Some(self.coupling(Contact::Flanks { gap_rad }));
            }
            "compliance" => {
                hidden.coupling = Some(self.coupling(Contact::Spring {
                    frequency_hz: self.value("frequency_hz"),
                    damping_ratio: self.value("damping_ratio"),
                }));
            }
            "resolution_error" => hidden.motor.counts_per_rev = self.value("counts_per_rev"),
            "missed_counts" => {
                hidden.miss_probability = self.value("probability");
                let rate = self.value("max_rate_hz");
                if rate > 0.0 {
                    hidden.max_edge_rate_hz = rate;
                }
            }
            "encoder_eccentricity" => hidden.eccentricity = self.wave("amplitude_rad"),
            "sample_jitter" => hidden.jitter_s = self.value("spread_s"),
            "clock_error" => hidden.clock_error = self.value("relative"),
            "asymmetric_viscous" => hidden.viscous_asymmetry = self.value("ratio"),
            "static_friction" => hidden.static_nm = self.value("torque_nm"),
            "constant_load" => hidden.load_nm = self.value("torque_nm"),
            "edge_rate_loss" => {
                hidden.half_lost_hz = self.value("rate_hz");
                hidden.loss_exponent = self.value("exponent");
            }
            "speed_filter" => hidden.filter_s = self.value("time_constant_s"),
            "command_offset" => hidden.ahead_s = self.value("offset_s"),
            "pwm_freewheel" => {
                hidden.pulses = Some(Pulses {
                    period_ratio: self.value("period_ratio"),
                    into_supply: self.value("into_supply") > 0.5,
                });
                hidden.coasts = true;
            }
            "slipping_clutch" => {
                let limit_nm = self.value("torque_nm");
                let load_fraction = self.value("load_share");
                hidden.coupling = Some(Coupling {
                    load_fraction,
                    load_friction_share: load_fraction,
                    encoder_on_load: false,
                    contact: Contact::Clutch { limit_nm },
                });
            }
            "one_way_clutch" => hidden.coupling = Some(self.coupling(Contact::OneWay)),
            _ => hidden.unmodelled = Unmodelled::new(self),
        }
    }

    fn coupling(&self, contact: Contact) -> Coupling {
        let load_fraction = self.value("load_fraction");
        // Friction per inertia of the load over that of the motor.
        let weight = self.parameters.get("load_friction_weight");
        let rubs = load_fraction * weight.copied().unwrap_or(1.0);
        Coupling {
            load_fraction,
            load_friction_share: rubs / (1.0 - load_fraction + rubs),
            encoder_on_load: self.value("encoder_side") > 0.5,
            contact,
        }
    }
}
