#pragma once
#include "sums.h"

// All inputs converted at the same instant, summed over a scan.
class TogetherSampler : public Sums {
  public:
    // Begin at scan 0, `conversions` of each input per scan. Interrupt must be off.
    void start(uint8_t conversions) {
        length_ = conversions;
        position_ = 0;
        clear();
    }

    // Interrupt only: the results of one conversion of all inputs.
    void collect(const uint16_t codes[kInputs]) {
        for (uint8_t k = 0; k < kInputs; ++k) sums_[filling_][k] += codes[k];
        if (++position_ != length_) return;
        position_ = 0;
        finish_scan();
    }

    // Interrupt only: the reference's code; its own converter does not disturb the others.
    void collect_supply(uint16_t code) { supply_code_ = code; }

  private:
    uint8_t length_ = 0;  // of a scan
    uint8_t position_ = 0;
};
