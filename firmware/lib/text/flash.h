#pragma once
// Text constants that stay in flash: on AVR a plain literal would be copied to RAM.
#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#define PSTR(text) (text)
#define pgm_read_byte(at) (*(at))
#endif

struct FlashChar;  // never defined: a pointer to flash must not be taken for one to RAM
#define FLASH(text) reinterpret_cast<const FlashChar*>(PSTR(text))

inline char flash_char(const FlashChar* text, int at) {
    return static_cast<char>(pgm_read_byte(reinterpret_cast<const char*>(text) + at));
}
