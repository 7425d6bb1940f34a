#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "check.h"
#include "crc16.h"
#include "fake_board.h"
#include "link.h"

namespace {

// The host's side, from SPEC.md: the good frames among the bytes, without CRC.
std::vector<std::string> counted_frames(const std::string& bytes) {
    std::vector<std::string> found;
    for (size_t start = 0; start < bytes.size();) {
        size_t end = bytes.find('\0', start);
        if (end == std::string::npos) break;
        std::string content;
        size_t at = start;
        while (at < end) {
            const size_t code = static_cast<uint8_t>(bytes[at]);
            content += bytes.substr(at + 1, std::min(code, end - at) - 1);
            at += code;
            if (at < end) content += '\0';
        }
        start = end + 1;
        if (at != end) continue;  // the last code leads elsewhere
        if (content.size() < 4) continue;
        const uint16_t told =
            static_cast<uint16_t>(static_cast<uint8_t>(content[content.size() - 2]) |
                                  static_cast<uint8_t>(content.back()) << 8);
        if (crc16(content.data(), content.size() - 2) != told) continue;
        found.push_back(content.substr(0, content.size() - 2));
    }
    return found;
}

// And without counter.
std::vector<std::string> frames(const std::string& bytes) {
    std::vector<std::string> found = counted_frames(bytes);
    for (std::string& frame : found) frame.erase(1, 1);
    return found;
}

std::string send(Link& link, char type, const std::string& payload) {
    memcpy(link.payload(), payload.data(), payload.size());
    link.send(type, static_cast<uint8_t>(payload.size()));
    return fake::sent(link);
}

void receive(Link& link, const std::string& bytes) {
    for (char byte : bytes) link.receive(static_cast<uint8_t>(byte), false);
}

// The command received, or "!" and what is wrong with it, or "".
std::string command(Link& link) {
    const FlashChar* problem;
    const char* line = link.command(problem);
    if (!line) return "";
    const std::string text =
        problem ? std::string("!") + reinterpret_cast<const char*>(problem) : std::string(line);
    link.next_command();
    return text;
}

}  // namespace

TEST(frames_arrive_as_sent) {
    Link link;
    for (int size = 0; size <= Link::kPayload; ++size) {
        for (int fill : {0, 1, 255}) {
            const std::string payload(static_cast<size_t>(size), static_cast<char>(fill));
            const std::string bytes = send(link, 'D', payload);
            CHECK(bytes.front() == 0 && bytes.back() == 0);
            CHECK(bytes.find('\0', 1) == bytes.size() - 1);
            CHECK(frames(bytes) == std::vector<std::string>{"D" + payload});
        }
    }
    CHECK(!link.sending());
}

TEST(a_short_frame_behind_a_long_one_ends_with_its_own_zero) {
    Link link;
    for (int size = Link::kPayload; size >= 0; --size) {
        const std::string payload(static_cast<size_t>(size), 'x');
        const std::string bytes = send(link, 'D', payload);
        CHECK(bytes.back() == 0 && frames(bytes) == std::vector<std::string>{"D" + payload});
    }
}

TEST(frames_are_counted_modulo_256) {
    Link link;
    for (int k = 0; k < 600; ++k) {
        const std::string frame = counted_frames(send(link, k % 3 ? 'D' : 'L', "text")).at(0);
        CHECK(static_cast<uint8_t>(frame[1]) == k % 256);
    }
}

TEST(a_wrong_byte_costs_one_frame) {
    Link link;
    std::string bytes;
    for (int k = 0; k < 3; ++k)
        bytes += send(link, 'D', std::string("a\0b", 3) + static_cast<char>(k));
    for (size_t at = 0; at < bytes.size(); ++at) {
        for (int wrong = 0; wrong < 256; ++wrong) {
            std::string noisy = bytes;
            noisy[at] = static_cast<char>(wrong);
            CHECK(frames(noisy).size() >= 2);
        }
        std::string dropped = bytes, doubled = bytes;
        dropped.erase(at, 1);
        doubled.insert(at, 1, bytes[at]);
        CHECK(frames(dropped).size() >= 2 && frames(doubled).size() >= 2);
    }
}

TEST(commands_with_and_without_checksum) {
    Link link;
    receive(link, "start\r\n");
    CHECK(command(link) == "start");
    receive(link, "stop*B8E2\n");
    CHECK(command(link) == "stop");
    receive(link, "stop*b8e2\n");
    CHECK(command(link) == "stop");
    for (const char* bad :
         {"stop*B8E3\n", "stop*B8E\n", "stop*B8E22\n", "stop*\n", "stup*B8E2\n", "stop*B8EG\n"}) {
        receive(link, bad);
        CHECK(command(link) == "!checksum");
    }
    CHECK(command(link) == "");
}

TEST(a_checksum_has_any_digits_capital_or_not) {
    Link link;
    for (int k = 0; k < 500; ++k) {
        const std::string line = "time " + std::to_string(k);
        for (const char* digits : {"*%04X\n", "*%04x\n"}) {
            char sum[8];
            snprintf(sum, sizeof sum, digits, crc16(line.data(), line.size()));
            receive(link, line + sum);
            CHECK(command(link) == line);
        }
    }
}

TEST(what_is_no_digit_is_no_checksum_whatever_its_line) {
    Link link;
    for (int k = 0; k < 200000; ++k) {
        const std::string line = std::to_string(k);
        const uint16_t crc = crc16(line.data(), line.size());
        if (crc >> 4 != 0xFFF && crc & 0xFFF0) continue;  // what a wrong digit might count as
        char sum[8];
        snprintf(sum, sizeof sum, "*%04X\n", crc);
        for (const char wrong : {'G', 'g', '/', ':', '@', '`', '~'}) {
            sum[4] = wrong;
            receive(link, line + sum);
            CHECK(command(link) == "!checksum");
        }
    }
}

TEST(a_line_that_comes_too_early_is_dropped_whole) {
    Link link;
    receive(link, "info\nst");
    CHECK(command(link) == "info");
    receive(link, "op\nstatus\n");
    CHECK(command(link) == "status");
}

TEST(damaged_and_endless_lines_are_refused) {
    Link link;
    receive(link, "sto");
    link.receive('p', true);
    receive(link, "\n");
    CHECK(command(link)[0] == '!');
    receive(link, std::string(1000, 'x') + "\n");
    CHECK(command(link)[0] == '!');
    receive(link, "ok\n");
    CHECK(command(link) == "ok");
}
