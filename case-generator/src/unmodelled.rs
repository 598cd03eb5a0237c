//! Effects outside the catalogue, at least one in every stage of the chain.
//!
//! | id | stage | depends on |
//! | --- | --- | --- |
//! | `command_dropout` | command | time, periodic: the command is lost for a moment |
//! | `coarse_command` | command | level: the command is rounded to a few steps |
//! | `supply_flicker` | driver | chance: the supply falls to a fraction for tens of ms |
//! | `rate_limit` | driver | history: the output follows at so many V/s |
//! | `thermal_cutout` | driver | history: the bridge opens when it is hot, until it has cooled |
//! | `brush_bounce` | electrical | chance, by speed: the brushes lose contact for tens of ms |
//! | `bearing_loosening` | mechanical | history: dry friction falls as rubbing warms the bearing |
//! | `grease_settling` | mechanical | history: rest stiffens, travel frees |
//! | `load_pulse` | mechanical | chance: something rubs for a moment |
//! | `vibration` | mechanical | time: a torque that swings by itself |
//! | `stiction_patch` | mechanical | angle: one sector rubs more |
//! | `belt_jump` | transmission | chance, under load: the belt jumps a tooth |
//! | `one_way_clutch` | transmission | sign: the load is carried forward and overruns back |
//! | `spurious_counts` | sensor | chance: bursts of edges that were none |
//! | `clock_stall` | timing | chance: the board stands still and does not know |

use std::f64::consts::TAU;

use rand::{Rng, RngExt};

use crate::effect::Effect;
use crate::motor::Motor;

/// Share of its cutout heat at which a bridge closes again: data sheets state a hysteresis of 20 to 40 K on some 150
/// K.
const COOL: f64 = 0.8;

/// Ids of the effects outside the catalogue.
pub const OUTSIDE: [&str; 15] = [
    "command_dropout",
    "coarse_command",
    "supply_flicker",
    "rate_limit",
    "thermal_cutout",
    "brush_bounce",
    "bearing_loosening",
    "grease_settling",
    "load_pulse",
    "vibration",
    "stiction_patch",
    "belt_jump",
    "one_way_clutch",
    "spurious_counts",
    "clock_stall",
];

/// An effect outside the catalogue with its parameters (all but `one_way_clutch`, a kind of coupling).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Unmodelled {
    CommandDropout {
        period_s: f64,
        lost_s: f64,
        start_s: f64,
    },
    CoarseCommand {
        step_v: f64,
    },
    SupplyFlicker {
        rate_hz: f64,
        mean_s: f64,
        fraction: f64,
    },
    RateLimit {
        volts_per_s: f64,
    },
    ThermalCutout {
        limit_w: f64,
        time_constant_s: f64,
    },
    BrushBounce {
        rate_per_rad: f64,
        mean_s: f64,
    },
    BearingLoosening {
        loss: f64,
        energy_j: f64,
    },
    GreaseSettling {
        extra_nm: f64,
        rest_s: f64,
        travel_rad: f64,
    },
    LoadPulse {
        rate_hz: f64,
        mean_s: f64,
        torque_nm: f64,
    },
    Vibration {
        torque_nm: f64,
        frequency_hz: f64,
        phase_rad: f64,
    },
    StictionPatch {
        extra_nm: f64,
        from_rad: f64,
        width_rad: f64,
    },
    BeltJump {
        rate_hz: f64,
        torque_nm: f64,
        pitch_rad: f64,
    },
    SpuriousCounts {
        rate_hz: f64,
        largest: f64,
    },
    ClockStall {
        rate_hz: f64,
        mean_s: f64,
    },
}

