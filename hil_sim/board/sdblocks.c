#include "sdblocks.h"

#include <string.h>
#include <unistd.h>

#include "trace.h"

uint8_t sd_crc7(const uint8_t* bytes, unsigned count) {
    uint8_t crc = 0;
    for (unsigned i = 0; i < count; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = (uint8_t)(crc & 0x80 ? crc << 1 ^ 0x12 : crc << 1);
    }
    return crc | 1;
}

uint16_t sd_crc16(const uint8_t* bytes, unsigned count) {
    uint16_t crc = 0;
    for (unsigned i = 0; i < count; i++) {
        crc ^= (uint16_t)(bytes[i] << 8);
        for (int bit = 0; bit < 8; bit++)
            crc = (uint16_t)(crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1);
    }
    return crc;
}

bool sd_read(const SdCard* card, uint64_t block, uint8_t* data) {
    return pread(card->image, data, BLOCK_SIZE, (off_t)block * BLOCK_SIZE) == BLOCK_SIZE;
}

static bool write_image(SdCard* card, uint64_t now, const uint8_t* data) {
    if (pwrite(card->image, data, BLOCK_SIZE, (off_t)card->block * BLOCK_SIZE) != BLOCK_SIZE)
        return false;
    if (card->journal_on) {
        card->journal = grown(card->journal, &card->journal_capacity, card->journal_count + 1,
                              sizeof *card->journal);
        JournalEntry* entry = &card->journal[card->journal_count++];
        *entry = (JournalEntry){.cycle = now, .block = card->block};
        memcpy(entry->data, data, BLOCK_SIZE);
    }
    return true;
}

// The power fails while this block is written: the first bytes are new, the rest is as it happens.
static void tear(const SdCard* card, const Fault* fault, uint8_t* data) {
    uint8_t rest[BLOCK_SIZE];
    sd_read(card, card->block, rest);
    for (unsigned i = 0; i < BLOCK_SIZE && fault->tail != TAIL_OLD; i++)
        rest[i] = fault->tail == TAIL_ONES ? 0xff : (uint8_t)((i * 2654435761u + 12345u) >> 21);
    memcpy(data + fault->value, rest + fault->value, BLOCK_SIZE - fault->value);
}

uint8_t sd_store(SdCard* card, uint64_t now, uint64_t* busy) {
    uint64_t number = card->writes++;
    uint8_t* data = card->buffer;
    uint16_t crc = (uint16_t)(data[BLOCK_SIZE] << 8 | data[BLOCK_SIZE + 1]);
    if (card->crc_on && crc != sd_crc16(data, BLOCK_SIZE)) return TOKEN_CRC_ERROR;
    if (card->config.write_protected) {
        card->status |= R2_WRITE_PROTECT;
        return TOKEN_WRITE_ERROR;
    }
    if (card->failed || card->block >= card->blocks) return TOKEN_WRITE_ERROR;

    *busy = card->config.write_busy;
    for (size_t i = 0; i < card->config.fault_count; i++) {
        const Fault* fault = &card->config.faults[i];
        if (fault->write != number) continue;
        switch (fault->kind) {
            case FAULT_STALL:
                *busy += fault->value;
                break;
            case FAULT_REJECT:
                *busy = 0;
                return (uint8_t)fault->value;
            case FAULT_FLIP:
                data[fault->value / 8] ^= (uint8_t)(1u << fault->value % 8);
                break;
            case FAULT_CUT:
                card->power_cut = true;
                tear(card, fault, data);
                break;
        }
    }
    if (!write_image(card, now, data)) return TOKEN_WRITE_ERROR;
    card->block++;
    return TOKEN_ACCEPTED;
}

static void finish_register(uint8_t* bytes) { bytes[15] = sd_crc7(bytes, 15); }

void sd_csd(const SdCard* card, uint8_t* csd) {
    memset(csd, 0, 16);
    csd[1] = 0x0e;  // TAAC
    csd[3] = 0x32;  // TRAN_SPEED: 25 MHz
    csd[4] = 0x5b;  // CCC and READ_BL_LEN = 9
    csd[5] = 0x59;
    csd[10] = 0x7f;  // ERASE_BLK_EN, SECTOR_SIZE
    csd[11] = 0x80;
    csd[12] = 0x0a;  // R2W_FACTOR, WRITE_BL_LEN = 9
    csd[13] = 0x40;
    if (card->kind == CARD_SDHC) {
        csd[0] = 0x40;  // version 2
        uint32_t size = (uint32_t)(card->blocks / 1024 - 1);
        csd[7] = (uint8_t)(size >> 16 & 0x3f);
        csd[8] = (uint8_t)(size >> 8);
        csd[9] = (uint8_t)size;
    } else {
        uint32_t size = (uint32_t)(card->blocks / 512 - 1);  // C_SIZE_MULT = 7
        csd[6] = (uint8_t)(size >> 10 & 0x03);
        csd[7] = (uint8_t)(size >> 2);
        csd[8] = (uint8_t)((size & 3) << 6);
        csd[9] = 0x03;
        csd[10] = 0xff;
    }
    if (card->config.write_protected) csd[14] |= 0x10;  // TMP_WRITE_PROTECT
    finish_register(csd);
}

void sd_cid(const SdCard* card, uint8_t* cid) {
    memcpy(cid, "\x00HSCARD0\x10\x00\x00\x00\x00\x01\x61\x00", 16);
    for (int i = 0; i < 4; i++) cid[9 + i] = (uint8_t)(card->serial >> (24 - 8 * i));
    finish_register(cid);
}
