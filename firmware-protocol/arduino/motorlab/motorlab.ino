// motorlab: drives a DC motor, counts its encoder and sends the counts to a host.
//
// Boards: Arduino Uno (ATmega328P) and Mega 2560. Libraries: none. Wiring: README.md beside this file.
// The wire: firmware-protocol/PROTOCOL.md of motorlab. Settings to change are in settings.h.
//
//   encoder edges --interrupt--> counts        encoder.h
//   Timer1 tick   --interrupt--> sample, PWM   sampler.h, drive.h
//   loop()        sample -> frame -> serial line; host's frames -> what to do
#include "settings.h"
#include "motorlab_wire.h"
#include "encoder.h"
#include "drive.h"
#include "frames.h"
#include "sampler.h"

#include <avr/eeprom.h>

static uint32_t bootId;
static uint32_t sampleTimeUs = 30000;
static uint32_t lastHeardMs;
static uint16_t profileAnnounced;  // segments that PROFILE announced
static uint16_t profileCrc;        // and the CRC over them all

// Another number after each reset, kept in the EEPROM.
static uint32_t nextBootId() {
  uint32_t *place = (uint32_t *)0;
  uint32_t id = eeprom_read_dword(place) + 1;
  eeprom_update_dword(place, id);
  return id;
}

static void sendHello() {
  FrameOut frame(MLAB_HELLO);
  frame.bytes((const uint8_t *)MLAB_MAGIC, 4);
  frame.u8(MLAB_PROTOCOL_VERSION);
  frame.u8(FIRMWARE_MAJOR);
  frame.u8(FIRMWARE_MINOR);
  frame.u32(bootId);
  frame.u32(sampleTimeUs);
  frame.u16(SHORTEST_SAMPLE_TIME_US);
  frame.u32(COUNTS_PER_REV);
  frame.u16(SUPPLY_MV);
  frame.u8(0);  // neither current nor supply sensor; the counter has 32 bits
  frame.u16(PROFILE_SEGMENTS);
  frame.bytes((const uint8_t *)BOARD_NAME, sizeof(BOARD_NAME) - 1);
  frame.send();
}

static void sendAck(uint8_t of, uint16_t detail) {
  FrameOut frame(MLAB_ACK);
  frame.u8(of);
  frame.u16(detail);
  frame.send();
}

static void sendNak(uint8_t of, uint8_t reason) {
  FrameOut frame(MLAB_NAK);
  frame.u8(of);
  frame.u8(reason);
  frame.send();
}

// Ends the recording: first the motor off and no more ticks, then all samples that wait, then END.
static void sendEnd(uint8_t reason) {
  stopSampling();
  flushSamples();
  FrameOut frame(MLAB_END);
  frame.u32(samplesTaken());
  frame.u32(samplesDropped());
  frame.u8(reason);
  frame.send();
}

// CONFIGURE: sample time and what 0 V means.
static void configure(const FrameIn &frame) {
  if (frame.length != 5) return sendNak(MLAB_CONFIGURE, MLAB_REFUSED_LENGTH);
  uint32_t wanted = frame.u32(0);
  if (wanted < SHORTEST_SAMPLE_TIME_US || !timerCanKeep(wanted))
    return sendNak(MLAB_CONFIGURE, MLAB_REFUSED_SAMPLE_TIME);
  sampleTimeUs = wanted;
  driveCoastAtZero(frame.u8(4) & 1);
  sendAck(MLAB_CONFIGURE, 0);
}

// PROFILE: so many segments follow.
static void announceProfile(const FrameIn &frame) {
  if (frame.length != 4) return sendNak(MLAB_PROFILE, MLAB_REFUSED_LENGTH);
  uint16_t segments = frame.u16(0);
  if (segments > PROFILE_SEGMENTS) return sendNak(MLAB_PROFILE, MLAB_REFUSED_PROFILE_TOO_LONG);
  profileAnnounced = segments;
  profileCrc = frame.u16(2);
  profileLength = 0;
  sendAck(MLAB_PROFILE, 0);
}

// CHUNK: a part of the profile; one that was sent twice is taken twice.
static void takeChunk(const FrameIn &frame) {
  if (frame.length < 6 || (frame.length - 2) % 4 != 0)
    return sendNak(MLAB_CHUNK, MLAB_REFUSED_LENGTH);
  uint16_t first = frame.u16(0);
  uint16_t count = (frame.length - 2) / 4;
  if (first > profileLength) return sendNak(MLAB_CHUNK, MLAB_REFUSED_CHUNK_ORDER);
  if (count > profileAnnounced || first > profileAnnounced - count)
    return sendNak(MLAB_CHUNK, MLAB_REFUSED_PROFILE_TOO_LONG);
  for (uint16_t k = 0; k < count; k++) {
    profile[first + k].samples = frame.u16(2 + 4 * k);
    profile[first + k].commandMv = (int16_t)frame.u16(4 + 4 * k);
  }
  if (first + count > profileLength) profileLength = first + count;
  if (profileLength == profileAnnounced && crcOf((const uint8_t *)profile, 4 * profileLength) != profileCrc) {
    profileLength = 0;
    return sendNak(MLAB_CHUNK, MLAB_REFUSED_PROFILE_CRC);
  }
  sendAck(MLAB_CHUNK, first + count);
}

static void start(const FrameIn &frame) {
  if (frame.length != 4) return sendNak(MLAB_START, MLAB_REFUSED_LENGTH);
  if (profileLength != profileAnnounced) return sendNak(MLAB_START, MLAB_REFUSED_STATE);
  sendAck(MLAB_START, 0);
  startSampling(sampleTimeUs, frame.u32(0));
}

static void obey(const FrameIn &frame) {
  switch (frame.kind) {
    case MLAB_IDENTIFY: return sendHello();
    case MLAB_ALIVE: return;
    case MLAB_STOP:
      if (sampling()) return sendEnd(MLAB_END_STOPPED);
      return sendNak(MLAB_STOP, MLAB_REFUSED_STATE);
  }
  if (sampling()) return sendNak(frame.kind, MLAB_REFUSED_STATE);
  switch (frame.kind) {
    case MLAB_CONFIGURE: return configure(frame);
    case MLAB_PROFILE: return announceProfile(frame);
    case MLAB_CHUNK: return takeChunk(frame);
    case MLAB_START: return start(frame);
    default: return sendNak(frame.kind, MLAB_REFUSED_UNKNOWN);
  }
}

void setup() {
  driveBegin();  // first of all the motor off
  pinMode(PIN_OVERRUN_LED, OUTPUT);
  encoderBegin();
  bootId = nextBootId();
  Serial.begin(MLAB_BAUD);
  sendHello();
}

void loop() {
  drainSamples();
  if (sampling() && samplingComplete()) sendEnd(MLAB_END_COMPLETE);
  while (Serial.available() > 0) {
    if (const FrameIn *frame = receive(Serial.read())) {
      lastHeardMs = millis();
      obey(*frame);
    }
    drainSamples();
  }
  if (!sampling()) {
    lastHeardMs = millis();
  } else if (millis() - lastHeardMs >= MLAB_LINK_TIMEOUT_MS - LINK_MARGIN_MS) {
    sendEnd(MLAB_END_LINK_LOST);
  }
}
