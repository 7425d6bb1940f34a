#pragma once
#include <stdint.h>

// What the parts must know of a board in numbers: of its converter, its memory, and the inputs it
// has beside the eight. board.h declares what they ask of it; nothing else depends on the board.
namespace board {

#ifdef BOARD_SIMULTANEOUS
// All eight inputs at the same instant, by a 16-bit converter with a clock of its own (AD7606
// class) beside a controller with RAM for many sectors.
const char kFormat = '2';
using Sum = uint32_t;
const uint8_t kCodeBits = 16;
const uint8_t kSumBits = 22;           // of 64 conversions
const uint16_t kConversionsHz = 6400;  // of each input
const uint32_t kReferenceMv = 1250;    // whose code tells the supply
const uint8_t kRingBlocks = 32;
const bool kHasBeside = true;
#else
// One ten-bit converter for all inputs in turn: ATmega328P and 2560 at 16 MHz.
const char kFormat = '1';
using Sum = uint16_t;
const uint8_t kCodeBits = 10;
const uint8_t kSumBits = 13;  // of 8 conversions
const uint16_t kConversionsHz = 800;
const uint32_t kReferenceMv = 1100;  // the chip's own
#ifdef __AVR_ATmega2560__
const uint8_t kRingBlocks = 8;
const bool kHasBeside = true;
#else
const uint8_t kRingBlocks = 2;
const bool kHasBeside = false;
#endif
#endif

const uint8_t kInputs = 8;
const uint8_t kScanBytes = (kInputs * kSumBits + 7) / 8;  // of a scan of all inputs
const uint16_t kLargestCode = (1ul << kCodeBits) - 1;

}  // namespace board
