#pragma once
#include <stddef.h>
#include <stdint.h>
#ifdef __AVR__
#include <util/crc16.h>
#endif

// CRC-16/XMODEM: polynomial 0x1021, start 0. Blocks, frames, commands and the SD card's data use
// it.

inline uint16_t crc16_update(uint16_t crc, uint8_t byte) {
#ifdef __AVR__
    return _crc_xmodem_update(crc, byte);  // in assembler, no slower than a byte's way to the card
#else
    crc ^= static_cast<uint16_t>(byte << 8);
    for (int bit = 0; bit < 8; ++bit) {
        crc = static_cast<uint16_t>(crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1);
    }
    return crc;
#endif
}

inline uint16_t crc16(const void* data, size_t size) {
    const uint8_t* byte = static_cast<const uint8_t*>(data);
    uint16_t crc = 0;
    while (size--) crc = crc16_update(crc, *byte++);
    return crc;
}
