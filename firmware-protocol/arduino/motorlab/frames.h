// Frames: COBS( type, body, CRC-16 ) 0, in both directions. See PROTOCOL.md.
#pragma once

#include <util/crc16.h>

// CRC-16/CCITT-FALSE over a block of memory.
static uint16_t crcOf(const uint8_t *bytes, uint16_t length) {
  uint16_t crc = 0xFFFF;
  while (length--) crc = _crc_xmodem_update(crc, *bytes++);
  return crc;
}

// A frame being written; it goes out whole or not at all.
class FrameOut {
 public:
  explicit FrameOut(uint8_t kind) : length_(1), codeAt_(0), crc_(0xFFFF) { u8(kind); }

  void u8(uint8_t value) {
    crc_ = _crc_xmodem_update(crc_, value);
    stuff(value);
  }
  void u16(uint16_t value) {
    u8(value);
    u8(value >> 8);
  }
  void u32(uint32_t value) {
    u16(value);
    u16(value >> 16);
  }
  void bytes(const uint8_t *from, uint8_t count) {
    while (count--) u8(*from++);
  }

  // Waits for room on the line: for answers, not for samples.
  void send() {
    finish();
    Serial.write(wire_, length_);
  }

  // Sends only what fits at once; false where it does not.
  bool sendIfRoom() {
    finish();
    if (Serial.availableForWrite() < length_) return false;
    Serial.write(wire_, length_);
    return true;
  }

 private:
  void stuff(uint8_t value) {
    if (value == 0) {
      wire_[codeAt_] = length_ - codeAt_;
      codeAt_ = length_++;
    } else {
      wire_[length_++] = value;
    }
  }
  void finish() {
    uint16_t crc = crc_;
    stuff(crc);
    stuff(crc >> 8);
    wire_[codeAt_] = length_ - codeAt_;
    wire_[length_++] = 0;
  }

  uint8_t wire_[MLAB_MAX_WIRE];
  uint8_t length_;
  uint8_t codeAt_;
  uint16_t crc_;
};

// A frame of the host with the right CRC.
struct FrameIn {
  uint8_t kind;
  uint8_t length;       // of the body
  const uint8_t *body;

  uint8_t u8(uint8_t at) const { return body[at]; }
  uint16_t u16(uint8_t at) const { return body[at] | (uint16_t)body[at + 1] << 8; }
  uint32_t u32(uint8_t at) const { return u16(at) | (uint32_t)u16(at + 2) << 16; }
};

// Takes one byte; the frame comes with the 0 that ends it. Bad frames are passed over without a word.
static const FrameIn *receive(uint8_t byte) {
  static uint8_t buffer[MLAB_MAX_WIRE];
  static uint8_t length;
  static bool overlong;
  static FrameIn frame;
  if (byte != 0) {
    if (length < sizeof(buffer)) buffer[length++] = byte;
    else overlong = true;
    return 0;
  }
  uint8_t stuffed = length;
  bool bad = overlong;
  length = 0;
  overlong = false;
  if (bad || stuffed == 0) return 0;
  uint8_t read = 0, written = 0;
  while (read < stuffed) {
    uint8_t code = buffer[read];
    if (code > stuffed - read) return 0;
    for (uint8_t k = 1; k < code; k++) buffer[written++] = buffer[read + k];
    read += code;
    if (read < stuffed) buffer[written++] = 0;
  }
  if (written < 3) return 0;
  uint16_t crc = buffer[written - 2] | (uint16_t)buffer[written - 1] << 8;
  if (crcOf(buffer, written - 2) != crc) return 0;
  frame.kind = buffer[0];
  frame.length = written - 3;
  frame.body = buffer + 1;
  return &frame;
}
