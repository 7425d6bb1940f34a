#include "sdcard.h"

#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "sdblocks.h"

enum {
    R1_IDLE = 0x01,
    R1_ILLEGAL = 0x04,
    R1_CRC = 0x08,
    R1_PARAMETER = 0x40,
    OCR_HIGH_CAPACITY = 0x40,
    OCR_POWERED_UP = 0x80,
    HOST_HIGH_CAPACITY = 0x40000000,
    TOKEN_SINGLE = 0xfe,  // 7.3.3.2
    TOKEN_MULTIPLE = 0xfc,
    TOKEN_STOP = 0xfd,
    FLOATING = 0xff,
    BUSY = 0x00,
    CLOCKS_BEFORE_FIRST_COMMAND = 74,  // 6.4.1.1
    SLOW_BYTE_CYCLES = 320,            // 8 bits at 400 kHz: 6.6.6
};

static void violation(SdCard* card, const char* what) {
    card->violations++;
    card->last_violation = what;
}

bool sdcard_insert(SdCard* card, CardKind kind, const char* image) {
    if (card->kind != CARD_NONE) close(card->image);
    card->kind = CARD_NONE;
    card->writes = card->reads = 0;
    if (kind == CARD_NONE) return true;
    struct stat status;
    card->image = open(image, O_RDWR | O_CLOEXEC);
    if (card->image < 0 || fstat(card->image, &status) != 0) return false;
    card->kind = kind;
    card->blocks = (uint64_t)status.st_size / BLOCK_SIZE;
    sdcard_power_on(card);
    return true;
}

void sdcard_power_on(SdCard* card) {
    card->idle = true;
    card->crc_on = card->app_command = card->multiple = card->failed = card->power_cut = false;
    card->state = CARD_READY;
    card->command_length = card->reply_count = card->reply_used = card->clocks = 0;
    card->busy_until = card->ready_at = 0;
    card->status = 0;
}

void sdcard_select(SdCard* card, bool selected) {
    if (card->selected && !selected) {
        if (card->state == CARD_RECEIVES) violation(card, "deselected inside a data block");
        if (card->state != CARD_AWAITS_TOKEN || !card->multiple) card->state = CARD_READY;
        card->command_length = card->reply_count = card->reply_used = 0;
    }
    card->selected = selected;
    card->not_yet_busy = card->config.late_busy;
}

static void reply(SdCard* card, uint8_t byte) { card->replies[card->reply_count++] = byte; }

static void begin_reply(SdCard* card, uint8_t r1) {
    card->reply_count = card->reply_used = 0;
    reply(card, FLOATING);  // N_CR of one byte
    reply(card, r1);
}

static void begin_sending(SdCard* card, unsigned length, uint64_t now) {
    uint16_t crc = sd_crc16(card->buffer, length);
    card->buffer[length] = (uint8_t)(crc >> 8);
    card->buffer[length + 1] = (uint8_t)crc;
    card->buffer_length = length + 2;
    card->buffer_used = 0;
    card->data_at =
        now + (length == BLOCK_SIZE ? card->config.read_latency : card->config.sheet_latency);
    card->state = CARD_SENDS;
}

static void send_block(SdCard* card, uint64_t now) {
    if (card->block >= card->blocks || !sd_read(card, card->block, card->buffer)) {
        card->status |= R2_OUT_OF_RANGE;
        card->state = CARD_READY;
        return;
    }
    card->reads++;
    card->block++;
    begin_sending(card, BLOCK_SIZE, now);
}

// ACMD41: a card that needs the host's consent to high capacity waits for it for ever (7.2.1).
static void initialise(SdCard* card, uint32_t argument, uint64_t now) {
    if (!card->ready_at) card->ready_at = now + card->config.start_up;
    bool accepted = card->kind != CARD_SDHC || argument & HOST_HIGH_CAPACITY;
    if (accepted && now >= card->ready_at) card->idle = false;
    begin_reply(card, card->idle ? R1_IDLE : 0);
}

