#pragma once
#include <stdint.h>

#include "flash.h"

// Writes text into memory of fixed size; what does not fit is cut off.
class Text {
  public:
    Text(void* at, uint16_t room) : at_(static_cast<char*>(at)), room_(room) {}

    void put(char character) {
        if (length_ < room_) at_[length_++] = character;
    }
    void put(const char* text);
    void put(const FlashChar* text);
    void number(uint32_t value, uint8_t digits = 1);  // at least so many digits
    void signed_number(int32_t value);
    void hex(uint32_t value, uint8_t digits);

    uint16_t length() const { return length_; }

  private:
    char* at_;
    uint16_t room_;
    uint16_t length_ = 0;
};

// Reads a decimal number that fills `text`; false if it is none or above `most`.
bool read_number(const char* text, uint32_t most, uint32_t& value);

// True if `text` begins with `word`.
bool begins_with(const char* text, const FlashChar* word);
bool same(const char* text, const FlashChar* word);
