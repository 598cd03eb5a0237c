//! The plant: voltage in, encoder counts out, stepped at 10 us or finer.
//!
//! Electrical: `L di/dt = v - R i - Kb w - Vd sgn i`, implicit in i; the voltage drop as a soft threshold.
//! Mechanical: semi-implicit in speed, trapezoidal in angle, one body or two; dry friction is a bristle model,
//! contacts are springs with dampers, so that there is neither ideal sticking nor ideal impact.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::body::Body;
use crate::freewheel::WindingStep;
use crate::friction::Bristles;
use crate::loads::{holding_nm, load_torque, sliding_nm, viscous};
use crate::random_torque::{OrnsteinUhlenbeck, RandomTorque};
use crate::transmission::Transmission;
use crate::true_motor::TrueMotor;
use crate::unmodelled::{Disturbance, PlantState, UnmodelledState};

/// Largest step in s.
pub const STEP_S: f64 = 10e-6;
/// Update period in s of slow quantities (random torque, heat, unmodelled effects).
const SLOW_S: f64 = 100e-6;
/// Deflection of dry friction's bristles in counts.
const DRY_BEND_COUNTS: f64 = 0.01;
/// The same if static friction exceeds Coulomb friction: bristles that slide at 0.999 of their level have then moved
/// by seven times their deflection. From a hundredth of a count to a ten-thousandth the remaining error decreases
/// from 1.18 to 0.36 counts RMS over 15 s (seed 73, random torque 0.31).
const HOLDING_BEND_COUNTS: f64 = 0.0001;

/// A motor with its hidden effects during a recording.
pub(crate) struct Plant<'a> {
    hidden: &'a TrueMotor,
    rotor: Body,
    load: Option<(Body, Transmission)>,
    current: f64,
    heat_w: f64,
    motor_torque: f64,
    load_noise: OrnsteinUhlenbeck,
    friction_noise: OrnsteinUhlenbeck,
    noise_now: (f64, f64),
    unmodelled: Option<UnmodelledState>,
    disturbance: Disturbance,
    command: f64,
    now_s: f64,
    slow_done_s: f64,
    start_fraction: f64,
    /// Last integral count of the shaft, for encoders that lose edges.
    edge: i64,
    counted: i64,
    /// Angle after the loss of edges by their rate, and after the filter, with its speed.
    kept_angle: f64,
    filtered: (f64, f64),
    noise_rng: Pcg64Mcg,
    /// Separate from that of the random torque, which is therefore independent of effects with random numbers.
    effect_rng: Pcg64Mcg,
}

impl<'a> Plant<'a> {
    /// At rest at angle 0, `start_fraction` of a count after an encoder edge.
    pub(crate) fn new(
        hidden: &'a TrueMotor,
        level: RandomTorque,
        start_fraction: f64,
        seed: u64,
    ) -> Self {
        let m = &hidden.motor;
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let sigma = level.sigma * m.coulomb_friction_nm;
        let load_noise = OrnsteinUhlenbeck::new(sigma, level.time_s, &mut rng);
        let friction_noise = OrnsteinUhlenbeck::new(sigma, level.time_s, &mut rng);
        let load_fraction = hidden.coupling.map_or(0.0, |c| c.load_fraction);
        let load_share = hidden.coupling.map_or(0.0, |c| c.load_friction_share);
        let body = |mass: f64, share: f64| {
            let inertia = mass * m.inertia_kg_m2;
            let (bend, damping_ratio) = if hidden.break_in_rad > 0.0 {
                (hidden.break_in_rad, 0.1)
            } else if hidden.static_nm > 0.0 {
                (HOLDING_BEND_COUNTS * m.count_rad(), 0.7)
            } else {
                (DRY_BEND_COUNTS * m.count_rad(), 0.7)
            };
            let torque = share * m.coulomb_friction_nm;
            Body {
                angle: 0.0,
                speed: 0.0,
                inertia,
                share,
                bristles: Bristles::new(torque, bend, inertia, damping_ratio),
                slides: false,
            }
        };
        let rotor = body(1.0 - load_fraction, 1.0 - load_share);
        let load = hidden.coupling.map(|coupling| {
            let load = body(load_fraction, load_share);
            let reduced = rotor.inertia * load.inertia / (rotor.inertia + load.inertia);
            (load, Transmission::new(coupling.contact, reduced))
        });
        let mut plant = Self {
            hidden,
            rotor,
            load,
            current: 0.0,
            heat_w: 0.0,
            motor_torque: 0.0,
            load_noise,
            friction_noise,
            noise_now: (0.0, 0.0),
            unmodelled: hidden.unmodelled.map(UnmodelledState::new),
            disturbance: Disturbance::none(0.0),
            command: 0.0,
            now_s: 0.0,
            slow_done_s: 0.0,
            start_fraction,
            edge: 0,
            counted: 0,
            kept_angle: 0.0,
            filtered: (0.0, 0.0),
            noise_rng: rng,
            effect_rng: Pcg64Mcg::seed_from_u64(seed ^ 0x6566_6665_6374_0001),
        };
        plant.edge = plant.whole_count();
        plant.counted = plant.edge;
        plant
    }

