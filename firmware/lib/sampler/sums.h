#pragma once
#include <stdint.h>
#include <string.h>

#include "traits.h"

// Sums of a scan for every input, in two sets: the interrupt fills one while the main loop reads
// the other. How conversions come about is the sampler's.
class Sums {
  public:
    static const uint8_t kInputs = board::kInputs;

    // Whether the supply is read in the scan of this number.
    static bool reads_supply(uint32_t number) { return (static_cast<uint8_t>(number) & 31) == 16; }

    // Interrupt only: a conversion has not started, because the interrupt came too late.
    void note_late_trigger() {
        if (late_ != 0xFFFF) ++late_;
    }

    // Main loop: fetch a finished scan, its number and the late triggers up to it.
    bool take(board::Sum sums[kInputs], uint32_t& number, uint16_t& late) {
        if (!ready_) return false;
        __atomic_signal_fence(__ATOMIC_SEQ_CST);  // from here to `ready_ = false` the set is ours
        board::Sum* mine = sums_[filling_ ^ 1];
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

    // Main loop: code of the reference in the last scan that reads it, once that was taken.
    uint16_t supply_code() const { return supply_code_; }

    // Scans finished since start(), fetched or not. Interrupt must be off.
    uint32_t due() const { return due_; }

  protected:
    // Begin at scan 0. Interrupt must be off.
    void clear() {
        due_ = 0;
        late_ = 0;
        ready_ = false;
        memset(sums_, 0, sizeof sums_);
    }

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

    board::Sum sums_[2][kInputs] = {};
    uint32_t due_ = 0;
    uint32_t ready_number_ = 0;
    uint16_t ready_late_ = 0;
    uint16_t late_ = 0;
    uint16_t supply_code_ = 0;
    uint8_t filling_ = 0;  // the interrupt's set of sums
    volatile bool ready_ =
        false;  // the other set holds a scan: set by the interrupt, cleared by take()
};
