#pragma once
#include <stdint.h>

#include "traits.h"

// A 512-byte block of a log file, as SPEC.md lays it out ("Log file").
struct Block {
    static const uint16_t kPayload = 486;

    char magic[4];
    char kind;
    uint8_t count;
    uint16_t late;
    uint32_t session;
    uint32_t sequence;
    uint32_t first_scan;
    uint32_t lost;
    uint8_t payload[kPayload];
    uint16_t crc;

    void clear(char new_kind);
    void seal(uint32_t session_id, uint32_t position);  // fills in magic, session, sequence, crc
    bool good(uint32_t session_id, uint32_t position) const;
};
static_assert(sizeof(Block) == 512, "a block is one sector");

// Bytes that a scan of `channels` sums takes.
inline uint8_t scan_size(uint8_t channels) {
    return static_cast<uint8_t>((board::kSumBits * channels + 7) / 8);
}

// Pack the sums whose bit in `mask` is set, kSumBits each, lowest first; returns the size in bytes.
uint8_t pack_scan(const board::Sum sums[board::kInputs], uint8_t mask, uint8_t* packed);
