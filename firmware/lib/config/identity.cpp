#include "identity.h"

#include <string.h>

#include "board.h"
#include "crc16.h"

// An erased EEPROM is all 0xFF, which no value below uses.
namespace {

struct Slot {
    uint16_t number;
    uint16_t crc;
};

const uint8_t kSlots = 0;  // two of them, the number's lowest bit says which
const uint8_t kDevice = 8;
const uint8_t kClock = 10;
const uint8_t kCalibration = 12;
const uint16_t kErased = 0xFFFF;

uint16_t read_word(uint8_t address) {
    uint16_t word;
    board::eeprom_read(address, &word, sizeof word);
    return word;
}

uint16_t slot_number(uint8_t index) {
    Slot slot;
    board::eeprom_read(static_cast<uint8_t>(kSlots + index * sizeof slot), &slot, sizeof slot);
    return slot.crc == crc16(&slot.number, sizeof slot.number) ? slot.number : 0;
}

}  // namespace

namespace identity {

uint16_t later(uint16_t one, uint16_t other) {
    if (!one || !other) return one | other;
    return static_cast<int16_t>(other - one) > 0 ? other : one;
}

uint16_t session_number() { return later(slot_number(0), slot_number(1)); }

void set_session_number(uint16_t number) {
    const Slot slot = {number, crc16(&number, sizeof number)};
    board::eeprom_write(static_cast<uint8_t>(kSlots + (number & 1) * sizeof slot), &slot,
                        sizeof slot);
}

uint16_t device() {
    const uint16_t word = read_word(kDevice);
    return word == kErased ? 0 : word;
}

void set_device(uint16_t number) { board::eeprom_write(kDevice, &number, sizeof number); }

void calibration(char text[kCalibrationSize]) {
    board::eeprom_read(kCalibration, text, kCalibrationSize);
    text[kCalibrationSize - 1] = 0;
    for (const char* at = text; *at; ++at) {
        if (*at < 0x20 || *at > 0x7E) text[0] = 0;  // erased, or another program's
    }
}

void set_calibration(const char* text) {
    char stored[kCalibrationSize] = {};
    strncpy(stored, text, kCalibrationSize - 1);
    board::eeprom_write(kCalibration, stored, sizeof stored);
}

bool clock_ppm(int16_t& ppm) {
    const uint16_t word = read_word(kClock);
    ppm = static_cast<int16_t>(word - kLargestPpm);
    return word <= 2u * kLargestPpm;
}

void set_clock_ppm(int16_t ppm) {
    const uint16_t word = static_cast<uint16_t>(ppm + kLargestPpm);
    board::eeprom_write(kClock, &word, sizeof word);
}

}  // namespace identity
