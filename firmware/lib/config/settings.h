#pragma once
#include <stdint.h>

#include "flash.h"
#include "text.h"
#include "traits.h"

// What the user chooses, by HOP.CFG or by the command `set` (SPEC.md, "HOP.CFG").
struct Settings {
    static const uint8_t kNameSize = 16;  // the last character is always 0
    static const uint8_t kChannelSize = 4;

    char channels[8][kChannelSize] = {{'B', '1'}, {'B', '2'}, {'B', '3'}, {'B', '4'},
                                      {'A', '1'}, {'A', '2'}, {'A', '3'}, {'A', '4'}};
    char name[kNameSize] = {};
    uint16_t size_mb = 128;
    uint8_t conversions = board::kConversionsHz / 100;  // of each input in a scan
    bool start_at_power = false;
    bool stream = false;
    bool resume = true;  // go on in another file after a reset, and when the file is full

    // Returns nullptr, or what is wrong; then nothing has changed.
    const FlashChar* apply(const char* key, const char* value);

    uint8_t mask() const;                 // bit k: input k is recorded
    uint8_t recorded() const;             // how many are
    void put_channels(Text& text) const;  // as HOP.CFG has them
};

const FlashChar* wrong_value();

// Cut `key = value` at the first `=` and trim both parts. Returns nullptr, or what is wrong.
const FlashChar* split(char* line, char*& key, char*& value);
