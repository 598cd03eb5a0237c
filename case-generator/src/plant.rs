//! The bodies in motion, stepped at 10 us or finer.
//!
//! Electrical: `L di/dt = v - R i - Kb w - Vd sgn i`, implicit in i; the voltage drop as a soft
//! threshold. Mechanical: semi-implicit in speed, trapezoidal in angle, one body or two; dry friction is
//! a bristle law, contacts are springs with dampers, so nothing here ever sticks or strikes ideally.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::friction::Bristles;
use crate::hidden::{Contact, Hidden};
use crate::oddity::{AtWork, Deed, Seen};
use crate::wander::Wander;

/// Largest step in s.
pub const STEP_S: f64 = 10e-6;
/// How often slow things (wander, heat, oddities) are brought up to date, in s.
const SLOW_S: f64 = 100e-6;
/// Bend of plain dry friction's bristles in counts.
const DRY_BEND_COUNTS: f64 = 0.01;
/// The same where friction holds more than it brakes: bristles that let go at 0.999 of what they hold have moved seven times their bend by
/// then. From a hundredth of a count to a ten-thousandth what that leaves falls from 1.18 to 0.36 counts RMS over 15 s (seed 73, wander 0.31).
const HOLDING_BEND_COUNTS: f64 = 0.0001;
/// Frequency in Hz at which two bodies ring on a stiff flank or on a clutch that holds.
const CONTACT_HZ: f64 = 300.0;

/// How much load and friction wander in a run: sigma relative to Tf, and correlation time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WanderLevel {
    pub(crate) sigma: f64,
    pub(crate) time_s: f64,
}

#[derive(Debug, Clone, Copy)]
struct Body {
    angle: f64,
    speed: f64,
    inertia: f64,
    /// Share of the friction.
    share: f64,
    bristles: Bristles,
    /// Whether dry friction has been broken away since it last held.
    slides: bool,
}

impl Body {
    /// The level of dry friction where it holds more than it brakes: bristles that have bent as far as they can slide from there, and
    /// hold again where the body turns back.
    fn level(&mut self, holding_nm: f64, sliding_nm: f64) -> f64 {
        if holding_nm <= sliding_nm {
            return sliding_nm;
        }
        let bent = self.bristles.force().abs();
        if self.slides {
            self.slides = self.speed * self.bristles.force() > 0.0;
        } else {
            self.slides = bent > 0.999 * holding_nm * self.share;
        }
        if self.slides { sliding_nm } else { holding_nm }
    }

    /// Accelerates the body by `torque` less its friction.
    fn step(&mut self, torque: f64, sliding_nm: f64, viscous: f64, h: f64) {
        let dry = self.bristles.step(self.speed, sliding_nm * self.share, h);
        let per_inertia = h / self.inertia;
        let before = self.speed;
        self.speed =
            (before + per_inertia * (torque - dry)) / (1.0 + per_inertia * viscous * self.share);
        self.angle += 0.5 * h * (before + self.speed);
    }
}

/// Torque of the coupling for a twist and its rate.
#[derive(Debug, Clone, Copy)]
enum Link {
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
        /// Twist at which the rollers begin to grip: it follows a load that overruns.
        seat: f64,
        stiffness: f64,
        damping: f64,
    },
}

