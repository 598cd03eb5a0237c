// The motor driver: PWM and direction, 0 V as brake (shorted) or as coast (open).
//
// Duty = |command| / supply in 255 steps. PWM low with the driver enabled shorts the motor (slow decay).
#pragma once

static bool coastAtZero;

static void driveCoastAtZero(bool coast) { coastAtZero = coast; }

// Puts the command out; true where the supply limits it.
static bool drive(int16_t commandMv) {
  uint16_t size = commandMv < 0 ? -(int32_t)commandMv : commandMv;
  bool saturated = size > SUPPLY_MV;
  uint8_t duty = saturated ? 255 : (uint8_t)(((uint32_t)size * 255 + SUPPLY_MV / 2) / SUPPLY_MV);
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

static void driveBegin() {
  digitalWrite(PIN_PWM, LOW);
  pinMode(PIN_PWM, OUTPUT);
  pinMode(PIN_DIRECTION, OUTPUT);
  pinMode(PIN_DRIVER_ENABLE, OUTPUT);
  driveOff();
}