static void begin_transfer(SdCard* card, unsigned number, uint32_t argument, uint64_t now) {
    bool by_block = card->kind == CARD_SDHC;
    uint64_t block = by_block ? argument : argument / BLOCK_SIZE;
    bool aligned = by_block || argument % BLOCK_SIZE == 0;
    if (block >= card->blocks || !aligned) {
        card->status |= R2_OUT_OF_RANGE;
        begin_reply(card, R1_PARAMETER);
        return;
    }
    begin_reply(card, 0);
    card->block = block;
    card->multiple = number == 18 || number == 25;
    card->failed = false;
    if (number == 17 || number == 18)
        send_block(card, now);
    else
        card->state = CARD_AWAITS_TOKEN;
}

// The commands of table 7-3 that hosts use.
static void execute(SdCard* card, uint64_t now) {
    unsigned number = card->command[0] & 0x3f;
    uint32_t argument = (uint32_t)card->command[1] << 24 | (uint32_t)card->command[2] << 16 |
                        (uint32_t)card->command[3] << 8 | card->command[4];
    bool app = card->app_command;
    card->app_command = false;
    uint8_t r1 = card->idle ? R1_IDLE : 0;

    bool checked = card->crc_on || number == 0 || number == 8;
    if (checked && card->command[5] != sd_crc7(card->command, 5)) {
        violation(card, "command with a wrong CRC");
        begin_reply(card, r1 | R1_CRC);
        return;
    }
    uint64_t nth = card->commands[number]++;
    for (size_t i = 0; i < card->config.reply_fault_count; i++) {
        const BadReply* bad = &card->config.replies[i];
        if (bad->command == number && bad->nth == nth) {
            begin_reply(card, bad->reply);
            return;
        }
    }
    if (number == 0 && card->clocks < CLOCKS_BEFORE_FIRST_COMMAND)
        violation(card, "CMD0 before 74 clocks with the card deselected");
    bool any_time = number == 0 || number == 8 || number == 55 || number == 58 || number == 59 ||
                    (app && number == 41);
    if (card->idle && !any_time) {
        begin_reply(card, r1 | R1_ILLEGAL);
        return;
    }
    if (number != 12) card->state = CARD_READY;

    switch (number) {
        case 0:
            card->idle = true;
            card->ready_at = 0;
            begin_reply(card, R1_IDLE);
            break;
        case 8:
            if (card->kind == CARD_SD_V1) {
                begin_reply(card, r1 | R1_ILLEGAL);
                break;
            }
            begin_reply(card, r1);
            reply(card, 0);
            reply(card, 0);
            reply(card, (argument >> 8 & 0x0f) == 1 ? 1 : 0);  // 2.7 to 3.6 V accepted
            reply(card, (uint8_t)argument);
            break;
        case 9:
        case 10:
            begin_reply(card, r1);
            if (number == 9)
                sd_csd(card, card->buffer);
            else
                sd_cid(card, card->buffer);
            begin_sending(card, 16, now);
            card->multiple = false;
            break;
        case 12:
            begin_reply(card, card->state == CARD_SENDS ? 0 : R1_ILLEGAL);
            card->state = CARD_READY;
            card->busy_until = now;
            break;
        case 13:
            begin_reply(card, r1);
            reply(card, card->status);
            card->status = 0;
            break;
        case 16:
            begin_reply(card, argument == BLOCK_SIZE ? r1 : r1 | R1_PARAMETER);
            break;
        case 17:
        case 18:
        case 24:
        case 25:
            begin_transfer(card, number, argument, now);
            break;
        case 23:
            begin_reply(card, app ? r1 : r1 | R1_ILLEGAL);
            break;
        case 41:
            if (app)
                initialise(card, argument, now);
            else
                begin_reply(card, r1 | R1_ILLEGAL);
            break;
        case 55:
            card->app_command = true;
            begin_reply(card, r1);
            break;
        case 58:
            begin_reply(card, r1);
            reply(card, (card->idle ? 0 : OCR_POWERED_UP) |
                            (!card->idle && card->kind == CARD_SDHC ? OCR_HIGH_CAPACITY : 0));
            reply(card, 0xff);
            reply(card, 0x80);
            reply(card, 0);
            break;
        case 59:
            card->crc_on = argument & 1 && !card->config.ignores_crc;
            begin_reply(card, r1);
            break;
        default:
            begin_reply(card, r1 | R1_ILLEGAL);
    }
}

