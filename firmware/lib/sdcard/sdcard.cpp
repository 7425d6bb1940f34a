#include "sdcard.h"

#include "board.h"
#include "crc16.h"

// Numbers of commands, tokens and bits: SD Specifications, Part 1, Physical Layer Simplified
// Specification, chapter 7, "SPI Mode".

namespace {

const uint16_t kStartLimitMs = 1200;  // the standard allows 1 s
const uint16_t kBusyLimitMs = 2000;   // the standard allows 250 ms, SDXC 500 ms
const uint16_t kReadLimitMs = 100;

const uint8_t kIdle = 0x01;
const uint8_t kIllegal = 0x04;
const uint8_t kNoAnswer = 0xFF;
const uint16_t kNoStatus = 0xFFFF;
const uint8_t kDataToken = 0xFE;
const uint8_t kAccepted = 0x05;
const uint8_t kStatusProtected = 0x20;  // second byte of the status: write protect violation

uint8_t receive_byte() { return board::spi_exchange(0xFF); }

uint8_t crc7_update(uint8_t crc, uint8_t byte) {
    for (uint8_t bit = 0; bit < 8; ++bit, byte <<= 1) {
        crc <<= 1;
        if ((byte ^ crc) & 0x80) crc ^= 0x09;
    }
    return crc;
}

}  // namespace

SdCard card;

void SdCard::begin() {
    board::spi_fast(false);
    board::card_select(false);
    for (uint8_t k = 0; k < 10; ++k) receive_byte();  // at least 74 clocks
    state_ = Starting;
    step_ = Reset;
    traits_ = 0;
    changed_ = false;
    since_ms_ = static_cast<uint16_t>(board::milliseconds());
}

void SdCard::poll() {
    if (state_ == Starting) {
        start();
        if (state_ == Starting && elapsed() > kStartLimitMs) fall();
    } else if (state_ == Busy) {
        ask_if_busy();
    }
}

void SdCard::ask_if_busy() {
    board::card_select(true);
    receive_byte();  // a card may take a byte to show that it is busy
    const bool done = receive_byte() == 0xFF;
    const uint16_t busy_ms = elapsed();
    if (busy_ms > longest_busy_ms) longest_busy_ms = busy_ms;
    if (done) {
        check_write();
    } else if (busy_ms > kBusyLimitMs) {
        fall();
    }
    deselect();
}

bool SdCard::write(uint32_t sector, const void* data) {
    accepted_ = written_ = false;
    board::card_select(true);
    if (command(24, address(sector)) == 0) {
        receive_byte();
        board::spi_exchange(kDataToken);
        const uint16_t crc = board::spi_send(static_cast<const uint8_t*>(data), 512);
        board::spi_exchange(static_cast<uint8_t>(crc >> 8));
        board::spi_exchange(static_cast<uint8_t>(crc));
        accepted_ = (receive_byte() & 0x1F) == kAccepted;
    }
    deselect();
    state_ = Busy;
    since_ms_ = static_cast<uint16_t>(board::milliseconds());
    return accepted_;
}

bool SdCard::read(uint32_t sector, void* data) {
    board::card_select(true);
    const bool answered = command(17, address(sector)) == 0;
    const bool received = answered && receive(data, 512);
    deselect();
    return received;
}

bool SdCard::watch(uint8_t which, uint32_t sector) {
    watched_[which].sector = sector;
    const bool received = read(sector, nullptr);
    watched_[which].crc = crc_;
    return received;
}

bool SdCard::settle() {
    while (state_ == Starting || state_ == Busy) {
        poll();
        board::feed_watchdog();
    }
    return state_ == Ready;
}

bool SdCard::finish() {
    while (state_ == Busy) {
        ask_if_busy();
        board::feed_watchdog();
    }
    return state_ == Ready;
}

bool SdCard::present() {
    if (!settle()) return false;
    board::card_select(true);
    if (status() == kNoStatus) fall();
    deselect();
    return state_ == Ready;
}

uint8_t SdCard::command(uint8_t index, uint32_t argument) {
    receive_byte();
    if (receive_byte() != 0xFF) return kNoAnswer;  // busy: its zeros are no answer
    uint8_t crc = 0;
    for (int8_t shift = 32; shift >= 0; shift -= 8) {
        const uint8_t byte = shift == 32 ? 0x40 | index : static_cast<uint8_t>(argument >> shift);
        board::spi_exchange(byte);
        crc = crc7_update(crc, byte);
    }
    board::spi_exchange(static_cast<uint8_t>(crc << 1 | 1));
    for (uint8_t k = 0; k < 10; ++k) {
        const uint8_t answer = receive_byte();
        if (!(answer & 0x80)) return answer;
    }
    return kNoAnswer;
}

