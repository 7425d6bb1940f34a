#include "ring.h"

#include <string.h>

void Ring::begin(uint8_t scan_bytes) {
    next_ = lost_ = 0;
    scan_bytes_ = scan_bytes;
    const uint16_t fit = Block::kPayload / scan_bytes;
    capacity_ = static_cast<uint8_t>(fit < 127 ? fit : 127);
    deepest_ = 0;
    waiting_ = false;
    filling().clear('D');
}

bool Ring::add(uint32_t number, const uint8_t* scan, uint16_t late) {
    lost_ += number - next_;
    next_ = number + 1;
    // The scans of a block are consecutive. Its own numbers tell, not the scan before this one:
    // that one may have found no room.
    const bool follows = filling().first_scan + filling().count == number;
    if (filling().count == capacity_ || (filling().count && !follows)) {
        if (waiting_) {
            ++lost_;
            return false;
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
    if (depth() > deepest_) deepest_ = depth();
    if (block.count == capacity_ && !waiting_) hand_over();
    return true;
}

void Ring::release() {
    waiting_ = false;
    if (filling().count == capacity_) hand_over();
}

void Ring::lose(uint8_t scans) {
    lost_ += scans;
    if (waiting_) waiting()->lost += scans;
    if (filling().count) filling().lost += scans;
}

void Ring::finish(uint32_t due) {
    lost_ += due - next_;
    next_ = due;
    if (filling().count && !waiting_) hand_over();
}

void Ring::abandon() {
    lost_ += depth();
    waiting_ = false;
    filling().count = 0;
}

uint8_t Ring::depth() const {
    const uint8_t whole = waiting_ ? blocks_[filling_ ^ 1]->count : 0;
    return static_cast<uint8_t>(whole + blocks_[filling_]->count);
}

void Ring::hand_over() {
    waiting_ = true;
    filling_ ^= 1;
    filling().clear('D');
}
