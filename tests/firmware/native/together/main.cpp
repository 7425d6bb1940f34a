// A session of the firmware as it is for a board that converts all inputs at
// once, with 16 bits:
//
//     together EMPTY_IMAGE IMAGE RATE_HZ SECONDS
//
// Input k is given the code 5000 + 7000 k + 13 n + k n at conversion number n
// of a scan; a wheel's pulse comes every 100 ms from 50 ms on, and the button
// for marks is held from second 1 to 1.5. The card is IMAGE afterwards.
#include <cstdlib>

#include "../test_parts/session_rig.h"

int failures = 0;

static void pass_scan(Session& session, uint32_t& conversion, uint32_t per_scan) {
    for (uint32_t n = 0; n < per_scan; ++n, ++conversion) {
        uint16_t codes[board::kInputs];
        for (uint32_t k = 0; k < board::kInputs; ++k) {
            codes[k] = static_cast<uint16_t>(5000 + 7000 * k + 13 * n + k * n);
        }
        fake::sampler.collect(codes);
        const uint32_t phase = (conversion + 640 - 320) % 640;
        const bool marked =
            conversion >= board::kConversionsHz && conversion < board::kConversionsHz * 3u / 2;
        board::beside.look(phase < 64, marked, fake::sampler.due());
    }
    fake::sampler.collect_supply(24824);  // 3300 mV
    board::beside.note_temperature(14895);
    Scan scan;
    session.take(scan);
    const uint32_t until_us = fake::now_us + 1000000u / board::kConversionsHz * per_scan;
    while (fake::now_us < until_us) {
        session.poll();
        fake::now_us += 156;
    }
}

int main(int count, char** arguments) {
    if (count != 5) return 2;
    fake::image_path = arguments[1];
    fake::power_on();
    fake::reference_code = 24824;
    if (!insert_card()) return 2;
    Rig rig;
    char rate[8];
    std::snprintf(rate, sizeof rate, "%s", arguments[3]);
    if (rig.session.settings.apply("rate", rate)) return 3;
    if (rig.session.settings.apply("pulses_per_km", "568")) return 3;
    if (rig.session.start() != kNoTrouble) return 4;
    uint32_t conversion = 0;
    const int scans = std::atoi(arguments[3]) * std::atoi(arguments[4]);
    for (int k = 0; k < scans; ++k) {
        pass_scan(rig.session, conversion, rig.session.settings.conversions);
    }
    if (rig.stop() != kNoTrouble || rig.session.lost()) return 5;
    std::FILE* file = std::fopen(arguments[2], "wb");
    const bool kept =
        file && std::fwrite(fake::card.content.data(), fake::card.content.size(), 1, file);
    return file && !std::fclose(file) && kept ? 0 : 6;
}
