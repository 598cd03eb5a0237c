// Settings of a lab: the motor's encoder, the supply, the pins.
#pragma once

#define COUNTS_PER_REV 720UL  // encoder counts per turn of the shaft, all four edges counted
#define SUPPLY_MV 4500        // driver supply in mV: full PWM

#define PIN_ENCODER_A 2       // both must stay: they are the boards' external interrupts
#define PIN_ENCODER_B 3
#define PIN_PWM 6
#define PIN_DIRECTION 12
#define PIN_DRIVER_ENABLE 8   // low: the driver lets go of the motor (coast); leave open if it has none
#define PIN_OVERRUN_LED 13

#define FIRMWARE_MAJOR 1
#define FIRMWARE_MINOR 0
#define SHORTEST_SAMPLE_TIME_US 100
#define LINK_MARGIN_MS 20     // the motor stops this much before the half second is over

#if defined(__AVR_ATmega328P__)
#define BOARD_NAME "uno"
#define PROFILE_SEGMENTS 200
#elif defined(__AVR_ATmega2560__)
#define BOARD_NAME "mega"
#define PROFILE_SEGMENTS 1000
#else
#error "motorlab runs on the Arduino Uno (ATmega328P) and the Mega 2560"
#endif
