#include "text.h"

void Text::put(const char* text) {
    while (*text) put(*text++);
}

void Text::put(const FlashChar* text) {
    for (int at = 0; char character = flash_char(text, at); ++at) put(character);
}

void Text::number(uint32_t value, uint8_t digits) {
    char reversed[10];
    uint8_t count = 0;
    do {
        reversed[count++] = static_cast<char>('0' + value % 10);
        value /= 10;
    } while (value || count < digits);
    while (count) put(reversed[--count]);
}

void Text::signed_number(int32_t value) {
    if (value < 0) put('-');
    number(value < 0 ? 0 - static_cast<uint32_t>(value) : static_cast<uint32_t>(value));
}

void Text::hex(uint32_t value, uint8_t digits) {
    while (digits--) put(flash_char(FLASH("0123456789ABCDEF"), value >> (4 * digits) & 15));
}

bool read_number(const char* text, uint32_t most, uint32_t& value) {
    uint32_t sum = 0;
    if (!*text) return false;
    for (; *text; ++text) {
        if (*text < '0' || *text > '9') return false;
        const uint8_t digit = static_cast<uint8_t>(*text - '0');
        if (digit > most || sum > (most - digit) / 10) return false;
        sum = 10 * sum + digit;
    }
    value = sum;
    return true;
}

bool begins_with(const char* text, const FlashChar* word) {
    int at = 0;
    for (; flash_char(word, at); ++at) {
        if (text[at] != flash_char(word, at)) return false;
    }
    return true;
}

bool same(const char* text, const FlashChar* word) {
    int length = 0;
    while (flash_char(word, length)) ++length;
    return begins_with(text, word) && !text[length];
}
