#include <cstring>
#include <string>

#include "check.h"
#include "fake_board.h"
#include "identity.h"
#include "line.h"
#include "settings.h"
#include "text.h"

namespace {

bool apply(Settings& settings, std::string line) {
    char* key;
    char* value;
    if (split(&line[0], key, value)) return false;
    return !settings.apply(key, value);
}

std::string channels(const Settings& settings) {
    char text[64];
    Text writer(text, sizeof text);
    settings.put_channels(writer);
    return std::string(text, writer.length());
}

}  // namespace

TEST(settings_are_taken_over) {
    Settings settings;
    CHECK(channels(settings) == "B1 B2 B3 B4 A1 A2 A3 A4" && settings.mask() == 0xFF);
    CHECK(apply(settings, "rate = 400") && settings.conversions == 2);
    CHECK(apply(settings, "  rate=100  ") && settings.conversions == 8);
    CHECK(apply(settings, "channels = dash - -  B0 - - - _9"));
    CHECK(channels(settings) == "dash - - B0 - - - _9" && settings.mask() == 0x89);
    CHECK(settings.recorded() == 3);
    CHECK(apply(settings, "name = second run") && !strcmp(settings.name, "second run"));
    CHECK(apply(settings, "name =") && !settings.name[0]);
    CHECK(apply(settings, "start = power") && settings.start_at_power);
    CHECK(apply(settings, "stream = on") && settings.stream);
    CHECK(apply(settings, "size_mb = 4095") && settings.size_mb == 4095);
}

TEST(nonsense_changes_nothing) {
    Settings settings;
    const Settings before = settings;
    for (const char* line : {"rate",
                             "rate =",
                             "rate = 99",
                             "rate = 100.0",
                             "rate = -100",
                             "rate = 4294967396",
                             "rate = 1e2",
                             "channels =",
                             "channels = a b c d e f g",
                             "channels = a b c d e f g h i",
                             "channels = - - - - - - - -",
                             "channels = a a - - - - - -",
                             "channels = 12345 - - - - - - -",
                             "channels = ä - - - - - - -",
                             "channels = -a - - - - - - -",
                             "name = 0123456789abcdef",
                             "start = off",
                             "stream = yes",
                             "size_mb = 0",
                             "size_mb = 4096",
                             "size_mb = 18446744073709551617",
                             "= 5",
                             "=",
                             "Rate = 100",
                             "rate rate = 100",
                             "rate = 100 200",
                             "format = FAT32"}) {
        CHECK(!apply(settings, line));
        CHECK(memcmp(&settings, &before, sizeof settings) == 0);
    }
}

TEST(random_lines_are_refused_or_harmless) {
    uint32_t seed = 1;
    Settings settings;
    for (int round = 0; round < 20000; ++round) {
        static const char* const keys[] = {"rate",  "channels", "name",
                                           "start", "stream",   "size_mb"};
        std::string line = keys[round % 6] + std::string("=");
        for (int k = 0; k < round % 50; ++k) {
            seed = seed * 1664525 + 1013904223;
            line += static_cast<char>(0x20 + (seed >> 24) % 0x5F);
        }
        apply(settings, line);
        CHECK(settings.mask() && strlen(settings.name) < sizeof settings.name && settings.size_mb);
        CHECK(settings.conversions == 8 || settings.conversions == 4 || settings.conversions == 2);
    }
}

TEST(lines_are_cut_out_of_bytes) {
    Line line;
    std::string seen;
    for (char byte : std::string("\n  # comment \xC3\xA4 of more than sixty characters, which is "
                                 "no harm at all, is it\r\n"
                                 "rate = 100\r\n\r\nb\x01\nlast\tone\n")) {
        switch (line.push(static_cast<uint8_t>(byte))) {
            case Line::Complete:
                seen += std::string(line.text()) + "|";
                line.clear();
                break;
            case Line::Refused:
                seen += "refused|";
                line.clear();
                break;
            default:
                break;
        }
    }
    CHECK(seen == "rate = 100|refused|last one|");
}

TEST(a_line_may_be_exactly_so_long) {
    for (int length : {Line::kLongest + 0, Line::kLongest + 1}) {
        Line line;
        for (int k = 0; k < length; ++k) CHECK(line.push('x') == Line::Collecting);
        CHECK(line.push('\n') == (length == Line::kLongest ? Line::Complete : Line::Refused));
    }
}

TEST(numbers_as_text) {
    char text[60];
    Text writer(text, sizeof text);
    writer.number(4294967295u);
    writer.put(' ');
    writer.signed_number(-2147483647 - 1);
    writer.put(' ');
    writer.signed_number(-1250);
    writer.signed_number(0);
    writer.put(' ');
    writer.number(12, 5);
    writer.put(' ');
    writer.hex(0x1A2B, 8);
    CHECK(std::string(text, writer.length()) == "4294967295 -2147483648 -12500 00012 00001A2B");
    Text small(text, 3);
    small.number(123456);
    CHECK(small.length() == 3);
    uint32_t value = 0;
    CHECK(read_number("4294967295", 4294967295u, value) && value == 4294967295u);
    CHECK(!read_number("4294967296", 4294967295u, value) && !read_number("", 9, value));
    CHECK(!read_number("7", 5, value) && !read_number("12", 5, value) &&
          !read_number(" 1", 5, value));
}

TEST(an_erased_eeprom_says_nothing) {
    char text[identity::kCalibrationSize];
    int16_t ppm;
    identity::calibration(text);
    CHECK(identity::session_number() == 0 && identity::device() == 0 && !text[0]);
    CHECK(!identity::clock_ppm(ppm));
}

TEST(the_eeprom_keeps_what_belongs_to_the_logger) {
    char text[identity::kCalibrationSize];
    identity::set_device(65534);
    identity::set_calibration("rig-2026-02");
    identity::calibration(text);
    CHECK(identity::device() == 65534 && !strcmp(text, "rig-2026-02"));
    for (int16_t wanted : {-20000, -1, 0, 1, 20000}) {
        int16_t ppm = 7;
        identity::set_clock_ppm(wanted);
        CHECK(identity::clock_ppm(ppm) && ppm == wanted);
    }
}

TEST(a_session_number_torn_by_a_power_failure_is_not_believed) {
    for (uint32_t number = 1; number <= 65535; number += number < 10 || number > 65520 ? 1 : 997) {
        identity::set_session_number(static_cast<uint16_t>(number));
        CHECK(identity::session_number() == number);
    }
    identity::set_session_number(1);  // after 65535
    CHECK(identity::session_number() == 1);
    const std::vector<uint8_t> before = fake::eeprom;
    identity::set_session_number(2);
    const std::vector<uint8_t> after = fake::eeprom;
    for (size_t written = 0; written <= 8; ++written) {  // so many of the bytes were written
        fake::eeprom = before;
        for (size_t k = 0; k < written; ++k) fake::eeprom[k] = after[k];
        const uint16_t number = identity::session_number();
        CHECK(number == 1 || number == 2);
    }
}