impl Link {
    fn new(contact: Contact, reduced_inertia: f64) -> Self {
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

    fn torque(&mut self, twist: f64, rate: f64, h: f64) -> f64 {
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

/// A motor with what it hides, at work.
pub(crate) struct Plant<'a> {
    hidden: &'a Hidden,
    rotor: Body,
    load: Option<(Body, Link)>,
    current: f64,
    heat_w: f64,
    motor_torque: f64,
    load_wander: Wander,
    friction_wander: Wander,
    wander_now: (f64, f64),
    oddity: Option<AtWork>,
    deed: Deed,
    command: f64,
    now_s: f64,
    slow_done_s: f64,
    start_fraction: f64,
    /// Last whole count under the shaft, for encoders that lose edges.
    edge: i64,
    counted: i64,
    /// Angle whose edges an encoder that loses some by their rate has kept, and what a filter behind it says, with its speed.
    kept_angle: f64,
    filtered: (f64, f64),
    wander_rng: Pcg64Mcg,
    /// Apart from the wander's, so that an effect's dice leave the wander as it is.
    effect_rng: Pcg64Mcg,
}

impl<'a> Plant<'a> {
    /// At rest at angle 0, the encoder's edge `start_fraction` of a count behind.
    pub(crate) fn new(
        hidden: &'a Hidden,
        level: WanderLevel,
        start_fraction: f64,
        seed: u64,
    ) -> Self {
        let m = &hidden.motor;
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let sigma = level.sigma * m.coulomb_friction_nm;
        let load_wander = Wander::new(sigma, level.time_s, &mut rng);
        let friction_wander = Wander::new(sigma, level.time_s, &mut rng);
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
            (load, Link::new(coupling.contact, reduced))
        });
        let mut plant = Self {
            hidden,
            rotor,
            load,
            current: 0.0,
            heat_w: 0.0,
            motor_torque: 0.0,
            load_wander,
            friction_wander,
            wander_now: (0.0, 0.0),
            oddity: hidden.oddity.map(AtWork::new),
            deed: Deed::none(0.0),
            command: 0.0,
            now_s: 0.0,
            slow_done_s: 0.0,
            start_fraction,
            edge: 0,
            counted: 0,
            kept_angle: 0.0,
            filtered: (0.0, 0.0),
            wander_rng: rng,
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

    /// Sets two bodies turning against each other, without momentum of the whole.
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

    /// Speed of the shaft that carries the encoder, in rad/s.
    pub(crate) fn speed(&self) -> f64 {
        self.encoder_body().speed
    }

    /// Angle that the encoder reads, before it is counted, in rad.
    pub(crate) fn read_angle(&self) -> f64 {
        if self.hidden.filter_s > 0.0 {
            return self.filtered.0;
        }
        if self.hidden.half_lost_hz.is_finite() {
            return self.kept_angle;
        }
        self.seen_angle()
    }

    /// The angle on the encoder's disc in rad.
    fn seen_angle(&self) -> f64 {
        let angle = self.encoder_body().angle + self.deed.angle_offset_rad;
        angle + self.hidden.eccentricity.at(angle) - self.hidden.eccentricity.at(0.0)
    }

    /// Counts since the start, as the board has them.
    pub(crate) fn counts(&self) -> i64 {
        let counted = if self.loses_edges() {
            self.counted
        } else {
            self.whole_count()
        };
        counted + self.deed.count_offset
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
        // An oddity of the command or the driver answers at once.
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

    /// What changes slowly, `dt` seconds on.
    fn slow_step(&mut self, dt: f64) {
        if dt > 0.0 {
            self.wander_now = (
                self.load_wander.step(dt, &mut self.wander_rng),
                self.friction_wander.step(dt, &mut self.wander_rng),
            );
            let power = self.current * self.current * self.hidden.motor.resistance_ohm;
            let kept = (-dt / self.hidden.thermal_time_s).exp();
            self.heat_w = kept * self.heat_w + (1.0 - kept) * power;
        }
        let seen = Seen {
            t_s: self.now_s,
            command_v: self.command,
            angle_rad: self.encoder_body().angle,
            speed_rad_s: self.speed(),
            heat_w: self.current * self.current * self.hidden.motor.resistance_ohm,
            torque_nm: self.motor_torque,
            friction_nm: self.hidden.motor.coulomb_friction_nm,
        };
        self.deed = match &mut self.oddity {
            Some(oddity) => oddity.step(seen, dt, &mut self.effect_rng),
            None => Deed::none(self.command),
        };
    }

    fn step(&mut self, h: f64) {
        let x = self.hidden;
        let m = &x.motor;
        // Command and driver.
        let mut u = self.deed.command_v;
        if u.abs() <= x.dead_zone_v {
            u = 0.0;
        }
        let (zone_ahead, zone_astern) = x.dead_zones_v;
        if u < zone_ahead && u > -zone_astern {
            u = 0.0;
        }
        let duty = u / m.supply_v;
        // Winding.
        let mut mean_current = None;
        let stall_w = m.supply_v * m.supply_v / m.resistance_ohm;
        let magnet = 1.0 - x.magnet_drop * self.heat_w / stall_w;
        let ripple = magnet * (1.0 + x.torque_ripple.at(self.rotor.angle));
        if self.deed.is_open || (x.coasts && u == 0.0) {
            self.current = 0.0;
        } else {
            let resistance = m.resistance_ohm * (1.0 + x.resistance_rise_per_w * self.heat_w)
                + duty * duty * x.source_resistance_ohm;
            let emf = m.back_emf_v_s_per_rad * ripple * self.rotor.speed;
            let per_l = h / m.inductance_h;
            let denominator = 1.0 + per_l * resistance;
            let lame = if u > 0.0 {
                1.0 + x.gain_asymmetry
            } else {
                1.0 - x.gain_asymmetry
            };
            let volts = lame * x.gain * self.deed.supply_factor * u;
            mean_current = self.pulse(volts, emf, resistance, duty, h);
            let free = (self.current + per_l * (volts - emf)) / denominator;
            let further_v = if free > 0.0 { x.drops_v.0 } else { x.drops_v.1 };
            let threshold = per_l * (x.drop_v + further_v) / denominator;
            let kept = (free.abs() - threshold).max(0.0);
            if mean_current.is_none() {
                self.current = kept.min(x.current_limit_a).copysign(free);
            }
        }
        let seen = self.seen_angle();
        let current = mean_current.unwrap_or(self.current);
        self.motor_torque = m.torque_constant_nm_per_a * ripple * current;
        let rotor_torque = self.motor_torque + x.cogging.at(self.rotor.angle);
        // Load, on the far side where there are two bodies.
        match &mut self.load {
            None => {
                let against = self.wander_now.0 + load_torque(x, &self.rotor) - self.deed.load_nm;
                let sliding = sliding_nm(
                    x,
                    &self.deed,
                    self.wander_now.1,
                    self.rotor.speed,
                    self.motor_torque,
                );
                let sliding = self.rotor.level(holding_nm(x, sliding), sliding);
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
                let against = self.wander_now.0 + load_torque(x, load) - self.deed.load_nm;
                for (body, torque) in [
                    (&mut self.rotor, rotor_torque - through),
                    (load, through - against),
                ] {
                    let sliding = sliding_nm(
                        x,
                        &self.deed,
                        self.wander_now.1,
                        body.speed,
                        self.motor_torque,
                    );
                    let sliding = body.level(holding_nm(x, sliding), sliding);
                    body.step(torque, sliding, viscous(x, body.speed), h);
                }
            }
        }
        self.remember(self.seen_angle() - seen, h);
        if self.loses_edges() {
            self.count_edges();
        }
    }

    /// The current through the pulses of a bridge whose current decays through diodes, and its mean over the step; none of other bridges.
    ///
    /// Within a pulse, between pulses, and while nothing flows, the winding is a resistance, an inductance and a constant voltage: solved
    /// exactly from one switching instant to the next.
    fn pulse(&mut self, volts: f64, emf: f64, resistance: f64, duty: f64, h: f64) -> Option<f64> {
        let pulses = self.hidden.pulses?;
        let m = &self.hidden.motor;
        let (s, duty) = (duty.signum(), duty.abs().min(1.0));
        let (on_v, against_v) = (volts * s / duty, emf * s);
        let rate = resistance / m.inductance_h;
        let period = pulses.period_ratio * m.inductance_h / m.resistance_ohm;
        let mut current = self.current * s;
        let (mut left, mut passed) = (h, 0.0);
        let mut place = (self.now_s / period).fract() * period;
        while left > 0.0 {
            let is_on = place < duty * period;
            let edge = if is_on { duty * period } else { period };
            let mut dt = left.min(edge - place).max(f64::EPSILON * period);
            // What the terminals show: the supply, what a diode lets through, or the back EMF.
            let terminal_v = if is_on || current < 0.0 || against_v > on_v {
                on_v
            } else if pulses.into_supply {
                -on_v
            } else {
                0.0
            };
            let goal = (terminal_v - against_v) / resistance;
            let dry = !is_on && current * goal < 0.0;
            let blocked = !is_on && current == 0.0 && goal < 0.0 && against_v <= on_v;
            if dry {
                // The diode blocks from where the current is 0.
                dt = dt.min((1.0 - current / goal).ln() / rate);
            }
            if blocked {
                current = 0.0;
            } else {
                let fade = (-rate * dt).exp();
                let next = goal + (current - goal) * fade;
                passed += goal * dt + (current - goal) * (1.0 - fade) / rate;
                current = if dry && next * goal >= -1e-12 * goal * goal {
                    0.0
                } else {
                    next
                };
            }
            left -= dt;
            place = if place + dt >= period {
                0.0
            } else {
                place + dt
            };
        }
        self.current = current * s;
        Some(passed / h * s)
    }

    /// Keeps a share of the angle passed by its edge rate, and filters its speed.
    fn remember(&mut self, moved: f64, h: f64) {
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

    /// Moves the board's count by the edges passed, less those lost.
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

/// Torque of drag and gravity against positive rotation.
fn load_torque(x: &Hidden, body: &Body) -> f64 {
    x.drag * body.speed * body.speed.abs() + x.gravity.at(body.angle) + x.load_nm
}

/// Viscous coefficient in this direction.
fn viscous(x: &Hidden, speed: f64) -> f64 {
    x.motor.viscous_friction_nm_s_per_rad * (1.0 + x.viscous_asymmetry * speed.signum())
}

/// What dry friction holds, of both bodies together, where it brakes with `sliding_nm`.
fn holding_nm(x: &Hidden, sliding_nm: f64) -> f64 {
    sliding_nm + (x.static_nm - x.motor.coulomb_friction_nm).max(0.0)
}

/// Dry friction that steady sliding at this speed meets, of both bodies together.
fn sliding_nm(x: &Hidden, deed: &Deed, wander: f64, speed: f64, motor_torque: f64) -> f64 {
    let mut sliding = x.motor.coulomb_friction_nm * deed.friction_factor;
    if x.friction_asymmetry != 0.0 {
        // Which way it would go decides at rest.
        let way = if speed.abs() > 1e-4 {
            speed
        } else {
            motor_torque
        };
        sliding *= 1.0 + x.friction_asymmetry * way.signum();
    }
    if x.stribeck_nm > 0.0 {
        let ratio = speed / x.stribeck_speed_rad_s;
        sliding += x.stribeck_nm * (-ratio * ratio).exp();
    }
    let fraction = if motor_torque * speed >= 0.0 {
        x.driving_fraction
    } else {
        x.driven_fraction
    };
    (sliding + fraction * motor_torque.abs() + deed.extra_friction_nm + wander).max(0.0)
}
