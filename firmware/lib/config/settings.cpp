#include "settings.h"

#include <string.h>

#include "beside.h"
#include "board.h"

namespace {

const uint32_t kMostPulsesPerKm = 1000000;

char* trimmed(char* text) {
    while (*text == ' ') ++text;
    char* end = text + strlen(text);
    while (end > text && end[-1] == ' ') --end;
    *end = 0;
    return text;
}

bool is_name_character(char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
}

bool parse_channels(const char* text, char channels[8][Settings::kChannelSize]) {
    const uint8_t size = Settings::kChannelSize;
    bool any = false;
    memset(channels, 0, 8 * size);
    for (uint8_t k = 0; k < 8; ++k) {
        while (*text == ' ') ++text;
        uint8_t length = 0;
        for (; *text && *text != ' '; ++text, ++length) {
            if (length == size) return false;
            channels[k][length] = *text;
        }
        if (!length) return false;
        if (channels[k][0] == '-' && length == 1) {
            channels[k][0] = 0;
            continue;
        }
        for (uint8_t at = 0; at < length; ++at) {
            if (!is_name_character(channels[k][at])) return false;
        }
        for (uint8_t other = 0; other < k; ++other) {
            if (memcmp(channels[k], channels[other], size) == 0) return false;
        }
        any = true;
    }
    while (*text == ' ') ++text;
    return any && !*text;
}

// `first` → false, `second` → true
bool parse_choice(const char* text, const FlashChar* first, const FlashChar* second, bool& choice) {
    const bool is_second = same(text, second);
    if (!is_second && !same(text, first)) return false;
    choice = is_second;
    return true;
}

}  // namespace

const FlashChar* split(char* line, char*& key, char*& value) {
    char* equals = strchr(line, '=');
    if (!equals) return FLASH("write KEY = VALUE");
    *equals = 0;
    key = trimmed(line);
    value = trimmed(equals + 1);
    return nullptr;
}

// What a value may be is told by who knows the key: the host, and SPEC.md.
const FlashChar* wrong_value() { return FLASH("wrong value"); }

const FlashChar* Settings::apply(const char* key, const char* value) {
    uint32_t number;
    bool good = true;
    if (same(key, FLASH("rate"))) {
        good = read_number(value, 400, number) && (number == 100 || number == 200 || number == 400);
        if (good) conversions = static_cast<uint8_t>(board::kConversionsHz / number);
    } else if (same(key, FLASH("channels"))) {
        char parsed[8][kChannelSize];
        good = parse_channels(value, parsed);
        if (good) memcpy(channels, parsed, sizeof channels);
    } else if (same(key, FLASH("name"))) {
        good = strlen(value) < kNameSize;
        if (good) strcpy(name, value);
    } else if (same(key, FLASH("start"))) {
        good = parse_choice(value, FLASH("button"), FLASH("power"), start_at_power);
    } else if (same(key, FLASH("stream"))) {
        good = parse_choice(value, FLASH("off"), FLASH("on"), stream);
    } else if (same(key, FLASH("resume"))) {
        good = parse_choice(value, FLASH("off"), FLASH("on"), resume);
    } else if (same(key, FLASH("size_mb"))) {
        good = read_number(value, 4095, number) && number;
        if (good) size_mb = static_cast<uint16_t>(number);
    } else if (board::kHasBeside && same(key, FLASH("pulses_per_km"))) {
        good = read_number(value, kMostPulsesPerKm, number);
        if (good) board::beside.pulses_per_km = number;
    } else {
        return FLASH("unknown key");
    }
    return good ? nullptr : wrong_value();
}

uint8_t Settings::mask() const {
    uint8_t bits = 0;
    for (uint8_t k = 0; k < 8; ++k) {
        if (channels[k][0]) bits |= static_cast<uint8_t>(1 << k);
    }
    return bits;
}

uint8_t Settings::recorded() const {
    uint8_t count = 0;
    for (uint8_t bits = mask(); bits; bits >>= 1) count += bits & 1;
    return count;
}

void Settings::put_channels(Text& text) const {
    for (uint8_t k = 0; k < 8; ++k) {
        if (k) text.put(' ');
        if (!channels[k][0]) text.put('-');
        for (uint8_t at = 0; at < kChannelSize && channels[k][at]; ++at) text.put(channels[k][at]);
    }
}