    /// Time since the start in s.
    #[cfg(test)]
    pub(crate) fn now(&self) -> f64 {
        self.now_s
    }

    /// Gives the two bodies opposite speeds without total momentum.
    #[cfg(test)]
    pub(crate) fn kick(&mut self, speed: f64) {
        if let Some((load, _)) = &mut self.load {
            load.speed = speed;
            self.rotor.speed = -speed * load.inertia / self.rotor.inertia;
        }
    }

    /// Angle by which the rotor leads the load in rad.
    #[cfg(test)]
    pub(crate) fn twist(&self) -> f64 {
        self.load
            .map_or(0.0, |(load, _)| self.rotor.angle - load.angle)
    }

    pub(crate) fn speed(&self) -> f64 {
        self.encoder_body().speed
    }

    /// Angle that the encoder reads before quantization, in rad.
    pub(crate) fn read_angle(&self) -> f64 {
        if self.hidden.filter_s > 0.0 {
            return self.filtered.0;
        }
        if self.hidden.half_lost_hz.is_finite() {
            return self.kept_angle;
        }
        self.disc_angle()
    }

    fn disc_angle(&self) -> f64 {
        let angle = self.encoder_body().angle + self.disturbance.angle_offset_rad;
        angle + self.hidden.eccentricity.at(angle) - self.hidden.eccentricity.at(0.0)
    }

    /// Counts since the start, as the board has them.
    pub(crate) fn counts(&self) -> i64 {
        let counted = if self.loses_edges() {
            self.counted
        } else {
            self.whole_count()
        };
        counted + self.disturbance.count_offset
    }

    fn encoder_body(&self) -> &Body {
        match (&self.load, self.hidden.coupling) {
            (Some((load, _)), Some(coupling)) if coupling.encoder_on_load => load,
            _ => &self.rotor,
        }
    }

    fn loses_edges(&self) -> bool {
        self.hidden.miss_probability > 0.0 || self.hidden.max_edge_rate_hz.is_finite()
    }

    fn whole_count(&self) -> i64 {
        (self.read_angle() / self.hidden.motor.count_rad() + self.start_fraction).floor() as i64
    }

    /// Holds a command until the time given.
    pub(crate) fn hold(&mut self, command: f64, until_s: f64) {
        self.command = command;
        // An unmodelled effect of command or driver acts immediately.
        self.slow_step(0.0);
        let span = until_s - self.now_s;
        if span <= 0.0 {
            return;
        }
        let steps = (span / STEP_S).ceil().max(1.0);
        let h = span / steps;
        let start = self.now_s;
        for k in 0..steps as u64 {
            self.now_s = start + k as f64 * h;
            let since = self.now_s - self.slow_done_s;
            if since >= SLOW_S {
                self.slow_step(since);
                self.slow_done_s = self.now_s;
            }
            self.step(h);
        }
        self.now_s = until_s;
    }

    /// Updates the slow states by `dt` seconds.
    fn slow_step(&mut self, dt: f64) {
        if dt > 0.0 {
            self.noise_now = (
                self.load_noise.step(dt, &mut self.noise_rng),
                self.friction_noise.step(dt, &mut self.noise_rng),
            );
            let power = self.current * self.current * self.hidden.motor.resistance_ohm;
            let kept = (-dt / self.hidden.thermal_time_s).exp();
            self.heat_w = kept * self.heat_w + (1.0 - kept) * power;
        }
        let state = PlantState {
            t_s: self.now_s,
            command_v: self.command,
            angle_rad: self.encoder_body().angle,
            speed_rad_s: self.speed(),
            heat_w: self.current * self.current * self.hidden.motor.resistance_ohm,
            torque_nm: self.motor_torque,
            friction_nm: self.hidden.motor.coulomb_friction_nm,
        };
        self.disturbance = match &mut self.unmodelled {
            Some(unmodelled) => unmodelled.step(state, dt, &mut self.effect_rng),
            None => Disturbance::none(self.command),
        };
    }

