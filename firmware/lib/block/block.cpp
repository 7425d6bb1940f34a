#include "block.h"

#include <stddef.h>
#include <string.h>

#include "crc16.h"

namespace {

const uint16_t kChecked = offsetof(Block, crc);

bool has_magic(const Block& block) {
    return block.magic[0] == 'H' && block.magic[1] == 'O' && block.magic[2] == 'P' &&
           block.magic[3] == board::kFormat;
}

}  // namespace

void Block::clear(char new_kind) {
    memset(this, 0, sizeof *this);
    kind = new_kind;
}

void Block::seal(uint32_t session_id, uint32_t position) {
    magic[0] = 'H';
    magic[1] = 'O';
    magic[2] = 'P';
    magic[3] = board::kFormat;
    session = session_id;
    sequence = position;
    crc = crc16(this, kChecked);
}

bool Block::good(uint32_t session_id, uint32_t position) const {
    return has_magic(*this) && session == session_id && sequence == position &&
           crc == crc16(this, kChecked);
}

uint8_t pack_scan(const board::Sum sums[board::kInputs], uint8_t mask, uint8_t* packed) {
    uint32_t bits = 0;
    uint8_t held = 0;  // bits that wait in `bits`
    uint8_t size = 0;
    const board::Sum most = static_cast<board::Sum>((1ul << board::kSumBits) - 1);
    for (uint8_t k = 0; k < board::kInputs; ++k) {
        if (!(mask >> k & 1)) continue;
        bits |= static_cast<uint32_t>(sums[k] & most) << held;
        for (held += board::kSumBits; held >= 8; held -= 8, bits >>= 8) {
            packed[size++] = static_cast<uint8_t>(bits);
        }
    }
    if (held) packed[size++] = static_cast<uint8_t>(bits);
    return size;
}
