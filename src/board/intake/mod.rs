//! Decoder of a board's bytes: bytes in, validated samples out, without I/O; used by capture, replay and benchmarks.
//!
//! ```text
//! bytes -> frame (COBS, CRC-16) -> message (every field in range) -> plausible? -> sample (64 bit)
//! ```
//!
//! A frame with a CRC that is right at random must also agree with the previous sample: a later number, device time
//! `n TS` later, counts within the limits of an encoder, and the profile's command for its number. An inconsistent
//! sample is held back; if the next one agrees with it, both are accepted and the first is marked with its [`Leap`]
//! (a late board, a counter or a clock that was reset), else it is rejected and its number counts as lost.
//!
//! A repeated HELLO during a run is ignored; one with other contents ends the recording, as the board was replaced.

use firmware_protocol::{
    BoardFields, BoardMessage, CountsUnwrapper, EndReason, FrameDecoder, Hello, MessageError,
    MicrosUnwrapper, Refusal, SampleFlags, Sequence, SequenceUnwrapper,
};

mod plausibility;

use super::heard::Heard;
use super::leap::{LONGEST_STEP_US, Leap};
use super::motion::Motion;
use plausibility::{Doubt, Fit};

/// A validated sample with unwrapped counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// Sample number from START.
    pub number: u64,
    /// Device time in microseconds, with an arbitrary origin.
    pub device_us: u64,
    /// Arrival time in microseconds on the host's monotonic clock.
    pub host_us: u64,
    /// Command in force from this sample on, in mV.
    pub command_mv: i16,
    /// Encoder counts.
    pub counts: i64,
    /// Flags of the board.
    pub flags: SampleFlags,
    /// Discontinuities relative to the previous sample.
    pub leap: Leap,
    /// Measured current in mA, if the board has the sensor.
    pub current_ma: Option<i16>,
    /// Measured supply in mV, if the board has the sensor.
    pub supply_mv: Option<u16>,
}

/// Event of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Identity; during a run only if it differs from the previous HELLO.
    Hello(Hello),
    /// A host message was accepted.
    Ack {
        /// Type of the message.
        of: u8,
        /// For a chunk: the next expected segment.
        detail: u16,
    },
    /// A host message was refused.
    Nak {
        /// Type of the message.
        of: u8,
        /// Reason.
        reason: Refusal,
    },
    /// A sample.
    Sample(Sample),
    /// End of the recording.
    End {
        /// Samples taken.
        taken: u32,
        /// Samples that it could not send.
        dropped: u32,
        /// Reason.
        reason: EndReason,
    },
    /// Another protocol version.
    OtherVersion(u8),
}

/// Damage on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Damage {
    /// Frames with a wrong CRC, wrong stuffing or a wrong length.
    pub bad_frames: u64,
    /// Frames with a right CRC that disagree with the neighbouring samples.
    pub implausible: u64,
    /// Repeated frames.
    pub repeated: u64,
}

/// Expected values for the plausibility of a sample.
#[derive(Debug, Clone, Default)]
pub struct Expectations {
    /// Sample time in microseconds; 0 if unknown.
    pub sample_time_us: u32,
    /// The uploaded profile: pairs of number of samples and command in mV. Empty if unknown.
    pub commands: Vec<(u64, i16)>,
}

/// Decoder from a board's bytes to events.
#[derive(Debug, Clone)]
pub struct Intake {
    decoder: FrameDecoder,
    fields: BoardFields,
    /// The board's identity, and whether it is recording, during which it cannot change.
    hello: Option<Hello>,
    recording: bool,
    counts_per_rev: f64,
    expectations: Expectations,
    /// Position of the last sample in `expectations.commands`: index and number of the segment's first sample.
    segment: (usize, u64),
    /// Before the first complete frame nothing counts as damage: the port was opened in the middle.
    in_step: bool,
    wire: Option<firmware_protocol::Sample>,
    suspect: Option<Suspect>,
    /// Offset of the board's clock relative to the continuous time here, in microseconds.
    ahead_us: i64,
    sequence: SequenceUnwrapper,
    micros: MicrosUnwrapper,
    counts: CountsUnwrapper,
    motion: Motion,
    damage: Damage,
    heard: Heard,
}

/// An inconsistent sample, held back until the next one.
#[derive(Debug, Clone, Copy)]
struct Suspect {
    sample: firmware_protocol::Sample,
    host_us: u64,
    leap: Leap,
    doubt: Option<Doubt>,
}