static void take_command(SdCard* card, uint8_t in, bool busy, uint64_t now, uint32_t byte_cycles) {
    if (card->command_length == 0) {
        if ((in & 0xc0) != 0x40) return;
        if (busy) violation(card, "command while the card is busy");
        if (card->idle && byte_cycles < SLOW_BYTE_CYCLES)
            violation(card, "clock above 400 kHz before the card is ready");
        if (busy) return;
    }
    card->command[card->command_length++] = in;
    if (card->command_length < sizeof card->command) return;
    card->command_length = 0;
    execute(card, now);
}

// A whole block is here: store it, or do what the faults say (7.3.3.1).
static void take_block(SdCard* card, uint64_t now) {
    uint64_t busy = 0;
    uint8_t token = sd_store(card, now, &busy);
    card->reply_count = card->reply_used = 0;
    reply(card, token);
    card->failed = token != TOKEN_ACCEPTED;
    card->busy_until = now + busy;
    card->not_yet_busy = card->config.late_busy;
    card->state = card->multiple ? CARD_AWAITS_TOKEN : CARD_READY;
}

static void take(SdCard* card, uint8_t in, bool busy, uint64_t now, uint32_t byte_cycles) {
    if (card->state == CARD_RECEIVES) {
        card->buffer[card->buffer_used++] = in;
        if (card->buffer_used == BLOCK_SIZE + 2) take_block(card, now);
        return;
    }
    if (card->state == CARD_AWAITS_TOKEN && card->command_length == 0) {
        bool start = in == (card->multiple ? TOKEN_MULTIPLE : TOKEN_SINGLE);
        if (start && busy) violation(card, "data block while the card is busy");
        if (start && !busy) {
            card->buffer_used = 0;
            card->state = CARD_RECEIVES;
            return;
        }
        if (card->multiple && in == TOKEN_STOP) {
            card->state = CARD_READY;
            card->busy_until = now + card->config.write_busy;
            reply(card, FLOATING);  // busy appears one byte later
            return;
        }
    }
    take_command(card, in, busy, now, byte_cycles);
}

static uint8_t next_output(SdCard* card, bool busy, uint64_t now) {
    if (card->reply_used < card->reply_count) {
        uint8_t byte = card->replies[card->reply_used++];
        if (card->reply_used == card->reply_count) card->reply_used = card->reply_count = 0;
        return byte;
    }
    if (busy && card->not_yet_busy) {
        card->not_yet_busy--;
        return FLOATING;
    }
    if (busy) return BUSY;
    if (card->state != CARD_SENDS || now < card->data_at) return FLOATING;
    if (card->buffer_used == 0 && card->data_at) {
        card->data_at = 0;
        return TOKEN_SINGLE;
    }
    uint8_t byte = card->buffer[card->buffer_used++];
    if (card->buffer_used == card->buffer_length) {
        card->state = CARD_READY;
        if (card->multiple) send_block(card, now);
    }
    return byte;
}

// Whether the contacts are open. When they have closed again the card starts anew.
static bool is_loose(SdCard* card, uint64_t now) {
    for (size_t i = 0; i < card->config.gap_count; i++) {
        Interval* gap = &card->config.gaps[i];
        if (gap->over || now < gap->from) continue;
        if (now < gap->to) return true;
        gap->over = true;
        bool power_cut = card->power_cut;
        sdcard_power_on(card);
        card->power_cut = power_cut;
    }
    return false;
}

uint8_t sdcard_exchange(SdCard* card, uint8_t in, uint64_t now, uint32_t byte_cycles) {
    if (is_loose(card, now)) return FLOATING;
    bool pulled = card->config.pull_at && now >= card->config.pull_at;
    if (card->kind == CARD_NONE || pulled || card->power_cut) return FLOATING;
    if (!card->selected) {
        card->clocks += 8;
        return FLOATING;
    }
    bool busy = now < card->busy_until;
    uint8_t out = next_output(card, busy, now);
    take(card, in, busy, now, byte_cycles);
    return out;
}
