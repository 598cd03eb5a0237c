// Sampling by Timer1 in CTC mode: the counter restarts itself at each match, so that ticks never drift
// and a late interrupt shows in the count that it finds.
//
// The tick takes counts and time, lets the encoder's interrupts in again and puts the next command out;
// loop() sends. Overrun (flag and pin 13): the loop had not sent the sample before, or the tick itself
// came a quarter of a sample late or more.
#pragma once

struct Segment {
  uint16_t samples;
  int16_t commandMv;
};

struct Sample {
  uint16_t sequence;
  uint32_t timeUs;
  int32_t counts;
  int16_t commandMv;
  uint8_t flags;
};

static Segment profile[PROFILE_SEGMENTS];
static uint16_t profileLength;

#define WAITING_SAMPLES 4  // power of two
static Sample waiting[WAITING_SAMPLES];
static volatile uint8_t waitingHead, waitingTail;

static volatile bool running;
static volatile uint32_t taken, dropped, wanted;
static volatile bool droppedSinceSent;
static uint16_t segmentAt, segmentSamples;
static int16_t commandNow;
static uint16_t lateLimit;  // timer counts

// The smallest of Timer1's prescalers (8, 64, 256) with which the sample time fits exactly.
static bool timerFor(uint32_t sampleTimeUs, uint8_t *clockSelect, uint16_t *top) {
  static const uint8_t select[] = {_BV(CS11), _BV(CS11) | _BV(CS10), _BV(CS12)};
  static const uint16_t prescaler[] = {8, 64, 256};
  const uint32_t cyclesPerUs = F_CPU / 1000000UL;
  if (sampleTimeUs > 1000000UL) return false;
  uint32_t cycles = sampleTimeUs * cyclesPerUs;
  for (uint8_t k = 0; k < 3; k++) {
    if (cycles % prescaler[k] == 0 && cycles / prescaler[k] <= 65536UL) {
      *clockSelect = select[k];
      *top = cycles / prescaler[k] - 1;
      return true;
    }
  }
  return false;
}

static bool timerCanKeep(uint32_t sampleTimeUs) {
  uint8_t clockSelect;
  uint16_t top;
  return timerFor(sampleTimeUs, &clockSelect, &top);
}

static bool sampling() { return running; }

static uint32_t samplesTaken() {
  noInterrupts();
  uint32_t value = taken;
  interrupts();
  return value;
}

static uint32_t samplesDropped() {
  noInterrupts();
  uint32_t value = dropped;
  interrupts();
  return value;
}

// Takes the command of the next sample off the profile; the last one holds on.
static inline void advanceProfile() {
  while (segmentAt < profileLength && segmentSamples == 0) {
    segmentSamples = profile[segmentAt].samples;
    if (segmentSamples > 0) commandNow = profile[segmentAt].commandMv;
    else segmentAt++;
  }
  if (segmentAt < profileLength && --segmentSamples == 0) segmentAt++;
}

ISR(TIMER1_COMPA_vect) {
  uint16_t late = TCNT1;
  Sample sample;
  sample.counts = encoderCounts;
  sample.timeUs = micros();
  sample.flags = 0;
  if (encoderError) {
    encoderError = false;
    sample.flags |= MLAB_FLAG_ENCODER_ERROR;
  }
  // The rest takes the time of several edges: from here on they may interrupt, the next tick may not.
  TIMSK1 = 0;
  interrupts();
  advanceProfile();
  sample.commandMv = commandNow;
  if (drive(commandNow)) sample.flags |= MLAB_FLAG_SATURATED;
  bool unfinished = waitingHead != waitingTail;
  if (unfinished || late >= lateLimit) {
    sample.flags |= MLAB_FLAG_OVERRUN;
    digitalWrite(PIN_OVERRUN_LED, HIGH);
  }
  noInterrupts();
  sample.sequence = taken++;
  uint8_t next = (waitingHead + 1) & (WAITING_SAMPLES - 1);
  if (next == waitingTail) {
    dropped++;
    droppedSinceSent = true;
  } else {
    waiting[waitingHead] = sample;
    waitingHead = next;
  }
  if (wanted == 0 || taken < wanted) TIMSK1 = _BV(OCIE1A);
}

static void startSampling(uint32_t sampleTimeUs, uint32_t samples) {
  uint8_t clockSelect = 0;
  uint16_t top = 0;
  if (!timerFor(sampleTimeUs, &clockSelect, &top)) return;
  noInterrupts();
  digitalWrite(PIN_OVERRUN_LED, LOW);
  taken = dropped = 0;
  wanted = samples;
  waitingHead = waitingTail = 0;
  droppedSinceSent = encoderError = false;
  segmentAt = segmentSamples = 0;
  commandNow = 0;
  lateLimit = top / 4 + 1;
  TCCR1A = 0;
  TCCR1B = 0;
  TCNT1 = 0;
  OCR1A = top;
  TIFR1 = _BV(OCF1A);
  TIMSK1 = _BV(OCIE1A);
  TCCR1B = _BV(WGM12) | clockSelect;
  running = true;
  interrupts();
}

static void stopSampling() {
  TIMSK1 = 0;
  TCCR1B = 0;
  driveOff();
  running = false;
}

// All samples that START asked for have been taken.
static bool samplingComplete() { return wanted != 0 && samplesTaken() >= wanted; }

// Sends the oldest waiting sample; without `mayWait` one that does not fit on the line is dropped whole,
// and counted.
static void sendSample(bool mayWait) {
  const Sample &sample = waiting[waitingTail];
  uint8_t flags = sample.flags;
  noInterrupts();
  if (droppedSinceSent) flags |= MLAB_FLAG_DROPPED;
  droppedSinceSent = false;
  interrupts();
  FrameOut frame(MLAB_DATA);
  frame.u16(sample.sequence);
  frame.u32(sample.timeUs);
  frame.u32(sample.counts);
  frame.u16(sample.commandMv);
  frame.u8(flags);
  bool sent = true;
  if (mayWait) frame.send();
  else sent = frame.sendIfRoom();
  noInterrupts();
  if (!sent) {
    droppedSinceSent = true;
    dropped++;
  }
  waitingTail = (waitingTail + 1) & (WAITING_SAMPLES - 1);
  interrupts();
}

// Sends the samples that wait, as far as the line takes them at once.
static void drainSamples() {
  while (waitingTail != waitingHead) sendSample(false);
}

// Sends the samples that wait, however long that takes: when no more are taken.
static void flushSamples() {
  while (waitingTail != waitingHead) sendSample(true);
}