impl Unmodelled {
    /// Draws the parameters of an effect of [`OUTSIDE`].
    ///
    /// # Panics
    /// If `id` is not one of them.
    pub(crate) fn draw(id: &str, m: &Motor, rng: &mut impl Rng) -> Vec<(&'static str, f64)> {
        let tf = m.coulomb_friction_nm;
        let stall_nm = m.stall_current_a() * m.torque_constant_nm_per_a;
        let stall_w = m.stall_current_a() * m.supply_v;
        let mut between = |low: f64, high: f64| rng.random_range(low..high);
        match id {
            "command_dropout" => vec![
                ("period_s", between(0.5, 2.5)),
                ("lost_s", between(0.02, 0.15)),
                ("start_s", between(0.0, 0.5)),
            ],
            "coarse_command" => vec![("step_v", m.supply_v / between(3.0, 8.0).round())],
            "supply_flicker" => vec![
                ("rate_hz", between(0.4, 2.5)),
                ("mean_s", between(0.02, 0.2)),
                ("fraction", between(0.3, 0.85)),
            ],
            "rate_limit" => vec![("volts_per_s", m.supply_v * between(2.0, 20.0))],
            "thermal_cutout" => vec![
                ("limit_w", stall_w * between(0.03, 0.3)),
                ("time_constant_s", between(0.03, 0.5)),
            ],
            "brush_bounce" => vec![
                ("rate_per_rad", between(0.03, 0.5)),
                ("mean_s", between(0.005, 0.05)),
            ],
            "bearing_loosening" => vec![
                ("loss", between(0.3, 0.8)),
                ("energy_j", tf * m.top_speed_rad_s() * between(1.0, 8.0)),
            ],
            "grease_settling" => vec![
                ("extra_nm", tf * between(1.0, 6.0)),
                ("rest_s", between(0.05, 0.5)),
                ("travel_rad", between(0.5, 6.0)),
            ],
            "load_pulse" => vec![
                ("rate_hz", between(0.3, 1.5)),
                ("mean_s", between(0.05, 0.5)),
                ("torque_nm", stall_nm * between(0.1, 0.5)),
            ],
            "vibration" => vec![
                ("torque_nm", tf * between(0.5, 5.0)),
                ("frequency_hz", between(0.4, 9.0)),
                ("phase_rad", between(0.0, TAU)),
            ],
            "stiction_patch" => vec![
                ("extra_nm", tf * between(2.0, 8.0)),
                ("from_rad", between(0.0, TAU)),
                ("width_rad", between(0.2, 1.2)),
            ],
            "belt_jump" => vec![
                ("rate_hz", between(1.0, 6.0)),
                ("torque_nm", stall_nm * between(0.3, 0.7)),
                ("pitch_rad", TAU / between(15.0, 60.0).round()),
            ],
            "one_way_clutch" => vec![("load_fraction", between(0.3, 0.8))],
            "spurious_counts" => vec![
                ("rate_hz", between(0.5, 3.0)),
                ("largest", between(6.0, 40.0).round()),
            ],
            "clock_stall" => vec![
                ("rate_hz", between(0.3, 2.0)),
                ("mean_s", between(0.01, 0.06)),
            ],
            other => panic!("'{other}' is no effect of the catalogue and none of those outside it"),
        }
    }

    /// Whether it is visible in the counts but not in the angle at the encoder.
    pub(crate) fn adds_counts(&self) -> bool {
        matches!(self, Self::SpuriousCounts { .. })
    }

