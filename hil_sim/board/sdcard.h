// An SD card in SPI mode, backed by an image file, with its faults as plain configuration.
//
// It knows nothing of the AVR: bytes go in, bytes come out, time is told.
// Source: SD Specifications, Part 1, Physical Layer Simplified Specification 9.00, chapter 7
// "SPI Mode"; section numbers in sdcard.c refer to it.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { BLOCK_SIZE = 512, MAX_FAULTS = 4096 };

typedef enum { CARD_NONE, CARD_SDHC, CARD_SDSC, CARD_SD_V1 } CardKind;

// What happens to the write with this number, counted from 0 at every insertion of a card.
typedef enum {
    FAULT_STALL,   // value: additional busy time in cycles
    FAULT_REJECT,  // value: the data response token; nothing is stored
    FAULT_FLIP,    // value: the bit, 0 to 4095, that is stored inverted
    FAULT_CUT,     // value: bytes stored before the power fails; tail: what the rest becomes
} FaultKind;

typedef enum { TAIL_OLD, TAIL_ONES, TAIL_NOISE } Tail;

typedef struct {
    FaultKind kind;
    Tail tail;
    uint64_t write, value;
} Fault;

// A command that is not carried out, and its answer: the `nth` of this number, counted from 0 since
// the faults were set. 0xff: no answer.
typedef struct {
    uint8_t command, reply;
    uint64_t nth;
} BadReply;

// Board times; afterwards the card has lost its power and is new.
typedef struct {
    uint64_t from, to;
    bool over;
} Interval;

// Times in CPU cycles.
typedef struct {
    Fault faults[MAX_FAULTS];
    size_t fault_count;
    uint64_t pull_at;  // board time at which the card leaves the socket; 0: never
    bool write_protected;
    uint64_t write_busy;    // after every block
    uint64_t read_latency;  // before every block
    uint64_t start_up;      // from the first ACMD41 until the card is ready
    uint64_t sheet_latency;  // before CSD and CID
    bool ignores_crc;        // CMD59 is answered, and nothing else
    unsigned late_busy;      // bytes after chip select or a block before busy shows
    BadReply replies[MAX_FAULTS];
    size_t reply_fault_count;
    Interval gaps[MAX_FAULTS];  // the contacts are open
    size_t gap_count;
} CardConfig;

// One block as it was stored.
typedef struct {
    uint64_t cycle, block;
    uint8_t data[BLOCK_SIZE];
} JournalEntry;

typedef enum { CARD_READY, CARD_AWAITS_TOKEN, CARD_RECEIVES, CARD_SENDS } CardState;

typedef struct {
    CardKind kind;
    int image;  // file descriptor
    uint64_t blocks;
    uint32_t serial;  // in the card's identification
    CardConfig config;

    // Transfer
    bool selected, idle, crc_on, app_command, multiple, failed;
    CardState state;
    uint8_t command[6], buffer[BLOCK_SIZE + 2], replies[8];
    unsigned command_length, buffer_length, buffer_used, reply_count, reply_used, clocks;
    unsigned not_yet_busy;  // bytes for which the card does not show that it is busy
    uint64_t block, busy_until, data_at, ready_at;
    uint8_t status;  // second byte of R2

    // What an observer sees
    bool power_cut;  // a fault has cut the power of the whole board
    bool journal_on;
    JournalEntry* journal;
    size_t journal_count, journal_capacity;
    uint64_t writes, reads;
    uint64_t commands[64];  // of each number since the faults were set
    uint32_t violations;  // of the protocol, by the host
    const char* last_violation;
} SdCard;

// Put a card with this image into the socket, or, with CARD_NONE, take it out. False if the image
// cannot be opened.
bool sdcard_insert(SdCard* card, CardKind kind, const char* image);
void sdcard_power_on(SdCard* card);
void sdcard_select(SdCard* card, bool selected);

// One byte in each direction at board time `now`; `byte_cycles` is what it took.
uint8_t sdcard_exchange(SdCard* card, uint8_t in, uint64_t now, uint32_t byte_cycles);
