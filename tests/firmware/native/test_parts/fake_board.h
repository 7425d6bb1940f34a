#pragma once
// The board on a PC: time that passes with every SPI byte, an EEPROM, an SD
// card in memory.
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "beside.h"
#include "board.h"
#include "link.h"
#include "sampler.h"
#include "together.h"

namespace fake {

extern const char* image_path;  // of an empty FAT file system, or nullptr
extern uint32_t now_us;
extern std::vector<uint8_t> eeprom;
extern uint8_t sampling;         // what board::sample() was told last
extern uint16_t reference_code;  // of the internal reference
extern board::Converter& sampler;
extern bool self_test;  // of the sensors
extern uint32_t fed_us,
    longest_unfed_us;  // when the watchdog was fed last, and its longest wait

void power_on();               // everything as new
std::string sent(Link& link);  // what the serial interrupt sends, once it was started

struct Card {
    std::vector<uint8_t> content;  // as many sectors as it has
    bool inserted = true;
    bool by_sector = true;   // SDHC
    bool version_1 = false;  // and no SDHC
    bool write_protected = false;
    uint8_t serial_number = 1;
    uint32_t busy_us = 300;  // after every write
    int refuse = 0;          // so many of the next writes
    int fail_later = 0;      // accept them, and fail afterwards
    int writes = 0;
    bool fast = false;              // the clock
    int commands[64] = {};          // how often each came
    int bad_replies = 0;            // so many of the next answers to `bad_command` are `bad_reply`,
    uint8_t bad_command = 0;        // and the command is not carried out
    uint8_t bad_reply = 0xFF;       // 0xFF: no answer
    uint32_t sheet_late_us = 0;     // before CSD and CID
    bool sheet_says_bytes = false;  // whatever the card does
    bool knows_checks = true;       // CMD59
    int disturb = 0;                // so many of the next blocks arrive with a wrong bit,
    int disturb_read = 0;           // or are read with one
    int disturb_sheet = 0;          // and so many of the next registers
    int reads_left = -1;            // so many blocks can still be read, or written, and then
    int writes_left = -1;           // `failures` times none; -1: as many as there are
    int failures = -1;              // -1: for ever
    int failed = 0;                 // so often
    uint32_t bad_sector = ~0u;      // takes no block
    int rude = 0;                   // what a real card may take amiss: see exchange()
    bool checks() const { return checks_; }
    bool holds_bus() const { return selected_ || holds_bus_; }

    void select(bool selected);
    uint8_t exchange(uint8_t sent);
    void lose_power();

  private:
    void answer(uint8_t byte) { out_.push_back(byte); }
    bool can(int& left);  // read or write another block
    void answer_block(const uint8_t* data, size_t size);
    void answer_sheet(const uint8_t* data);
    uint8_t crc7() const;
    void command();
    void store();

    std::vector<uint8_t> in_;
    std::deque<uint8_t> out_;
    bool selected_ = false, idle_ = true, receiving_ = false, application_ = false;
    bool checks_ = false;
    int clocks_ = 0;           // while it was not selected; it wants 74 before the first command
    bool pause_ = false;       // since the answer to CMD24
    bool just_spoke_ = false;  // a byte's pause is due before the next command
    bool holds_bus_ = false;   // until a clock after it was deselected
    uint8_t status_ = 0;
    size_t sector_ = 0;
    uint32_t busy_until_us_ = 0;
};
extern Card card;

}  // namespace fake
