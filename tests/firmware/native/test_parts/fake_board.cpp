#include "fake_board.h"

#include <cstdio>
#include <cstring>

#include "board.h"
#include "crc16.h"
#include "sdcard.h"

namespace fake {

const char* image_path = nullptr;
uint32_t now_us = 0;
std::vector<uint8_t> eeprom;
uint8_t sampling = 0;
uint16_t reference_code = 341;  // 3300 mV
board::Converter& sampler = board::sampler;
bool self_test = false;
Card card;
uint32_t longest_unfed_us = 0, fed_us = 0;
static bool transmitting = false;

void power_on() {
    now_us = fed_us = longest_unfed_us = 0;
    eeprom.assign(64, 0xFF);
    sampling = 0;
    board::unfinished = 0;
    reference_code = 341;
    card = Card();
    card.content.assign(64 * 512, 0);
    ::card = SdCard();
}

std::string sent(Link& link) {
    std::string bytes;
    if (!transmitting) return bytes;
    transmitting = false;
    for (uint8_t byte; link.transmit(byte);) bytes.push_back(static_cast<char>(byte));
    return bytes;
}

void Card::select(bool selected) {
    const bool speaks = !out_.empty() && out_.front() != 0xFF;  // it has more to say
    if (selected_ && !selected && inserted && speaks) ++rude;
    holds_bus_ |= selected_ && !selected;
    selected_ = selected;
    just_spoke_ = false;
    if (!selected) in_.clear(), out_.clear(), receiving_ = false;
}

void Card::lose_power() {
    idle_ = true;
    checks_ = false;
    busy_until_us_ = 0;
}

uint8_t Card::exchange(uint8_t sent) {
    now_us += 2;
    if (inserted && !selected_ && clocks_ < 74) clocks_ += 8;
    if (!selected_) holds_bus_ = false;
    if (!inserted || !selected_) return 0xFF;
    uint8_t reply = 0xFF;
    if (!receiving_ && in_.empty() && (sent & 0xC0) == 0x40 && just_spoke_) ++rude;
    just_spoke_ = false;
    // A command into an answer that was not read to its end; a block without a
    // byte's pause before.
    const bool quiet = out_.empty();
    if (!receiving_ && in_.empty() && (sent & 0xC0) == 0x40 && !quiet) ++rude;
    if (receiving_ && in_.empty() && sent == 0xFE && !pause_) ++rude;
    if (receiving_ && quiet) pause_ = true;
    if (!out_.empty()) {
        reply = out_.front();
        out_.pop_front();
        just_spoke_ = out_.empty();
    } else if (static_cast<int32_t>(busy_until_us_ - now_us) > 0) {
        reply = 0;
    }
    if (receiving_) {
        if (!in_.empty() || sent == 0xFE) in_.push_back(sent);
        if (in_.size() == 1 + 512 + 2) store();
    } else if (!in_.empty() || (sent & 0xC0) == 0x40) {
        in_.push_back(sent);
        if (in_.size() == 6) command();
    }
    return reply;
}

bool Card::can(int& left) {
    if (left > 0) return left--;
    if (left) return true;
    ++failed;
    if (failures > 0 && --failures == 0) left = -1;
    return false;
}

void Card::answer_block(const uint8_t* data, size_t size) {
    answer(0xFF);
    answer(0xFE);
    int& disturbed = size == 512 ? disturb_read : disturb_sheet;
    const bool wrong = disturbed;
    if (wrong) --disturbed;
    for (size_t k = 0; k < size; ++k) answer(wrong && k == 7 ? data[k] ^ 4 : data[k]);
    const uint16_t crc = crc16(data, size);
    answer(static_cast<uint8_t>(crc >> 8));
    answer(static_cast<uint8_t>(crc));
}

// Registers may come late.
void Card::answer_sheet(const uint8_t* data) {
    for (uint32_t k = 0; k < sheet_late_us / 2; ++k) answer(0xFF);
    answer_block(data, 16);
}

uint8_t Card::crc7() const {
    uint8_t crc = 0;
    for (int k = 0; k < 5; ++k) {
        for (int bit = 7; bit >= 0; --bit) {
            const bool high = (crc >> 6 & 1) != (in_[k] >> bit & 1);
            crc = static_cast<uint8_t>(crc << 1 & 0x7F) ^ (high ? 9 : 0);
        }
    }
    return static_cast<uint8_t>(crc << 1 | 1);
}

void Card::command() {
    const uint8_t index = in_[0] & 63;
    ++commands[index];
    if ((checks_ || index == 0 || index == 8) && in_[5] != crc7()) {
        in_.clear();
        answer(0xFF);
        answer(idle_ ? 9 : 8);
        return;
    }
    if (index == bad_command && bad_replies) {
        --bad_replies;
        in_.clear();
        answer(0xFF);
        answer(bad_reply);
        return;
    }
    const uint32_t argument =
        static_cast<uint32_t>(in_[1]) << 24 | in_[2] << 16 | in_[3] << 8 | in_[4];
    const bool application = application_;
    application_ = false;
    in_.clear();
    const uint8_t ready = idle_ ? 1 : 0;
    sector_ = by_sector ? argument : argument / 512;
    const bool readable = index != 17 || can(reads_left);
    const bool inside = sector_ < content.size() / 512 && readable;
    // What means nothing is to be 0.
    const bool means = index == 8 || index == 16 || index == 17 || index == 24 || index == 41;
    if (!means && index != 59 && argument) ++rude;
    uint8_t sheet[16] = {};
    answer(0xFF);
    switch (index) {
        case 16:  // the length of a block
            answer(argument == 512 ? ready : 0x40);
            break;
        case 0:
            if (clocks_ < 74) ++rude;
            lose_power();
            answer(1);
            break;
        case 8:
            if (version_1) {
                answer(4 | ready);
                break;
            }
            for (uint8_t byte : {ready, uint8_t(0), uint8_t(0), uint8_t(1), uint8_t(0xAA)})
                answer(byte);
            break;
        case 9:
            answer(ready);
            sheet[0] = by_sector && !sheet_says_bytes ? 0x40 : 0;  // version of the structure
            sheet[14] = write_protected ? 0x10 : 0;
            answer_sheet(sheet);
            break;
        case 10:
            answer(ready);
            sheet[9] = serial_number;
            answer_sheet(sheet);
            break;
        case 13:
            answer(ready);
            answer(status_);
            status_ = 0;
            break;
        case 17:
            answer(idle_ ? 5 : inside ? 0 : 0x40);
            if (!idle_ && inside) answer_block(&content[sector_ * 512], 512);
            break;
        case 24:
            answer(idle_ ? 5 : inside ? 0 : 0x40);
            receiving_ = !idle_ && inside;
            pause_ = false;
            break;
        case 41:
            if (version_1 && argument) ++rude;
            if (application && (!by_sector || argument >> 30 & 1)) idle_ = false;
            answer(application ? idle_ : 5);
            break;
        case 55:
            application_ = true;
            answer(ready);
            break;
        case 58:
            answer(ready);
            answer(by_sector ? 0xC0 : 0x80);
            for (int k = 0; k < 3; ++k) answer(0);
            break;
        case 59:
            checks_ = knows_checks && argument & 1;
            answer(knows_checks ? ready : 4 | ready);
            break;
        default:
            answer(index == 16 ? ready : 4 | ready);
    }
}

void Card::store() {
    const uint16_t crc = static_cast<uint16_t>(in_[513] << 8 | in_[514]);
    if (disturb) --disturb, in_[301] ^= 0x10;
    const bool right = !checks_ || crc == crc16(&in_[1], 512);
    receiving_ = false;
    busy_until_us_ = now_us + busy_us;
    ++writes;
    if (refuse || write_protected || !right || sector_ == bad_sector || !can(writes_left)) {
        if (refuse) --refuse;
        if (write_protected) status_ = 0x20;
        answer(right ? 0xED : 0xEB);
    } else if (fail_later) {
        --fail_later;
        status_ = 0x04;
        answer(0xE5);
    } else {
        memcpy(&content[sector_ * 512], &in_[1], 512);
        answer(0xE5);
    }
    in_.clear();
}

}  // namespace fake

