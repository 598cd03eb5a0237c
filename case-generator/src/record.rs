//! The board of a case: plays a profile, samples the encoder, writes a run file.
//!
//! A board's ticks are a few microseconds late, which its device clock shows; samples reach the host about a
//! millisecond later. A case's timing effect (jitter, clock error, stalls) is not visible in the device clock.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::motor::normal;
use crate::plant::Plant;
use crate::profile::Profile;
use crate::random_torque::RandomTorque;
use crate::true_motor::TrueMotor;
use crate::unmodelled::Unmodelled;

/// Lateness of a tick in s (one sigma, one-sided).
const TICK_LATENESS_S: f64 = 3e-6;
/// Mean delay between a sample and its arrival on the host in s, beyond the fixed part.
const HOST_DELAY_S: f64 = 0.4e-3;

/// One recorded run.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseRun {
    /// Commands.
    pub profile: Profile,
    /// Nominal resolution, as in the header.
    pub counts_per_rev: f64,
    /// Supply in V as in the header.
    pub supply_v: f64,
    /// Device time in s of each sample, from the first.
    pub t_s: Vec<f64>,
    /// Arrival time of each sample in s, on the host's clock.
    pub host_t_s: Vec<f64>,
    /// Encoder counts.
    pub counts: Vec<i64>,
}

impl CaseRun {
    /// The run as a `motorlab-run/1` file.
    pub fn to_csv(&self) -> String {
        let mut text = format!(
            "# format = \"motorlab-run/1\"\n# sample_time_s = {:?}\n# counts_per_rev = {:?}\n\
             # supply_v = {:?}\n# profile = \"{}\"\n# complete = true\n\
             seq,t_s,host_t_s,command_v,counts\n",
            self.profile.sample_time_s, self.counts_per_rev, self.supply_v, self.profile.name
        );
        for (k, counts) in self.counts.iter().enumerate() {
            text += &format!(
                "{k},{:.6},{:.6},{:.3},{counts}\n",
                self.t_s[k], self.host_t_s[k], self.profile.command_v[k]
            );
        }
        text
    }
}

/// Conditions of one recording: the random torque, and the seed of all random numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Conditions {
    pub(crate) random_torque: RandomTorque,
    pub(crate) seed: u64,
}

/// A recording with the true angle at the encoder in rad at each sample.
pub(crate) struct Recording {
    pub(crate) run: CaseRun,
    pub(crate) angle_rad: Vec<f64>,
}

#[derive(Debug, Clone, Copy)]
enum Event {
    /// From now on this command is in force.
    Command(f64),
    Sample,
}

/// Plays the profile on a motor at rest. `header_counts_per_rev` is the encoder's resolution in the header.
pub(crate) fn record(
    hidden: &TrueMotor,
    profile: &Profile,
    header_counts_per_rev: f64,
    conditions: Conditions,
) -> Recording {
    let mut rng = Pcg64Mcg::seed_from_u64(conditions.seed ^ 0x626f_6172_6400_0001);
    let start_fraction = rng.random_range(0.0..1.0);
    let host_offset = rng.random_range(0.0..50.0);
    let host_rate = 1.0 + 20e-6 * normal(&mut rng);
    let real_sample_time = profile.sample_time_s * (1.0 + hidden.clock_error);
    let stalls = match hidden.unmodelled {
        Some(Unmodelled::ClockStall { rate_hz, mean_s }) => Some((rate_hz, mean_s)),
        _ => None,
    };

    let mut stall_rng = Pcg64Mcg::seed_from_u64(conditions.seed ^ 0x7374_616c_6c00_0001);
    let mut stalled_s = 0.0;
    let mut t_s = Vec::with_capacity(profile.command_v.len());
    let mut host_t_s = Vec::with_capacity(profile.command_v.len());
    let mut events = Vec::with_capacity(2 * profile.command_v.len());
    for (k, &command) in profile.command_v.iter().enumerate() {
        let late = (TICK_LATENESS_S * normal(&mut rng)).abs();
        if let Some((rate_hz, mean_s)) = stalls
            && stall_rng.random_bool((rate_hz * real_sample_time).min(1.0))
        {
            stalled_s -= mean_s * (1.0 - stall_rng.random_range(0.0..1.0_f64)).ln();
        }
        let tick = k as f64 * real_sample_time + stalled_s + late;
        let delta = hidden.jitter_s * rng.random_range(0.0..1.0);
        events.push((tick + delta, Event::Sample));
        let given = (tick + hidden.delay_s - hidden.ahead_s).max(0.0);
        events.push((given, Event::Command(command)));
        // Microseconds of the device's clock.
        t_s.push(((k as f64 * profile.sample_time_s + late) * 1e6).round() / 1e6);
        let delay = 0.7e-3 - HOST_DELAY_S * (1.0 - rng.random_range(0.0..1.0_f64)).ln();
        host_t_s.push(host_offset + host_rate * (tick + delta + delay));
    }
    // Stable: a sample at the time of a command is read before the command is set.
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    for k in 1..host_t_s.len() {
        host_t_s[k] = host_t_s[k].max(host_t_s[k - 1]);
    }
    let origin = t_s.first().copied().unwrap_or(0.0);
    for t in &mut t_s {
        *t -= origin;
    }

    let mut plant = Plant::new(
        hidden,
        conditions.random_torque,
        start_fraction,
        conditions.seed,
    );
    let mut counts = Vec::with_capacity(t_s.len());
    let mut angle_rad = Vec::with_capacity(t_s.len());
    let mut in_force = 0.0;
    for (at, event) in events {
        if counts.len() == t_s.len() {
            break;
        }
        plant.hold(in_force, at);
        match event {
            Event::Command(command) => in_force = command,
            Event::Sample => {
                counts.push(plant.counts());
                angle_rad.push(plant.read_angle());
            }
        }
    }
    Recording {
        run: CaseRun {
            profile: profile.clone(),
            counts_per_rev: header_counts_per_rev,
            supply_v: hidden.motor.supply_v,
            t_s,
            host_t_s,
            counts,
        },
        angle_rad,
    }
}
