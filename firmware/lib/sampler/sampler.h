#pragma once
#include <stdint.h>
#include <string.h>

// Eight inputs, converted one after another in palindrome order, summed over a scan.
//
// Order 0…7, 7…0, repeated: each input's conversions then lie symmetrically about the middle of the
// scan, so that all eight sums have the same mean sampling instant. Two sets of sums: the interrupt
// fills one while the main loop reads the other.
class Sampler {
  public:
    static const uint8_t kInputs = 8;

    // The input of conversion number `position` of a scan.
    static uint8_t input(uint8_t position) {
        position &= 15;
        return position < 8 ? position : 15 - position;
    }

    // Begin at scan 0, `conversions` (8, 4 or 2) of each input per scan. Interrupt must be off.
    void start(uint8_t conversions) {
        length_ = conversions * kInputs;
        position_ = 0;
        due_ = 0;
        late_ = 0;
        ready_ = false;
        memset(sums_, 0, sizeof sums_);
    }

    // Interrupt only: the result of a conversion; returns the input of the next one.
    uint8_t collect(uint16_t code) {
        sums_[filling_][input(position_)] += code;
        if (++position_ == length_) {
            position_ = 0;
            finish_scan();
        }
        return input(position_);
    }

    // Interrupt only: a conversion has not started, because the one before was collected too late.
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
    }

    uint16_t sums_[2][kInputs] = {};
    uint32_t due_ = 0;
    uint32_t ready_number_ = 0;
    uint16_t ready_late_ = 0;
    uint16_t late_ = 0;
    uint8_t length_ = 0;  // of a scan
    uint8_t position_ = 0;
    uint8_t filling_ = 0;  // the interrupt's set of sums
    volatile bool ready_ =
        false;  // the other set holds a scan: set by the interrupt, cleared by take()
};
