#pragma once
#include <stdint.h>

// What belongs to this instrument, not to the card: kept in the EEPROM.
namespace identity {

const uint8_t kCalibrationSize = 16;  // the last character is always 0
const int16_t kLargestPpm = 20000;

// Of two sessions' numbers the later one: 65535 is followed by 1, and 0 is none.
uint16_t later(uint16_t one, uint16_t other);

// Number of the last session, 0: none yet. Power may fail while the next one is being stored: there
// are two places, the older one is overwritten, and a number that is not whole does not count.
uint16_t session_number();
void set_session_number(uint16_t number);

uint16_t device();  // 0: not set
void set_device(uint16_t number);

void calibration(char text[kCalibrationSize]);
void set_calibration(const char* text);

bool clock_ppm(int16_t& ppm);  // false: never measured
void set_clock_ppm(int16_t ppm);

}  // namespace identity
