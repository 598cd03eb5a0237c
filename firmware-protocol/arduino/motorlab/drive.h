// The motor driver: PWM and direction, 0 V as brake (shorted) or as coast (open).
//
// Duty = |command| / supply. PWM low with the driver enabled shorts the motor (slow decay).
#pragma once

// The value for analogWrite. The Uno's pin 6 hangs on Timer0, whose fast PWM is on for value + 1 of 256
// steps; the Mega's on Timer4, whose phase-correct PWM is on for value of 255.
static uint8_t dutyFor(uint16_t sizeMv) {
  if (sizeMv >= SUPPLY_MV) return 255;
#if defined(__AVR_ATmega328P__)
  uint16_t steps = ((uint32_t)sizeMv * 256 + SUPPLY_MV / 2) / SUPPLY_MV;
  return steps == 0 ? 0 : steps - 1;
#else
  return ((uint32_t)sizeMv * 255 + SUPPLY_MV / 2) / SUPPLY_MV;
#endif
}

static bool coastAtZero;

static void driveCoastAtZero(bool coast) { coastAtZero = coast; }

// Puts the command out; true where the supply limits it.
static bool drive(int16_t commandMv) {
  uint16_t size = commandMv < 0 ? -(int32_t)commandMv : commandMv;
  bool saturated = size > SUPPLY_MV;
  uint8_t duty = dutyFor(size);
  digitalWrite(PIN_DRIVER_ENABLE, duty == 0 && coastAtZero ? LOW : HIGH);
  digitalWrite(PIN_DIRECTION, commandMv < 0 ? HIGH : LOW);
  analogWrite(PIN_PWM, duty);
  return saturated;
}

static void driveOff() {
  analogWrite(PIN_PWM, 0);
  digitalWrite(PIN_DIRECTION, LOW);
  digitalWrite(PIN_DRIVER_ENABLE, HIGH);
}

// Levels first, then the outputs: no pin shows a wrong one in between.
static void driveBegin() {
  digitalWrite(PIN_PWM, LOW);
  digitalWrite(PIN_DIRECTION, LOW);
  digitalWrite(PIN_DRIVER_ENABLE, HIGH);
  pinMode(PIN_PWM, OUTPUT);
  pinMode(PIN_DIRECTION, OUTPUT);
  pinMode(PIN_DRIVER_ENABLE, OUTPUT);
}