uint8_t SdCard::application_command(uint8_t index, uint32_t argument) {
    command(55, 0);
    return command(index, argument);
}

// Both bytes of the card's status, 0: all is well. A card that lost its power since it was woken is
// idle: for us that is no answer.
uint16_t SdCard::status() {
    const uint8_t first = command(13, 0);
    const uint8_t second = receive_byte();
    if (first & (0x80 | kIdle)) return kNoStatus;
    return static_cast<uint16_t>(first << 8 | second);
}

bool SdCard::wait_for(uint8_t token) {
    const uint32_t start_ms = board::milliseconds();
    uint8_t byte;
    do {
        byte = receive_byte();
    } while (byte == 0xFF && board::milliseconds() - start_ms < kReadLimitMs);
    return byte == token;
}

bool SdCard::receive(void* data, uint16_t size) {
    return wait_for(kDataToken) && receive_data(data, size);
}

bool SdCard::receive_data(void* data, uint16_t size) {
    crc_ = board::spi_receive(static_cast<uint8_t*>(data), size);
    uint16_t told = static_cast<uint16_t>(receive_byte() << 8);
    told |= receive_byte();
    return !(traits_ & kChecks) || crc_ == told;
}

// One question to a card that starts. It stays selected while it looks for a sheet.
void SdCard::start() {
    board::card_select(true);
    bool right = true;
    switch (step_) {
        case Reset:
            if (command(0, 0) != kIdle) break;
            if (command(8, 0x1AA) == kIdle) traits_ = kVersion2;
            for (uint8_t k = 0; k < 4; ++k) receive_byte();
            step_ = PowerUp;
            break;
        case PowerUp:
            if (application_command(41, traits_ ? 0x40000000 : 0) == 0) step_ = Traits;
            break;
        case Traits:
            right = ask_for_traits();
            board::spi_fast(true);
            right = right && ask_for_sheet(9, 0);
            break;
        default:
            right = take_sheet();
    }
    if (!right) fall();
    if (state_ != Starting || step_ < SpecificData) deselect();
}

// Answers that are not clear are no answers: a card of 2 GB and more that is taken for a smaller
// one gets its blocks at addresses 512 times too high.
bool SdCard::ask_for_traits() {
    if (traits_ & kVersion2) {
        if (command(58, 0) != 0) return false;
        if (receive_byte() & 0x40) traits_ |= kBySector;
        for (uint8_t k = 0; k < 3; ++k) receive_byte();
    }
    const uint8_t answer = command(59, 1);
    if (answer == 0) {
        traits_ |= kChecks;
    } else if (answer != kIllegal) {
        return false;
    }
    return traits_ & kBySector || command(16, 512) == 0;
}

// The card's specific data, then its identification, 16 bytes each, then the sectors by which it is
// known again: when the card has them ready.
bool SdCard::take_sheet() {
    const uint8_t token = receive_byte();
    if (token == 0xFF) return elapsed() < kReadLimitMs;
    uint8_t sheet[16];
    const bool is_sheet = step_ < Watched;
    if (token != kDataToken) return false;
    if (!(is_sheet ? receive_data(sheet, sizeof sheet) : receive_data(nullptr, 512))) return false;
    if (step_ == SpecificData) {
        // The structure's version is another witness of how the card counts.
        if ((sheet[0] >> 6 != 0) != ((traits_ & kBySector) != 0)) return false;
        protected_ = sheet[14] & 0x30;  // permanently or for the time being
        return ask_for_sheet(10, 0);
    }
    if (step_ == Identification) {
        const uint16_t told = crc16(sheet, sizeof sheet);
        if (known_traits_ && told == id_ && traits_ != (known_traits_ & ~kKnown)) return false;
        id_ = told;
        known_traits_ = traits_ | kKnown;
    } else if (crc_ != watched_[step_ - Watched].crc) {
        changed_ = true;
    }
    const uint8_t next = step_ - Identification;
    if (next < 2 && watched_[0].sector) return ask_for_sheet(17, address(watched_[next].sector));
    state_ = Ready;
    return true;
}

bool SdCard::ask_for_sheet(uint8_t index, uint32_t argument) {
    receive_byte();
    ++step_;
    since_ms_ = static_cast<uint16_t>(board::milliseconds());
    return command(index, argument) == 0;
}

// The card is not busy any more, or not there: its status tells.
void SdCard::check_write() {
    const uint16_t answer = status();
    if (answer == kNoStatus) return fall();
    written_ = accepted_ && answer == 0;
    protected_ = answer & kStatusProtected;
    state_ = Ready;
}

void SdCard::deselect() {
    board::card_select(false);
    receive_byte();  // the card lets go of its output with the next clocks
}

uint16_t SdCard::elapsed() const {
    return static_cast<uint16_t>(board::milliseconds() - since_ms_);
}