    /// The unmodelled effect of an effect's id and parameters; `None` for a catalogue effect.
    pub(crate) fn new(effect: &Effect) -> Option<Self> {
        let v = |name: &str| effect.parameters.get(name).copied().unwrap_or(0.0);
        Some(match effect.id.as_str() {
            "command_dropout" => Self::CommandDropout {
                period_s: v("period_s"),
                lost_s: v("lost_s"),
                start_s: v("start_s"),
            },
            "coarse_command" => Self::CoarseCommand {
                step_v: v("step_v"),
            },
            "supply_flicker" => Self::SupplyFlicker {
                rate_hz: v("rate_hz"),
                mean_s: v("mean_s"),
                fraction: v("fraction"),
            },
            "rate_limit" => Self::RateLimit {
                volts_per_s: v("volts_per_s"),
            },
            "thermal_cutout" => Self::ThermalCutout {
                limit_w: v("limit_w"),
                time_constant_s: v("time_constant_s"),
            },
            "brush_bounce" => Self::BrushBounce {
                rate_per_rad: v("rate_per_rad"),
                mean_s: v("mean_s"),
            },
            "bearing_loosening" => Self::BearingLoosening {
                loss: v("loss"),
                energy_j: v("energy_j"),
            },
            "grease_settling" => Self::GreaseSettling {
                extra_nm: v("extra_nm"),
                rest_s: v("rest_s"),
                travel_rad: v("travel_rad"),
            },
            "load_pulse" => Self::LoadPulse {
                rate_hz: v("rate_hz"),
                mean_s: v("mean_s"),
                torque_nm: v("torque_nm"),
            },
            "vibration" => Self::Vibration {
                torque_nm: v("torque_nm"),
                frequency_hz: v("frequency_hz"),
                phase_rad: v("phase_rad"),
            },
            "stiction_patch" => Self::StictionPatch {
                extra_nm: v("extra_nm"),
                from_rad: v("from_rad"),
                width_rad: v("width_rad"),
            },
            "belt_jump" => Self::BeltJump {
                rate_hz: v("rate_hz"),
                torque_nm: v("torque_nm"),
                pitch_rad: v("pitch_rad"),
            },
            "spurious_counts" => Self::SpuriousCounts {
                rate_hz: v("rate_hz"),
                largest: v("largest"),
            },
            "clock_stall" => Self::ClockStall {
                rate_hz: v("rate_hz"),
                mean_s: v("mean_s"),
            },
            _ => return None,
        })
    }
}

/// State of the plant that an unmodelled effect depends on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlantState {
    pub(crate) t_s: f64,
    pub(crate) command_v: f64,
    pub(crate) angle_rad: f64,
    pub(crate) speed_rad_s: f64,
    pub(crate) heat_w: f64,
    pub(crate) torque_nm: f64,
    pub(crate) friction_nm: f64,
}

/// Effect on the plant, constant until the next update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Disturbance {
    pub(crate) command_v: f64,
    pub(crate) supply_factor: f64,
    pub(crate) friction_factor: f64,
    pub(crate) extra_friction_nm: f64,
    /// No current flows.
    pub(crate) is_open: bool,
    pub(crate) load_nm: f64,
    pub(crate) angle_offset_rad: f64,
    pub(crate) count_offset: i64,
}

impl Disturbance {
    pub(crate) fn none(command_v: f64) -> Self {
        Self {
            command_v,
            supply_factor: 1.0,
            friction_factor: 1.0,
            extra_friction_nm: 0.0,
            is_open: false,
            load_nm: 0.0,
            angle_offset_rad: 0.0,
            count_offset: 0,
        }
    }
}

/// An unmodelled effect during a recording, with its internal state.
#[derive(Debug, Clone)]
pub(crate) struct UnmodelledState {
    unmodelled: Unmodelled,
    /// Absorbed energy, heat, output voltage, settling or angle jumped: one state variable each.
    state: f64,
    /// End of the present event in s; infinite if unknown.
    until_s: f64,
    counts: i64,
}

impl UnmodelledState {
    pub(crate) fn new(unmodelled: Unmodelled) -> Self {
        let state = match unmodelled {
            // It has rested for long before the run.
            Unmodelled::GreaseSettling { .. } => 1.0,
            _ => 0.0,
        };
        Self {
            unmodelled,
            state,
            until_s: f64::NEG_INFINITY,
            counts: 0,
        }
    }

    /// Whether an event is active that occurs at `rate_hz` and lasts `mean_s` on average (both exponential).
    fn event_is_on(
        &mut self,
        t_s: f64,
        dt: f64,
        rate_hz: f64,
        mean_s: f64,
        rng: &mut impl Rng,
    ) -> bool {
        if t_s >= self.until_s && rng.random_bool((rate_hz * dt).min(1.0)) {
            self.until_s = t_s - mean_s * (1.0 - rng.random_range(0.0..1.0_f64)).ln();
        }
        t_s < self.until_s
    }