impl Default for Intake {
    fn default() -> Self {
        Self {
            decoder: FrameDecoder::new(),
            fields: BoardFields::default(),
            hello: None,
            recording: false,
            counts_per_rev: f64::INFINITY,
            expectations: Expectations::default(),
            segment: (0, 0),
            in_step: false,
            wire: None,
            suspect: None,
            ahead_us: 0,
            sequence: SequenceUnwrapper::new(),
            micros: MicrosUnwrapper::new(),
            counts: CountsUnwrapper::new(false),
            motion: Motion::default(),
            damage: Damage::default(),
            heard: Heard::default(),
        }
    }
}

impl Intake {
    /// Begins a recording: numbers restart from 0.
    pub fn expect(&mut self, expectations: Expectations) {
        self.expectations = expectations;
        self.segment = (0, 0);
        self.recording = true;
        self.wire = None;
        self.suspect = None;
        self.ahead_us = 0;
        self.sequence = SequenceUnwrapper::new();
        self.micros = MicrosUnwrapper::new();
        self.counts = CountsUnwrapper::new(self.fields.counts_16_bit);
        self.motion = Motion::default();
    }

    /// Sets the encoder's resolution in counts per revolution, which limits the counts between two samples.
    pub fn encoder(&mut self, counts_per_rev: f64) {
        self.counts_per_rev = counts_per_rev;
    }

    /// Damage so far.
    pub fn damage(&self) -> Damage {
        self.damage
    }

    /// The first bytes that were no frame: output of a foreign board.
    pub fn heard(&self) -> &Heard {
        &self.heard
    }

    /// Processes bytes that arrived at `host_us`; passes each event to `out`.
    pub fn push(&mut self, host_us: u64, bytes: &[u8], mut out: impl FnMut(Event)) {
        for &byte in bytes {
            if !self.in_step {
                self.heard.push(byte);
            }
            let message = match self.decoder.push(byte) {
                None => continue,
                Some(Ok(frame)) => BoardMessage::parse(frame, self.fields),
                Some(Err(_)) => {
                    self.damage.bad_frames += u64::from(self.in_step);
                    continue;
                }
            };
            match message {
                Ok(message) => {
                    self.in_step = true;
                    self.take(message, host_us, &mut out);
                }
                Err(MessageError::Version { found }) => out(Event::OtherVersion(found)),
                Err(_) => self.damage.bad_frames += u64::from(self.in_step),
            }
        }
    }

    fn take(&mut self, message: BoardMessage, host_us: u64, out: &mut impl FnMut(Event)) {
        match message {
            BoardMessage::Hello(hello) => self.take_hello(hello, out),
            BoardMessage::Ack { of, detail } => out(Event::Ack { of, detail }),
            BoardMessage::Nak { of, reason } => out(Event::Nak { of, reason }),
            BoardMessage::Data(sample) => self.take_sample(sample, host_us, out),
            BoardMessage::End {
                taken,
                dropped,
                reason,
            } => {
                match self.suspect.take() {
                    Some(last) if last.doubt.is_some() => self.release(last, None, out),
                    suspect => self.damage.implausible += u64::from(suspect.is_some()),
                }
                out(Event::End {
                    taken,
                    dropped,
                    reason,
                });
            }
            BoardMessage::Text(_) => {}
        }
    }

    /// A buffer may delay or repeat a HELLO: during a run an identical one is ignored, and a different one is passed
    /// on without an effect here.
    fn take_hello(&mut self, hello: Hello, out: &mut impl FnMut(Event)) {
        match self.hello {
            Some(known) if self.recording && is_same_board(&known, &hello) => return,
            Some(_) if self.recording => {}
            _ => {
                self.hello = Some(hello);
                self.fields = hello.fields;
                self.counts = CountsUnwrapper::new(hello.fields.counts_16_bit);
            }
        }
        out(Event::Hello(hello));
    }

