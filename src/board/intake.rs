//! From bytes to validated samples, without a line or a clock of its own: live capture, replay and the
//! benches all feed it.
//!
//! ```text
//! bytes -> frame (COBS, CRC-16) -> message (every field in range) -> plausible? -> sample (64 bit)
//! ```
//!
//! A frame whose CRC is right by chance must also fit to the sample before it: its number lies ahead,
//! its device time lies `n TS` later, its counts moved no faster than an encoder can, and its command
//! is the one that the profile has for its number. What does not fit is held back; if the next frame
//! fits to it, both were right and something else happened (a late board), else it is rejected and its
//! number counts as lost.

use firmware_protocol::{
    BoardFields, BoardMessage, CountsUnwrapper, EndReason, FrameDecoder, Hello, MessageError,
    MicrosUnwrapper, Refusal, SampleFlags, Sequence, SequenceUnwrapper,
};

use super::heard::Heard;

/// A validated sample, with counters that run on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// Sample number from START on.
    pub number: u64,
    /// Device time in microseconds; only differences mean something.
    pub device_us: u64,
    /// Arrival time in microseconds on the host's monotonic clock.
    pub host_us: u64,
    /// Command in force from this sample on, in mV.
    pub command_mv: i16,
    /// Encoder counts.
    pub counts: i64,
    /// What the board says of it.
    pub flags: SampleFlags,
    /// Measured current in mA, where the board has the sensor.
    pub current_ma: Option<i16>,
    /// Measured supply in mV, where the board has the sensor.
    pub supply_mv: Option<u16>,
}

/// What a board said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Who it is.
    Hello(Hello),
    /// It took a host message.
    Ack {
        /// Type of the message.
        of: u8,
        /// Of a chunk: the segment expected next.
        detail: u16,
    },
    /// It refused a host message.
    Nak {
        /// Type of the message.
        of: u8,
        /// Why.
        reason: Refusal,
    },
    /// A sample.
    Sample(Sample),
    /// The recording is over.
    End {
        /// Samples taken.
        taken: u32,
        /// Of these, how many it could not send.
        dropped: u32,
        /// Why it is over.
        reason: EndReason,
    },
    /// It speaks another version of the protocol.
    OtherVersion(u8),
}

/// What went wrong on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Damage {
    /// Frames with a wrong CRC, wrong stuffing or a wrong length.
    pub bad_frames: u64,
    /// Frames with a right CRC that do not fit to the samples around them.
    pub implausible: u64,
    /// Frames that came again.
    pub repeated: u64,
}

/// What a sample is held against.
#[derive(Debug, Clone, Default)]
pub struct Expectations {
    /// Sample time in microseconds; 0 if it is not known.
    pub sample_time_us: u32,
    /// The uploaded profile: for how many samples which command in mV. Empty if it is not known.
    pub commands: Vec<(u64, i16)>,
}

/// Fastest encoder that is believed, in counts per second.
const MOST_COUNTS_PER_S: u64 = 2_000_000;

/// A board that is late says so; then its time may be off by so many sample times.
const LATE_SAMPLES: u64 = 16;

/// Turns a board's bytes into events.
#[derive(Debug, Clone)]
pub struct Intake {
    decoder: FrameDecoder,
    fields: BoardFields,
    expectations: Expectations,
    /// Where in `expectations.commands` the last sample was: index and number of its first sample.
    segment: (usize, u64),
    /// Nothing before the first whole frame counts as damage: the port was opened in the middle.
    in_step: bool,
    wire: Option<firmware_protocol::Sample>,
    suspect: Option<(firmware_protocol::Sample, u64)>,
    sequence: SequenceUnwrapper,
    micros: MicrosUnwrapper,
    counts: CountsUnwrapper,
    damage: Damage,
    heard: Heard,
}

impl Default for Intake {
    fn default() -> Self {
        Self {
            decoder: FrameDecoder::new(),
            fields: BoardFields::default(),
            expectations: Expectations::default(),
            segment: (0, 0),
            in_step: false,
            wire: None,
            suspect: None,
            sequence: SequenceUnwrapper::new(),
            micros: MicrosUnwrapper::new(),
            counts: CountsUnwrapper::new(false),
            damage: Damage::default(),
            heard: Heard::default(),
        }
    }
}

impl Intake {
    /// Begins a recording: numbers start from 0 again.
    pub fn expect(&mut self, expectations: Expectations) {
        self.expectations = expectations;
        self.segment = (0, 0);
        self.wire = None;
        self.suspect = None;
        self.sequence = SequenceUnwrapper::new();
        self.micros = MicrosUnwrapper::new();
        self.counts = CountsUnwrapper::new(self.fields.counts_16_bit);
    }

    /// What went wrong so far.
    pub fn damage(&self) -> Damage {
        self.damage
    }

