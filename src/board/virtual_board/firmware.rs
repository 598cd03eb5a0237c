//! The virtual board's firmware, without I/O and without a clock.
//!
//! It responds to host messages and takes samples when called. Sample `k` is taken at `k TS` of the board's crystal;
//! the bench runs in true time, `k TS / (1 + ppm 1e-6)`. The command of sample `k` is set when it is taken and held
//! until sample `k + 1`. On a bench with a logging delay `To` the motor is ahead of its samples: the board applies at
//! `t` the profile's command of `t + To`.

use firmware_protocol::{
    BoardFields, BoardMessage, EndReason, Hello, HostMessage, PROTOCOL_VERSION, ProfileSegment,
    Refusal, Sample, SampleFlags, ShortText, profile_crc,
};

use crate::board::Bench;

/// Most segments of a profile: the memory of an Uno.
const MAX_SEGMENTS: u16 = 128;
/// Shortest sample time of an Uno in microseconds.
const SHORTEST_SAMPLE_TIME_US: u16 = 1000;
/// Board time between two recordings in microseconds.
const PAUSE_US: u64 = 5_000_000;

/// Properties of this board.
#[derive(Debug, Clone, PartialEq)]
pub struct FirmwareOptions {
    /// Rate error of its crystal in parts per million; positive if it is fast.
    pub clock_ppm: f64,
    /// Its `micros()` at power-on: near 2^32 it wraps early.
    pub micros_at_start: u32,
    /// Its counter has 16 bits.
    pub counts_16_bit: bool,
    /// Changes with each reset.
    pub boot_id: u32,
    /// Its name.
    pub name: String,
}

impl Default for FirmwareOptions {
    fn default() -> Self {
        Self {
            clock_ppm: 0.0,
            micros_at_start: 0,
            counts_16_bit: false,
            boot_id: 1,
            name: "virtual".to_owned(),
        }
    }
}

/// Rounding tolerance for a delay of whole samples, in samples.
const WHOLE: f64 = 1e-6;

#[derive(Debug, Clone)]
struct Recording {
    /// Requested samples; 0 is unlimited.
    samples: u32,
    /// Samples taken.
    taken: u32,
    /// Frames that did not fit the line's buffer.
    dropped: u32,
    /// A frame was dropped since the last one sent.
    just_dropped: bool,
    segment: usize,
    samples_in_segment: u32,
}

#[derive(Debug)]
pub(super) struct Firmware<B> {
    bench: B,
    options: FirmwareOptions,
    sample_time_us: u32,
    profile: Vec<ProfileSegment>,
    announced: Option<(u16, u16)>,
    recording: Option<Recording>,
    last_end: Option<BoardMessage>,
    /// Board time at the start of the current recording.
    started_us: u64,
    /// Board time of the last sample since power-on.
    now_us: u64,
    command_v: f64,
    /// The previous command, and the true time in s up to which it is in force.
    until: Option<(f64, f64)>,
}

impl<B: Bench> Firmware<B> {
    pub(super) fn new(bench: B, options: FirmwareOptions) -> Self {
        Self {
            bench,
            options,
            sample_time_us: 30_000,
            profile: Vec::new(),
            announced: None,
            recording: None,
            last_end: None,
            started_us: 0,
            now_us: 0,
            command_v: 0.0,
            until: None,
        }
    }

    /// State after a reset: uploads are deleted, the boot id is new.
    pub(super) fn reset(&mut self) {
        self.options.boot_id = self.options.boot_id.wrapping_add(1);
        self.sample_time_us = 30_000;
        self.profile.clear();
        self.announced = None;
        self.recording = None;
        self.last_end = None;
        self.command_v = 0.0;
        self.until = None;
    }

    pub(super) fn hello(&self) -> BoardMessage {
        BoardMessage::Hello(Hello {
            protocol_version: PROTOCOL_VERSION,
            firmware_version: (1, 0),
            boot_id: self.options.boot_id,
            sample_time_us: self.sample_time_us,
            shortest_sample_time_us: SHORTEST_SAMPLE_TIME_US,
            counts_per_rev: self.bench.counts_per_rev().round() as u32,
            supply_mv: (self.bench.supply_v() * 1000.0).round() as u16,
            fields: BoardFields {
                counts_16_bit: self.options.counts_16_bit,
                ..BoardFields::default()
            },
            max_segments: MAX_SEGMENTS,
            name: ShortText::new(self.options.name.as_bytes()),
        })
    }

