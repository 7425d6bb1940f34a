#include <initializer_list>

#include "block.h"
#include "check.h"
#include "crc16.h"
#include "sampler.h"

TEST(every_input_has_the_same_mean_instant) {
    for (int length : {16, 32, 64}) {
        int instants[8] = {};
        for (int position = 0; position < length; ++position) {
            instants[Sampler::input(static_cast<uint8_t>(position))] += position;
        }
        for (int input = 0; input < 8; ++input)
            CHECK(instants[input] * 8 == length * (length - 1) / 2);
    }
}

// Converts scans of a ramp: conversion number n gives n.
static void convert(Sampler& sampler, int conversions, uint16_t& code) {
    uint8_t ended = 0;  // scans begin and end with input 0
    for (int k = 0; k < conversions; ++k) {
        const uint8_t next = sampler.advance();
        sampler.collect(ended, code++ & 1023);
        ended = next;
    }
}

TEST(sums_of_a_ramp_are_equal) {
    Sampler sampler;
    uint16_t sums[8], late, code = 0;
    uint32_t number;
    for (uint8_t conversions : {8, 4, 2}) {
        sampler.start(conversions);
        CHECK(!sampler.take(sums, number, late));
        code = 0;
        convert(sampler, 8 * conversions, code);
        CHECK(sampler.take(sums, number, late) && number == 0);
        for (uint16_t sum : sums) CHECK(sum * 8 == 8 * conversions * (8 * conversions - 1) / 2);
        CHECK(!sampler.take(sums, number, late));
    }
}

TEST(advance_tells_the_input_of_the_next_conversion) {
    Sampler sampler;
    sampler.start(8);
    for (int position = 1; position < 200; ++position) {
        CHECK(sampler.advance() == Sampler::input(static_cast<uint8_t>(position % 64)));
    }
}

TEST(one_scan_in_32_reads_the_supply_and_keeps_its_mean_instants) {
    for (uint8_t conversions : {8, 4, 2}) {
        Sampler sampler;
        sampler.start(conversions);
        const uint64_t length = 8u * conversions;
        uint64_t now = 0;  // in clocks
        int readings = 0;
        uint8_t input = 0;
        for (uint64_t scan = 0; scan < 100; ++scan) {
            uint64_t instants[8] = {};
            for (uint64_t left = length; left;) {
                const uint8_t ended = input;
                input = sampler.advance();
                if (ended == Sampler::kSupply) {
                    CHECK(left == length / 2 && scan % 32 == 16);
                    ++readings;
                    sampler.collect(ended, static_cast<uint16_t>(scan));
                } else {
                    instants[ended] += now;
                    --left;
                    sampler.collect(ended, 1);
                }
                now += sampler.clocks();
            }
            CHECK(now == (scan + 1) * length * 2500);
            for (uint64_t sum : instants) {
                CHECK(2 * sum == conversions * (2 * scan * length + length - 1) * 2500);
            }
            uint16_t sums[8], late;
            uint32_t number;
            CHECK(sampler.take(sums, number, late) && number == scan);
            for (uint16_t sum : sums) CHECK(sum == conversions);
            if (Sampler::reads_supply(number)) CHECK(sampler.supply_code() == scan);
        }
        CHECK(readings == 3);
    }
}

TEST(a_scan_not_fetched_in_time_is_missing_from_the_numbers) {
    Sampler sampler;
    uint16_t sums[8], late, code = 0;
    uint32_t number;
    sampler.start(2);
    convert(sampler, 3 * 16, code);
    CHECK(sampler.take(sums, number, late) && number == 0);
    CHECK(!sampler.take(sums, number, late));
    convert(sampler, 16, code);
    CHECK(sampler.take(sums, number, late) && number == 3);
    for (uint16_t sum : sums) CHECK(sum == 48 + 63);  // nothing of scans 1 and 2 is left in it
    CHECK(sampler.due() == 4);
}

TEST(late_triggers_are_counted_and_stay_at_their_largest) {
    Sampler sampler;
    uint16_t sums[8], late, code = 0;
    uint32_t number;
    sampler.start(2);
    for (int k = 0; k < 70000; ++k) sampler.note_late_trigger();
    convert(sampler, 16, code);
    CHECK(sampler.take(sums, number, late) && late == 65535);
}

TEST(packed_scans_are_thirteen_bits_lowest_first) {
    const uint16_t sums[8] = {8184, 0, 1, 4096, 8191, 5, 6, 7};
    for (int mask = 1; mask < 256; ++mask) {
        uint8_t packed[13] = {};
        int channels = 0;
        for (int k = 0; k < 8; ++k) channels += mask >> k & 1;
        CHECK(pack_scan(sums, static_cast<uint8_t>(mask), packed) ==
              scan_size(static_cast<uint8_t>(channels)));
        int bit = 0;
        for (int k = 0; k < 8; ++k) {
            if (!(mask >> k & 1)) continue;
            int sum = 0;
            for (int at = 0; at < 13; ++at, ++bit) sum |= (packed[bit / 8] >> bit % 8 & 1) << at;
            CHECK(sum == sums[k]);
        }
    }
}

TEST(crc_is_xmodem) { CHECK(crc16("123456789", 9) == 0x31C3); }

TEST(a_block_is_good_only_where_it_belongs_and_whole) {
    Block block;
    block.clear('D');
    block.seal(0x00010002, 7);
    CHECK(block.good(0x00010002, 7));
    CHECK(!block.good(0x00010002, 8));
    CHECK(!block.good(0x00010003, 7));
    uint8_t* bytes = reinterpret_cast<uint8_t*>(&block);
    for (int bit = 0; bit < 512 * 8; ++bit) {
        bytes[bit / 8] ^= static_cast<uint8_t>(1 << bit % 8);
        CHECK(!block.good(0x00010002, 7));
        bytes[bit / 8] ^= static_cast<uint8_t>(1 << bit % 8);
    }
    for (char& letter : block.magic) {  // another magic, with the check sum that belongs to it
        ++letter;
        block.crc = crc16(&block, 510);
        CHECK(!block.good(0x00010002, 7));
        --letter;
        block.crc = crc16(&block, 510);
        CHECK(block.good(0x00010002, 7));
    }
}
