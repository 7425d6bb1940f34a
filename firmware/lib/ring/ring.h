#pragma once
#include <stdint.h>

#include "block.h"
#include "traits.h"

// Blocks between sampling and card: one is being filled while others wait to be written.
//
// A block is free again as soon as the card has taken its bytes, so that while the card is busy
// with them all blocks can fill: 2 × 37 scans of eight channels on the Nano, 8 × 37 on the Mega.
// Every scan that finds no place is counted.
template <uint8_t blocks>
class RingOf {
  public:
    static const uint8_t kBlocks = blocks;  // a power of two

    // Two of the blocks have other uses between sessions; `more` are those that have none.
    constexpr RingOf(Block& one, Block& other, Block* more = nullptr)
        : two_{&one, &other}, more_(more) {}

    void begin(uint8_t scan_bytes);

    // Take the scan; numbers that were skipped count as lost, and the scan itself if there is no
    // room.
    void add(uint32_t number, const uint8_t* scan, uint16_t late);

    // While none waits: a block without scans that waits now, before the one being filled.
    Block& insert(char kind);

    Block* waiting() { return waiting_ ? &at(oldest()) : nullptr; }
    void release();             // the card has taken the waiting block
    void lose(uint8_t scans);   // a block that was released has not reached the card after all
    void finish(uint32_t due);  // no scan follows: the last block may wait though it is not full
    void abandon();             // what is still here will never be written

    uint32_t due() const { return next_; }
    uint32_t lost() const { return lost_; }
    uint16_t depth() const;  // scans held now
    uint16_t deepest() const { return deepest_; }
    uint16_t room() const { return kBlocks * capacity_; }

  private:
    Block& at(uint8_t index) { return index < 2 ? *two_[index] : more_[index - 2]; }
    const Block& at(uint8_t index) const { return const_cast<RingOf*>(this)->at(index); }
    Block& filling() { return at(filling_); }
    // The waiting blocks are those before the one being filled.
    uint8_t oldest() const { return before(waiting_); }
    uint8_t before(uint8_t steps) const { return (filling_ - steps) & (kBlocks - 1); }
    bool spare() const { return waiting_ < kBlocks - 1; }  // one could wait besides
    void hand_over();

    Block* two_[2];
    Block* more_;
    uint32_t next_ = 0;  // number of the scan that is due next
    uint32_t lost_ = 0;
    uint16_t deepest_ = 0;
    uint8_t scan_bytes_ = 1;
    uint8_t capacity_ = 0;  // scans in a block
    uint8_t filling_ = 0;
    uint8_t waiting_ = 0;  // blocks
};

using Ring = RingOf<board::kRingBlocks>;