    /// The first bytes that were no frame: what a foreign board sent.
    pub fn heard(&self) -> &Heard {
        &self.heard
    }

    /// Takes bytes that arrived at `host_us`; hands each event to `out`.
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
            BoardMessage::Hello(hello) => {
                self.fields = hello.fields;
                self.counts = CountsUnwrapper::new(hello.fields.counts_16_bit);
                out(Event::Hello(hello));
            }
            BoardMessage::Ack { of, detail } => out(Event::Ack { of, detail }),
            BoardMessage::Nak { of, reason } => out(Event::Nak { of, reason }),
            BoardMessage::Data(sample) => self.take_sample(sample, host_us, out),
            BoardMessage::End {
                taken,
                dropped,
                reason,
            } => {
                self.damage.implausible += u64::from(self.suspect.take().is_some());
                out(Event::End {
                    taken,
                    dropped,
                    reason,
                });
            }
            BoardMessage::Text(_) => {}
        }
    }

    fn take_sample(
        &mut self,
        sample: firmware_protocol::Sample,
        host_us: u64,
        out: &mut impl FnMut(Event),
    ) {
        if self.fits_to(self.wire.as_ref(), &sample) {
            self.damage.implausible += u64::from(self.suspect.take().is_some());
            out(Event::Sample(self.accept(sample, host_us)));
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
            // Two frames on end that fit to each other and lie ahead: the odd one out was before.
            Some((before, before_us))
                if self.is_ahead(&before) && self.fits_to(Some(&before), &sample) =>
            {
                out(Event::Sample(self.accept(before, before_us)));
                out(Event::Sample(self.accept(sample, host_us)));
            }
            Some(_) => {
                self.damage.implausible += 1;
                self.suspect = Some((sample, host_us));
            }
            None => self.suspect = Some((sample, host_us)),
        }
    }

    fn is_ahead(&self, sample: &firmware_protocol::Sample) -> bool {
        let mut sequence = self.sequence;
        sequence.push(sample.sequence) != Sequence::Stale
    }

    /// Whether `sample` can come after `last`; without one, whether it can be the first.
    fn fits_to(
        &self,
        last: Option<&firmware_protocol::Sample>,
        sample: &firmware_protocol::Sample,
    ) -> bool {
        let sample_time_us = u64::from(self.expectations.sample_time_us);
        let mut sequence = self.sequence;
        let number = match sequence.push(sample.sequence) {
            Sequence::Next { number, .. } => number,
            Sequence::Stale => return false,
        };
        if self
            .expected_command(number)
            .is_some_and(|command_mv| command_mv != sample.command_mv)
        {
            return false;
        }
        let Some(last) = last else {
            // The first sample has nothing to fit to but its number.
            return number == 0 || sample_time_us == 0;
        };
        let steps = u64::from(sample.sequence.wrapping_sub(last.sequence));
        if steps == 0 || steps > u64::from(u16::MAX / 2) {
            return false;
        }
        if sample_time_us == 0 {
            return true;
        }
        let elapsed_us = u64::from(sample.time_us.wrapping_sub(last.time_us));
        let expected_us = steps * sample_time_us;
        let late = sample.flags.overrun || last.flags.overrun;
        let slack_us = expected_us / 100
            + if late {
                LATE_SAMPLES * sample_time_us
            } else {
                sample_time_us / 2
            };
        // Gaps of more than 71 minutes cannot be told from shorter ones.
        let off_us = (elapsed_us as i64 - (expected_us % (1 << 32)) as i64).unsigned_abs();
        let moved = if self.fields.counts_16_bit {
            u64::from(
                (sample.counts as i16)
                    .wrapping_sub(last.counts as i16)
                    .unsigned_abs(),
            )
        } else {
            u64::from(sample.counts.wrapping_sub(last.counts).unsigned_abs())
        };
        off_us <= slack_us && moved <= 16 + MOST_COUNTS_PER_S * expected_us / 1_000_000
    }

    /// The command that the profile has for sample `number`, which lies ahead of the last one.
    fn expected_command(&self, number: u64) -> Option<i16> {
        let (mut index, mut first) = self.segment;
        loop {
            let (length, command_mv) = *self.expectations.commands.get(index)?;
            let is_last = index + 1 == self.expectations.commands.len();
            if is_last || number < first + length {
                return Some(command_mv);
            }
            first += length;
            index += 1;
        }
    }

    fn accept(&mut self, sample: firmware_protocol::Sample, host_us: u64) -> Sample {
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
        self.wire = Some(sample);
        Sample {
            number,
            device_us: self.micros.push(sample.time_us),
            host_us,
            command_mv: sample.command_mv,
            counts: self.counts.push(sample.counts),
            flags: sample.flags,
            current_ma: sample.current_ma,
            supply_mv: sample.supply_mv,
        }
    }
}