    pub(super) fn is_recording(&self) -> bool {
        self.recording.is_some()
    }

    /// True time of the next sample in microseconds since the start of the recording.
    pub(super) fn next_sample_true_us(&self) -> Option<f64> {
        let recording = self.recording.as_ref()?;
        let board_us = f64::from(recording.taken) * f64::from(self.sample_time_us);
        Some(board_us / (1.0 + self.options.clock_ppm * 1e-6))
    }

    /// Response to a host message; ALIVE has none.
    pub(super) fn answer(&mut self, message: &HostMessage) -> Option<BoardMessage> {
        let of = message.kind();
        let outcome = match message {
            HostMessage::Identify => return Some(self.hello()),
            HostMessage::Alive => return None,
            HostMessage::Stop => return self.stop(EndReason::Stopped),
            _ if self.is_recording() => Err(Refusal::State),
            HostMessage::Configure { sample_time_us, .. } => self.configure(*sample_time_us),
            HostMessage::Profile { segments, crc } => self.announce(*segments, *crc),
            HostMessage::Chunk(chunk) => self.take_chunk(chunk.first, chunk.segments()),
            HostMessage::Start { samples } => self.start(*samples),
        };
        Some(match outcome {
            Ok(detail) => BoardMessage::Ack { of, detail },
            Err(reason) => BoardMessage::Nak { of, reason },
        })
    }

    fn configure(&mut self, sample_time_us: u32) -> Result<u16, Refusal> {
        if sample_time_us < u32::from(SHORTEST_SAMPLE_TIME_US) {
            return Err(Refusal::SampleTime);
        }
        self.sample_time_us = sample_time_us;
        Ok(0)
    }

    fn announce(&mut self, segments: u16, crc: u16) -> Result<u16, Refusal> {
        if segments > MAX_SEGMENTS {
            return Err(Refusal::ProfileTooLong);
        }
        self.profile.clear();
        self.announced = Some((segments, crc));
        Ok(0)
    }

    fn take_chunk(&mut self, first: u16, segments: &[ProfileSegment]) -> Result<u16, Refusal> {
        let (announced, crc) = self.announced.ok_or(Refusal::State)?;
        // A chunk repeated because its ACK was lost is accepted once.
        let known = usize::from(first);
        if known > self.profile.len() {
            return Err(Refusal::ChunkOrder);
        }
        self.profile.truncate(known);
        self.profile.extend_from_slice(segments);
        if self.profile.len() > usize::from(announced) {
            return Err(Refusal::ProfileTooLong);
        }
        let complete = self.profile.len() == usize::from(announced);
        if complete && profile_crc(self.profile.iter().copied()) != crc {
            self.profile.clear();
            return Err(Refusal::ProfileCrc);
        }
        Ok(self.profile.len() as u16)
    }

    fn start(&mut self, samples: u32) -> Result<u16, Refusal> {
        let uploaded = self
            .announced
            .is_none_or(|(announced, _)| usize::from(announced) == self.profile.len());
        if !uploaded {
            return Err(Refusal::ChunkOrder);
        }
        self.recording = Some(Recording {
            samples,
            taken: 0,
            dropped: 0,
            just_dropped: false,
            segment: 0,
            samples_in_segment: 0,
        });
        self.last_end = None;
        if self.now_us > 0 {
            // Between recordings the motor is off and comes to rest.
            self.now_us += PAUSE_US;
        }
        self.started_us = self.now_us;
        Ok(0)
    }

