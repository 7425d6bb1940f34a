#include "link.h"

#include <string.h>

#include "board.h"
#include "crc16.h"
#include "text.h"

namespace {

// Replace every zero by the distance to the next: COBS, for less than 254 bytes after `frame[0]`.
void stuff(uint8_t* frame, uint8_t size) {
    uint8_t code_at = 0;
    for (uint8_t at = 1; at <= size; ++at) {
        if (at == size || frame[at] == 0) {
            frame[code_at] = at - code_at;
            code_at = at;
        }
    }
}

int8_t hex_digit(char c) {
    if (c >= '0' && c <= '9') return static_cast<int8_t>(c - '0');
    c &= ~0x20;
    return c >= 'A' && c <= 'F' ? static_cast<int8_t>(c - 'A' + 10) : -1;
}

// Cut `*` and four digits off the end of a line; false if they are there and wrong.
bool check_and_cut(char* line) {
    char* star = strrchr(line, '*');
    if (!star) return true;
    uint16_t told = 0;
    for (uint8_t k = 1; k <= 4; ++k) {
        const int8_t digit = hex_digit(star[k]);
        if (digit < 0) return false;
        told = static_cast<uint16_t>(told << 4 | digit);
    }
    *star = 0;
    return !star[5] && told == crc16(line, strlen(line));
}

}  // namespace

void Link::send(char type, uint8_t size) {
    uint8_t* content = frame_ + 2;
    content[0] = static_cast<uint8_t>(type);
    content[1] = counter_++;
    const uint16_t crc = crc16(content, size + 2);
    content[size + 2] = static_cast<uint8_t>(crc);
    content[size + 3] = static_cast<uint8_t>(crc >> 8);
    stuff(frame_ + 1, size + 5);
    frame_[0] = frame_[size + 6] = 0;
    size_ = size + 7;
    sent_ = 0;
    __atomic_signal_fence(
        __ATOMIC_SEQ_CST);  // the frame is whole before the interrupt may look at it
    sending_ = true;
    board::start_transmitter();
}

bool Link::transmit(uint8_t& byte) {
    if (!sending_) return false;
    byte = frame_[sent_++];
    if (sent_ == size_) sending_ = false;
    return true;
}

void Link::receive(uint8_t byte, bool damaged) {
    const bool ends = byte == '\n' || byte == '\r';
    if (received_ != Line::Collecting || dropping_) {
        dropping_ = !ends;
        return;
    }
    received_ = line_.push(damaged ? 0 : byte);
}

char* Link::command(const FlashChar*& problem) {
    problem = nullptr;
    if (received_ == Line::Collecting) return nullptr;
    __atomic_signal_fence(__ATOMIC_SEQ_CST);
    if (received_ == Line::Refused) {
        problem = FLASH("line too long or not plain text");
    } else if (!check_and_cut(line_.text())) {
        problem = FLASH("checksum");
    }
    return line_.text();
}

void Link::next_command() {
    line_.clear();
    __atomic_signal_fence(__ATOMIC_SEQ_CST);
    received_ = Line::Collecting;
}
