#pragma once
#include <stdint.h>
#include <string.h>

// Eight inputs, converted one after another in palindrome order, summed over a scan.
//
// Order 0…7, 7…0, repeated: each input's conversions then lie symmetrically about the middle of the
// scan, so that all eight sums have the same mean sampling instant. Two sets of sums: the interrupt
// fills one while the main loop reads the other.
//
// One scan in 32 leaves time for a conversion of the internal reference, which tells the supply:
// its other conversions move apart in the middle, as much before it as behind, so that the mean
// instants stay (SPEC.md, "The supply").
class Sampler {
  public:
    static const uint8_t kInputs = 8;
    static const uint8_t kSupply = 8;      // in place of an input: the internal reference
    static const uint16_t kClocks = 2500;  // from a conversion to the next, 156.25 µs

    // Whether the supply is read in the scan of this number.
    static bool reads_supply(uint32_t number) { return (static_cast<uint8_t>(number) & 31) == 16; }

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
        due_ = 0;
        late_ = 0;
        ready_ = false;
        memset(sums_, 0, sizeof sums_);
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
        if (!position_) finish_scan();
    }

    // Interrupt only: a conversion has not started, because the interrupt came too late.
    void note_late_trigger() {
        if (late_ != 0xFFFF) ++late_;
    }

    // Main loop: fetch a finished scan, its number and the late triggers up to it.
    bool take(uint16_t sums[kInputs], uint32_t& number, uint16_t& late) {
        if (!ready_) return false;
        __atomic_signal_fence(__ATOMIC_SEQ_CST);  // from here to `ready_ = false` the set is ours
        uint16_t* mine = sums_[filling_ ^ 1];
        for (uint8_t k = 0; k < kInputs; ++k) {
            sums[k] = mine[k];
            mine[k] = 0;
        }
        number = ready_number_;
        late = ready_late_;
        __atomic_signal_fence(__ATOMIC_SEQ_CST);
        ready_ = false;
        return true;
    }

    // Main loop: code of the internal reference in the last scan that reads it, once that was
    // taken.
    uint16_t supply_code() const { return supply_code_; }

    // Scans finished since start(), fetched or not. Interrupt must be off.
    uint32_t due() const { return due_; }

  private:
    void finish_scan() {
        if (ready_) {  // the main loop is a whole scan late: this one is lost, its number tells
            for (uint8_t k = 0; k < kInputs; ++k) sums_[filling_][k] = 0;
        } else {
            filling_ ^= 1;
            ready_number_ = due_;
            ready_late_ = late_;
            ready_ = true;
        }
        ++due_;
        supply_scan_ = reads_supply(due_);
    }

    uint16_t sums_[2][kInputs] = {};
    uint32_t due_ = 0;
    uint32_t ready_number_ = 0;
    uint16_t ready_late_ = 0;
    uint16_t late_ = 0;
    uint16_t supply_code_ = 0;
    uint8_t length_ = 0;   // of a scan
    uint8_t squeeze_ = 0;  // by how many 100 clocks conversions are closer when the supply is read
    uint8_t position_ = 0;
    uint8_t filling_ = 0;       // the interrupt's set of sums
    bool supply_scan_ = false;  // this scan reads the supply
    bool reading_ = false;      // the conversion under way is the supply's
    volatile bool ready_ =
        false;  // the other set holds a scan: set by the interrupt, cleared by take()
};
