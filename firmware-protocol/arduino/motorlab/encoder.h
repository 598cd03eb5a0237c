// Quadrature decoding, all four edges, by the external interrupts of pins 2 (A) and 3 (B).
//
// A leads B: counts go up. Where both channels have changed since the last interrupt an edge was missed,
// and where none has, one channel went to and fro: the counts stay, and the error is remembered until the
// next sample. Three edges missed look like one the other way, but then the other channel's interrupt
// finds nothing changed: that is an error, too, so that no loss goes by in silence.
#pragma once

static volatile int32_t encoderCounts;
static volatile bool encoderError;
static volatile uint8_t encoderState;  // B and A as the two lowest bits

#if defined(__AVR_ATmega328P__)
#define ENCODER_VECT_A INT0_vect
#define ENCODER_VECT_B INT1_vect
static inline uint8_t encoderPins() { return (PIND >> 2) & 3; }
#else
#define ENCODER_VECT_A INT4_vect
#define ENCODER_VECT_B INT5_vect
static inline uint8_t encoderPins() { return (PINE >> 4) & 3; }
#endif

ISR(ENCODER_VECT_A) {
  uint8_t now = encoderPins();
  uint8_t before = encoderState;
  encoderState = now;
  uint8_t changed = now ^ before;
  if (changed == 3 || changed == 0) {
    encoderError = true;
  } else {
    // Going up the states are 00, 01, 11, 10: A changes to differ from B, or B changes to equal A.
    bool equal = (now == 0) || (now == 3);
    if ((changed == 1) != equal) encoderCounts++;
    else encoderCounts--;
  }
}
ISR(ENCODER_VECT_B, ISR_ALIASOF(ENCODER_VECT_A));

static void encoderBegin() {
  pinMode(PIN_ENCODER_A, INPUT_PULLUP);
  pinMode(PIN_ENCODER_B, INPUT_PULLUP);
  encoderState = encoderPins();
#if defined(__AVR_ATmega328P__)
  EICRA = (EICRA & 0xF0) | _BV(ISC00) | _BV(ISC10);  // any edge
  EIFR = _BV(INTF0) | _BV(INTF1);
  EIMSK |= _BV(INT0) | _BV(INT1);
#else
  EICRB = (EICRB & 0xF0) | _BV(ISC40) | _BV(ISC50);
  EIFR = _BV(INTF4) | _BV(INTF5);
  EIMSK |= _BV(INT4) | _BV(INT5);
#endif
}
