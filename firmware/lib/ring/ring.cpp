#include "ring.h"

#include <string.h>

template <uint8_t blocks>
void RingOf<blocks>::begin(uint8_t scan_bytes) {
    next_ = lost_ = 0;
    scan_bytes_ = scan_bytes;
    const uint16_t fit = Block::kPayload / scan_bytes;
    capacity_ = static_cast<uint8_t>(fit < 127 ? fit : 127);
    deepest_ = 0;
    waiting_ = 0;
    filling().clear('D');
}

template <uint8_t blocks>
void RingOf<blocks>::add(uint32_t number, const uint8_t* scan, uint16_t late) {
    lost_ += number - next_;
    next_ = number + 1;
    // The scans of a block are consecutive. Its own numbers tell, not the scan before this one:
    // that one may have found no room.
    const bool follows = filling().first_scan + filling().count == number;
    if (filling().count == capacity_ || (filling().count && !follows)) {
        if (!spare()) {
            ++lost_;
            return;
        }
        hand_over();
    }
    Block& block = filling();
    if (!block.count) {
        block.first_scan = number;
        block.lost = lost_;
    }
    memcpy(block.payload + block.count * scan_bytes_, scan, scan_bytes_);
    ++block.count;
    block.late = late;
    const uint16_t held = depth();
    if (held > deepest_) deepest_ = held;
    if (block.count == capacity_ && spare()) hand_over();
}

template <uint8_t blocks>
Block& RingOf<blocks>::insert(char kind) {
    const Block& next = filling();
    waiting_ = 1;
    Block& block = *waiting();
    block.clear(kind);
    block.first_scan = next.count ? next.first_scan : next_;
    block.lost = next.count ? next.lost : lost_;
    block.late = next.late;
    return block;
}

template <uint8_t blocks>
void RingOf<blocks>::release() {
    --waiting_;
    if (filling().count == capacity_) hand_over();
}

template <uint8_t blocks>
void RingOf<blocks>::lose(uint8_t scans) {
    lost_ += scans;
    for (uint8_t k = waiting_; k; --k) at(before(k)).lost += scans;
    if (filling().count) filling().lost += scans;
}

template <uint8_t blocks>
void RingOf<blocks>::finish(uint32_t due) {
    lost_ += due - next_;
    next_ = due;
    if (filling().count && spare()) hand_over();
}

template <uint8_t blocks>
void RingOf<blocks>::abandon() {
    lost_ += depth();
    waiting_ = 0;
    filling().count = 0;
}

template <uint8_t blocks>
uint16_t RingOf<blocks>::depth() const {
    uint16_t scans = at(filling_).count;
    for (uint8_t k = waiting_; k; --k) scans += at(before(k)).count;
    return scans;
}

template <uint8_t blocks>
void RingOf<blocks>::hand_over() {
    const uint16_t late = filling().late;
    ++waiting_;
    filling_ = (filling_ + 1) & (kBlocks - 1);
    filling().clear('D');
    filling().late = late;
}

template class RingOf<2>;
template class RingOf<8>;
template class RingOf<32>;
