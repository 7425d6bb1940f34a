// Inside the card: its blocks, its registers and its check sums.
#pragma once

#include "sdcard.h"

enum {
    TOKEN_ACCEPTED = 0xe5,  // data response, 7.3.3.1
    TOKEN_CRC_ERROR = 0xeb,
    TOKEN_WRITE_ERROR = 0xed,
    R2_WRITE_PROTECT = 0x20,  // second byte of R2, 7.3.2.3
    R2_OUT_OF_RANGE = 0x80,
};

// CRC7 with the end bit, as it stands in the sixth byte of a command (4.5).
uint8_t sd_crc7(const uint8_t* bytes, unsigned count);
uint16_t sd_crc16(const uint8_t* bytes, unsigned count);

bool sd_read(const SdCard* card, uint64_t block, uint8_t* data);

// Store the block in card->buffer at card->block with whatever fault is due. Returns the data
// response token, and the busy time in *busy.
uint8_t sd_store(SdCard* card, uint64_t now, uint64_t* busy);

// Card-specific data (5.3) and card identification (5.2), 16 bytes each.
void sd_csd(const SdCard* card, uint8_t* csd);
void sd_cid(const SdCard* card, uint8_t* cid);