    /// Ends the recording, motor off; also the source of a repeated END.
    pub(super) fn stop(&mut self, reason: EndReason) -> Option<BoardMessage> {
        if let Some(recording) = self.recording.take() {
            self.command_v = 0.0;
            self.until = None;
            self.last_end = Some(BoardMessage::End {
                taken: recording.taken,
                dropped: recording.dropped,
                reason,
            });
        }
        Some(self.last_end.unwrap_or(BoardMessage::End {
            taken: 0,
            dropped: 0,
            reason,
        }))
    }

    /// Takes the due sample, sets the next command, and returns the END after the last sample.
    pub(super) fn take_sample(&mut self) -> Option<(BoardMessage, Option<BoardMessage>)> {
        let recording = self.recording.as_mut()?;
        let elapsed_us = u64::from(recording.taken) * u64::from(self.sample_time_us);
        self.now_us = self.started_us + elapsed_us;
        let true_s = self.now_us as f64 * 1e-6 / (1.0 + self.options.clock_ppm * 1e-6);
        if let Some((command_v, until_s)) = self.until.take() {
            self.bench.hold(command_v, until_s);
        }
        self.bench.hold(self.command_v, true_s);

        let asked_mv = recording.command_mv(&self.profile);
        let supply_mv = (self.bench.supply_v() * 1000.0).round() as i16;
        let volts = |mv: i16| f64::from(mv.clamp(-supply_mv, supply_mv)) * 1e-3;
        self.command_v = volts(asked_mv);
        let late_s = self.bench.notes_late_s();
        if late_s > 0.0 {
            let sample_time_s = f64::from(self.sample_time_us) * 1e-6;
            let ahead = (late_s / sample_time_s - WHOLE).ceil().max(1.0);
            let later_s = ahead * sample_time_s - late_s;
            let sample = u64::from(recording.taken) + ahead as u64;
            if later_s > WHOLE * sample_time_s {
                let before_v = volts(command_at(&self.profile, sample - 1));
                self.until = Some((before_v, true_s + later_s));
            }
            self.command_v = volts(command_at(&self.profile, sample));
        }
        let counts = self.bench.counts();
        let sample = Sample {
            sequence: recording.taken as u16,
            time_us: self
                .options
                .micros_at_start
                .wrapping_add(self.now_us as u32),
            counts: if self.options.counts_16_bit {
                i32::from(counts as i16)
            } else {
                counts as i32
            },
            command_mv: asked_mv,
            flags: SampleFlags {
                dropped: std::mem::take(&mut recording.just_dropped),
                saturated: asked_mv.unsigned_abs() > supply_mv.unsigned_abs(),
                ..SampleFlags::default()
            },
            current_ma: None,
            supply_mv: None,
        };
        recording.taken += 1;
        let last = recording.taken == recording.samples;
        let end = if last {
            self.now_us += u64::from(self.sample_time_us);
            self.stop(EndReason::Complete)
        } else {
            None
        };
        Some((BoardMessage::Data(sample), end))
    }

    /// The frame of the last sample did not fit the line's buffer.
    pub(super) fn sample_was_dropped(&mut self) {
        if let Some(recording) = &mut self.recording {
            recording.dropped += 1;
            recording.just_dropped = true;
        } else if let Some(BoardMessage::End { dropped, .. }) = &mut self.last_end {
            *dropped += 1;
        }
    }

    /// The END of the last recording, with its losses so far.
    pub(super) fn last_end(&self) -> Option<BoardMessage> {
        self.last_end
    }
}

fn command_at(profile: &[ProfileSegment], sample: u64) -> i16 {
    let mut first = 0;
    for segment in profile {
        first += u64::from(segment.samples);
        if sample < first {
            return segment.command_mv;
        }
    }
    profile.last().map_or(0, |last| last.command_mv)
}

impl Recording {
    /// The command of the current sample; advances through the profile.
    fn command_mv(&mut self, profile: &[ProfileSegment]) -> i16 {
        while let Some(segment) = profile.get(self.segment) {
            let is_last = self.segment + 1 == profile.len();
            if is_last || self.samples_in_segment < u32::from(segment.samples) {
                self.samples_in_segment = self.samples_in_segment.saturating_add(1);
                return segment.command_mv;
            }
            self.segment += 1;
            self.samples_in_segment = 0;
        }
        0
    }
}
