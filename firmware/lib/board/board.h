#pragma once
#include <stdint.h>

#include "flash.h"
#include "traits.h"

class Beside;
class Link;
class Sampler;
class TogetherSampler;

// What the hardware-independent parts need of the board, traits.h its numbers. avr.cpp implements
// it for the ATmega328P and 2560; the tests on a PC bring implementations of their own, one of them
// for a board whose converter is another.
namespace board {

// Time and life
uint32_t milliseconds();
uint16_t dice();  // two bytes that differ from start to start
void feed_watchdog();
const FlashChar* reset_cause();
extern uint32_t unfinished;  // id of the session that a reset shall not end; none, 0, at power-up

// SD card
void card_select(bool selected);
void spi_fast(bool fast);  // 4 MHz instead of the 250 kHz that a card needs to wake up
uint8_t spi_exchange(uint8_t sent);
uint16_t spi_send(const uint8_t* data, uint16_t size);  // both return the data's CRC
uint16_t spi_receive(uint8_t* data, uint16_t size);     // nullptr: data are not kept

// EEPROM
void eeprom_read(uint8_t address, void* data, uint8_t size);
void eeprom_write(uint8_t address, const void* data, uint8_t size);

// Converter; its interrupt's end is the board's
#ifdef BOARD_SIMULTANEOUS
using Converter = TogetherSampler;
#else
using Converter = Sampler;
#endif
extern Converter sampler;
void sample(
    uint8_t conversions);   // of each input in a scan; 0 stops. The sensors' self-test is off
void self_test(bool on);    // of all sensors, until something else is sampled
uint16_t reference_code();  // of the internal reference; only while nothing is sampled
extern Beside beside;       // where traits.h says that there is such a thing

// Serial line; its interrupts' ends are the board's: they fetch bytes from Link::transmit() until
// there are none
extern Link serial;
void start_transmitter();

}  // namespace board
