#pragma once
#include <stdint.h>

#include "block.h"

// Two blocks between sampling and card: one is being filled while the other waits to be written.
//
// A block is free again as soon as the card has taken its bytes, so that while the card is busy
// with them both blocks can fill: 2 × 37 scans of eight channels. Every scan that finds no place is
// counted.
class Ring {
  public:
    Ring(Block& one, Block& other) : blocks_{&one, &other} {}

    void begin(uint8_t scan_bytes);

    // Take the scan; numbers that were skipped count as lost. False if there was no room.
    bool add(uint32_t number, const uint8_t* scan, uint16_t late);

    Block* waiting() { return waiting_ ? blocks_[filling_ ^ 1] : nullptr; }
    void release();             // the card has taken the waiting block
    void lose(uint8_t scans);   // a block that was released has not reached the card after all
    void finish(uint32_t due);  // no scan follows: the last block may wait though it is not full
    void abandon();             // what is still here will never be written

    uint32_t due() const { return next_; }
    uint32_t lost() const { return lost_; }
    uint8_t depth() const;  // scans held now
    uint8_t deepest() const { return deepest_; }
    uint8_t room() const { return static_cast<uint8_t>(2 * capacity_); }

  private:
    Block& filling() { return *blocks_[filling_]; }
    void hand_over();

    Block* blocks_[2];
    uint32_t next_ = 0;  // number of the scan that is due next
    uint32_t lost_ = 0;
    uint8_t scan_bytes_ = 1;
    uint8_t capacity_ = 0;  // scans in a block
    uint8_t deepest_ = 0;
    uint8_t filling_ = 0;
    bool waiting_ = false;
};