    /// The effect after `dt` seconds.
    pub(crate) fn step(&mut self, plant: PlantState, dt: f64, rng: &mut impl Rng) -> Disturbance {
        let mut disturbance = Disturbance::none(plant.command_v);
        match self.unmodelled {
            Unmodelled::CommandDropout {
                period_s,
                lost_s,
                start_s,
            } => {
                if (plant.t_s - start_s).rem_euclid(period_s) < lost_s {
                    disturbance.command_v = 0.0;
                }
            }
            Unmodelled::CoarseCommand { step_v } => {
                disturbance.command_v = (plant.command_v / step_v).round() * step_v;
            }
            Unmodelled::SupplyFlicker {
                rate_hz,
                mean_s,
                fraction,
            } => {
                if self.event_is_on(plant.t_s, dt, rate_hz, mean_s, rng) {
                    disturbance.supply_factor = fraction;
                }
            }
            Unmodelled::RateLimit { volts_per_s } => {
                let most = volts_per_s * dt;
                self.state += (plant.command_v - self.state).clamp(-most, most);
                disturbance.command_v = self.state;
            }
            Unmodelled::ThermalCutout {
                limit_w,
                time_constant_s,
            } => {
                let kept = (-dt / time_constant_s).exp();
                self.state = kept * self.state + (1.0 - kept) * plant.heat_w;
                if self.state > limit_w {
                    self.until_s = f64::INFINITY;
                } else if self.state < COOL * limit_w {
                    self.until_s = f64::NEG_INFINITY;
                }
                disturbance.is_open = plant.t_s < self.until_s;
            }
            Unmodelled::BrushBounce {
                rate_per_rad,
                mean_s,
            } => {
                let rate_hz = rate_per_rad * plant.speed_rad_s.abs();
                disturbance.is_open = self.event_is_on(plant.t_s, dt, rate_hz, mean_s, rng);
            }
            Unmodelled::BearingLoosening { loss, energy_j } => {
                self.state += (plant.friction_nm * plant.speed_rad_s).abs() * dt;
                disturbance.friction_factor = 1.0 - loss * (1.0 - (-self.state / energy_j).exp());
            }
            Unmodelled::GreaseSettling {
                extra_nm,
                rest_s,
                travel_rad,
            } => {
                let freed = plant.speed_rad_s.abs() / travel_rad;
                let rate = if plant.speed_rad_s.abs() < 0.02 {
                    (1.0 - self.state) / rest_s
                } else {
                    -self.state * freed
                };
                self.state = (self.state + rate * dt).clamp(0.0, 1.0);
                disturbance.extra_friction_nm = extra_nm * self.state;
            }
            Unmodelled::LoadPulse {
                rate_hz,
                mean_s,
                torque_nm,
            } => {
                if self.event_is_on(plant.t_s, dt, rate_hz, mean_s, rng) {
                    disturbance.extra_friction_nm = torque_nm;
                }
            }
            Unmodelled::Vibration {
                torque_nm,
                frequency_hz,
                phase_rad,
            } => {
                disturbance.load_nm =
                    torque_nm * (TAU * frequency_hz * plant.t_s + phase_rad).sin();
            }
            Unmodelled::StictionPatch {
                extra_nm,
                from_rad,
                width_rad,
            } => {
                if (plant.angle_rad - from_rad).rem_euclid(TAU) < width_rad {
                    disturbance.extra_friction_nm = extra_nm;
                }
            }
            Unmodelled::BeltJump {
                rate_hz,
                torque_nm,
                pitch_rad,
            } => {
                if plant.torque_nm.abs() > torque_nm && rng.random_bool((rate_hz * dt).min(1.0)) {
                    self.state -= pitch_rad * plant.torque_nm.signum();
                }
                disturbance.angle_offset_rad = self.state;
            }
            Unmodelled::SpuriousCounts { rate_hz, largest } => {
                if rng.random_bool((rate_hz * dt).min(1.0)) {
                    let size = rng.random_range(3..=(largest as i64).max(3));
                    self.counts += if rng.random_bool(0.5) { size } else { -size };
                }
                disturbance.count_offset = self.counts;
            }
            Unmodelled::ClockStall { .. } => {}
        }
        disturbance
    }
}