namespace board {

Converter sampler;
Link serial;
Beside beside;

uint32_t milliseconds() { return fake::now_us / 1000; }
uint16_t dice() { return 0x1234; }
void feed_watchdog() {
    const uint32_t unfed_us = fake::now_us - fake::fed_us;
    if (unfed_us > fake::longest_unfed_us) fake::longest_unfed_us = unfed_us;
    fake::fed_us = fake::now_us;
}
uint32_t unfinished = 0;
const FlashChar* reset_cause() { return FLASH("watchdog"); }

void card_select(bool selected) { fake::card.select(selected); }
void spi_fast(bool fast) { fake::card.fast = fast; }
uint8_t spi_exchange(uint8_t sent) { return fake::card.exchange(sent); }

uint16_t spi_send(const uint8_t* data, uint16_t size) {
    for (uint16_t k = 0; k < size; ++k) spi_exchange(data[k]);
    return crc16(data, size);
}

uint16_t spi_receive(uint8_t* data, uint16_t size) {
    uint16_t crc = 0;
    for (uint16_t k = 0; k < size; ++k) {
        const uint8_t byte = spi_exchange(0xFF);
        crc = crc16_update(crc, byte);
        if (data) data[k] = byte;
    }
    return crc;
}

void eeprom_read(uint8_t address, void* data, uint8_t size) {
    memcpy(data, &fake::eeprom.at(address), size);
}

void eeprom_write(uint8_t address, const void* data, uint8_t size) {
    memcpy(&fake::eeprom.at(address), data, size);
}

void self_test(bool on) { fake::self_test = on; }

void sample(uint8_t conversions) {
    self_test(false);
    fake::sampling = conversions;
    if (conversions) fake::sampler.start(conversions);
}

uint16_t reference_code() { return fake::reference_code; }
void start_transmitter() { fake::transmitting = true; }

}  // namespace board