    fn take_sample(
        &mut self,
        sample: firmware_protocol::Sample,
        host_us: u64,
        out: &mut impl FnMut(Event),
    ) {
        let fit = self.fit(self.wire.as_ref(), &sample);
        let doubt = self.doubt(&sample).filter(|_| fit == Fit::Follows);
        // A sample that agrees with a doubtful one confirms it, even if it also agrees with the one before.
        let settles = self.suspect.is_some_and(|held| {
            held.doubt.is_some()
                && self.is_ahead(&held.sample)
                && self.fit(Some(&held.sample), &sample) == Fit::Follows
        });
        if fit == Fit::Follows && doubt.is_none() && !settles {
            self.damage.implausible += u64::from(self.suspect.take().is_some());
            out(Event::Sample(self.accept(sample, host_us, Leap::default())));
            return;
        }
        if self
            .wire
            .is_some_and(|last| last.sequence == sample.sequence && last.time_us == sample.time_us)
        {
            self.damage.repeated += 1;
            return;
        }
        match self.suspect.take() {
            // Two consistent frames in a row: the implausible one was the one before.
            Some(before)
                if self.is_ahead(&before.sample)
                    && self.fit(Some(&before.sample), &sample) == Fit::Follows =>
            {
                self.release(before, Some(&sample), out);
                self.take_sample(sample, host_us, out);
            }
            before => match (fit, doubt) {
                (Fit::Leaps(_), _) | (Fit::Follows, Some(_)) => {
                    self.damage.implausible += u64::from(before.is_some());
                    let leap = match fit {
                        Fit::Leaps(leap) => leap,
                        Fit::Follows | Fit::Never => Leap::default(),
                    };
                    self.suspect = Some(Suspect {
                        sample,
                        host_us,
                        leap,
                        doubt,
                    });
                }
                (Fit::Follows | Fit::Never, _) => {
                    self.damage.implausible += 1;
                    self.suspect = before;
                }
            },
        }
    }

    /// Releases a held-back sample, marked according to the one after it.
    fn release(
        &mut self,
        held: Suspect,
        after: Option<&firmware_protocol::Sample>,
        out: &mut impl FnMut(Event),
    ) {
        let step = after.map_or(0.0, |after| self.moved(&held.sample, after));
        let step_us = f64::from(self.expectations.sample_time_us.max(1));
        let counts = match held.doubt {
            Some(Doubt::Gap(gap_us)) => self.motion.may_have_wrapped(gap_us, step / step_us),
            Some(Doubt::Reset(counts)) => Motion::continues_after(counts, step),
            None => held.leap.counts,
        };
        let leap = Leap {
            counts,
            ..held.leap
        };
        out(Event::Sample(self.accept(held.sample, held.host_us, leap)));
    }

    /// Accepts a sample. Its time follows the board's clock; where that falls back or jumps by more than
    /// [`LONGEST_STEP_US`], the sample numbers.
    fn accept(&mut self, sample: firmware_protocol::Sample, host_us: u64, leap: Leap) -> Sample {
        let number = match self.sequence.push(sample.sequence) {
            Sequence::Next { number, .. } => number,
            // Excluded by `fits_to` and `is_ahead`.
            Sequence::Stale => u64::from(sample.sequence),
        };
        let commands = &self.expectations.commands;
        while let Some((length, _)) = commands.get(self.segment.0)
            && self.segment.0 + 1 < commands.len()
            && number >= self.segment.1 + length
        {
            self.segment = (self.segment.0 + 1, self.segment.1 + length);
        }
        let before = self.wire.replace(sample);
        if let Some(last) = before.filter(|_| !leap.counts) {
            let steps = f64::from(sample.sequence.wrapping_sub(last.sequence));
            let elapsed_us = steps * f64::from(self.expectations.sample_time_us);
            self.motion.push(self.moved(&last, &sample), elapsed_us);
        }
        if let Some(before) = before.filter(|_| leap.time) {
            let elapsed_us = i64::from(sample.time_us.wrapping_sub(before.time_us));
            let steps = i64::from(sample.sequence.wrapping_sub(before.sequence));
            if elapsed_us > LONGEST_STEP_US {
                let expected_us = steps * i64::from(self.expectations.sample_time_us);
                self.ahead_us += elapsed_us - expected_us;
            }
        }
        Sample {
            number,
            device_us: self
                .micros
                .push(sample.time_us)
                .saturating_add_signed(-self.ahead_us),
            host_us,
            command_mv: sample.command_mv,
            counts: self.counts.push(sample.counts),
            flags: sample.flags,
            leap,
            current_ma: sample.current_ma,
            supply_mv: sample.supply_mv,
        }
    }
}

/// Whether both describe the same board; its sample time may have been set in between.
pub(super) fn is_same_board(known: &Hello, heard: &Hello) -> bool {
    let sample_time_us = known.sample_time_us;
    *known
        == Hello {
            sample_time_us,
            ..*heard
        }
}
