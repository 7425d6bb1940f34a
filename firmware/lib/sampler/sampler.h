#pragma once
#include "sums.h"

// Eight inputs, converted one after another in palindrome order, summed over a scan.
//
// Order 0…7, 7…0, repeated: each input's conversions then lie symmetrically about the middle of the
// scan, so that all eight sums have the same mean sampling instant.
//
// One scan in 32 leaves time for a conversion of the internal reference, which tells the supply:
// its other conversions move apart in the middle, as much before it as behind, so that the mean
// instants stay (SPEC.md, "The supply").
class Sampler : public Sums {
  public:
    static const uint8_t kSupply = 8;      // in place of an input: the internal reference
    static const uint16_t kClocks = 2500;  // from a conversion to the next, 156.25 µs

    // The input of conversion number `position` of a scan.
    static uint8_t input(uint8_t position) {
        position &= 15;
        return position < 8 ? position : 15 - position;
    }

    // Begin at scan 0, `conversions` (8, 4 or 2) of each input per scan. Interrupt must be off.
    void start(uint8_t conversions) {
        length_ = conversions * kInputs;
        squeeze_ = conversions == 8 ? 1 : conversions == 4 ? 2 : 3;
        supply_scan_ = reading_ = false;
        position_ = 0;
        clear();
    }

    // Interrupt only, when a conversion has ended: the input of the next one, or kSupply.
    uint8_t advance() {
        if (reading_) {
            reading_ = false;
            return input(position_);
        }
        if (++position_ == length_) position_ = 0;
        reading_ = supply_scan_ && position_ == length_ / 2;
        return reading_ ? kSupply : input(position_);
    }

    // Interrupt only, after advance(): clocks from the start of the ended conversion to the next.
    uint16_t clocks() const {
        if (!supply_scan_ || !position_) return kClocks;
        const uint16_t closer = static_cast<uint16_t>(100 * squeeze_);
        return reading_ ? static_cast<uint16_t>((length_ - 1) * closer) : kClocks - closer;
    }

    // Interrupt only, after advance(): input and result of the conversion that has ended.
    void collect(uint8_t ended, uint16_t code) {
        if (ended == kSupply) {
            supply_code_ = code;
            return;
        }
        sums_[filling_][ended] += code;
        if (position_) return;
        finish_scan();
        supply_scan_ = reads_supply(due_);
    }

    // Interrupt only, after advance() has told kSupply: whether a board that has a temperature's
    // input reads that in its place, as in every second such scan.
    bool temperature_next() const { return board::kHasBeside && static_cast<uint8_t>(due_) & 32; }

  private:
    uint8_t length_ = 0;   // of a scan
    uint8_t squeeze_ = 0;  // by how many 100 clocks conversions are closer when the supply is read
    uint8_t position_ = 0;
    bool supply_scan_ = false;  // this scan reads the supply
    bool reading_ = false;      // the conversion under way is the supply's
};