    fn step(&mut self, h: f64) {
        let x = self.hidden;
        let m = &x.motor;
        // Command and driver.
        let mut u = self.disturbance.command_v;
        if u.abs() <= x.dead_zone_v {
            u = 0.0;
        }
        let (zone_forward, zone_backward) = x.dead_zones_v;
        if u < zone_forward && u > -zone_backward {
            u = 0.0;
        }
        let duty = u / m.supply_v;
        // Winding.
        let mut mean_current = None;
        let stall_w = m.supply_v * m.supply_v / m.resistance_ohm;
        let magnet = 1.0 - x.magnet_drop * self.heat_w / stall_w;
        let ripple = magnet * (1.0 + x.torque_ripple.at(self.rotor.angle));
        if self.disturbance.is_open || (x.coasts && u == 0.0) {
            self.current = 0.0;
        } else {
            let resistance = m.resistance_ohm * (1.0 + x.resistance_rise_per_w * self.heat_w)
                + duty * duty * x.source_resistance_ohm;
            let emf = m.back_emf_v_s_per_rad * ripple * self.rotor.speed;
            let per_l = h / m.inductance_h;
            let denominator = 1.0 + per_l * resistance;
            let direction_gain = if u > 0.0 {
                1.0 + x.gain_asymmetry
            } else {
                1.0 - x.gain_asymmetry
            };
            let volts = direction_gain * x.gain * self.disturbance.supply_factor * u;
            let winding = WindingStep {
                volts,
                emf,
                resistance,
                duty,
                now_s: self.now_s,
                h,
            };
            if let Some(pulses) = x.pulses {
                let (current, mean) = winding.freewheel(pulses, m, self.current);
                self.current = current;
                mean_current = Some(mean);
            } else {
                let free = (self.current + per_l * (volts - emf)) / denominator;
                let further_v = if free > 0.0 { x.drops_v.0 } else { x.drops_v.1 };
                let threshold = per_l * (x.drop_v + further_v) / denominator;
                let kept = (free.abs() - threshold).max(0.0);
                self.current = kept.min(x.current_limit_a).copysign(free);
            }
        }
        let angle_before = self.disc_angle();
        let current = mean_current.unwrap_or(self.current);
        self.motor_torque = m.torque_constant_nm_per_a * ripple * current;
        let rotor_torque = self.motor_torque + x.cogging.at(self.rotor.angle);
        // Load, on the second body if there are two.
        match &mut self.load {
            None => {
                let against =
                    self.noise_now.0 + load_torque(x, &self.rotor) - self.disturbance.load_nm;
                let sliding = sliding_nm(
                    x,
                    &self.disturbance,
                    self.noise_now.1,
                    self.rotor.speed,
                    self.motor_torque,
                );
                let sliding = self.rotor.friction_level(holding_nm(x, sliding), sliding);
                self.rotor.step(
                    rotor_torque - against,
                    sliding,
                    viscous(x, self.rotor.speed),
                    h,
                );
            }
            Some((load, link)) => {
                let twist = self.rotor.angle - load.angle;
                let through = link.torque(twist, self.rotor.speed - load.speed, h);
                let against = self.noise_now.0 + load_torque(x, load) - self.disturbance.load_nm;
                for (body, torque) in [
                    (&mut self.rotor, rotor_torque - through),
                    (load, through - against),
                ] {
                    let sliding = sliding_nm(
                        x,
                        &self.disturbance,
                        self.noise_now.1,
                        body.speed,
                        self.motor_torque,
                    );
                    let sliding = body.friction_level(holding_nm(x, sliding), sliding);
                    body.step(torque, sliding, viscous(x, body.speed), h);
                }
            }
        }
        self.update_sensor(self.disc_angle() - angle_before, h);
        if self.loses_edges() {
            self.count_edges();
        }
    }

    /// Applies the loss of edges by their rate, and filters the speed.
    fn update_sensor(&mut self, moved: f64, h: f64) {
        let x = self.hidden;
        let mut kept = moved;
        if x.half_lost_hz.is_finite() {
            let rate = (moved / h).abs() / x.motor.count_rad();
            kept = moved / (1.0 + (rate / x.half_lost_hz).powf(x.loss_exponent));
            self.kept_angle += kept;
        }
        if x.filter_s > 0.0 {
            let (angle, speed) = self.filtered;
            let next = (speed + kept / x.filter_s) / (1.0 + h / x.filter_s);
            self.filtered = (angle + 0.5 * h * (speed + next), next);
        }
    }

    /// Updates the board's count by the passed edges, less the lost ones.
    fn count_edges(&mut self) {
        let now = self.whole_count();
        let passed = now - self.edge;
        self.edge = now;
        let too_fast =
            self.speed().abs() / self.hidden.motor.count_rad() > self.hidden.max_edge_rate_hz;
        for _ in 0..passed.abs() {
            let lost = too_fast
                || (self.hidden.miss_probability > 0.0
                    && self
                        .effect_rng
                        .random_bool(self.hidden.miss_probability.min(1.0)));
            if !lost {
                self.counted += passed.signum();
            }
        }
    }
}
