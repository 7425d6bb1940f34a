// Inputs beside the eight: what the sampling clock sees of a wheel, a button
// and a temperature.
#include "beside.h"
#include "check.h"

namespace {

// Lets scans of 64 conversions pass; the inputs are as `pulse` and `button` say
// of a conversion.
struct Clock {
    Beside beside;
    uint32_t conversion = 0, scan = 0;

    template <typename Pulse, typename Button>
    // The record of the last scan is told by the next.
    void run(uint32_t scans, Pulse pulse, Button button) {
        for (uint32_t end = scan + scans; scan != end;) {
            const uint32_t at = conversion++;
            beside.look(pulse(at), button(at), scan);
            beside.keep();
            if (conversion % 64 == 0) ++scan;
        }
    }
};

bool never(uint32_t) { return false; }

Beside::Record record(const Block& block, int k) {
    Beside::Record one;
    memcpy(&one, block.payload + 6 + k * sizeof one, sizeof one);
    return one;
}

}  // namespace

TEST(pulses_are_counted_and_the_last_ones_age_is_told) {
    Clock clock;
    clock.beside.start(10);
    // Every 100 conversions one, 40 long, the first at conversion 20.
    clock.run(
        31, [](uint32_t at) { return at >= 20 && (at - 20) % 100 < 40; }, never);
    CHECK(clock.beside.count() == 3);
    Block block;
    block.clear('I');
    clock.beside.put(block);
    uint32_t first;
    memcpy(&first, block.payload, 4);
    CHECK(first == 10 && block.payload[4] == 10 && block.payload[5] == 3 && !clock.beside.count());
    for (int k = 0; k < 3; ++k) {
        const uint32_t last = 640u * (k + 1) - 1;  // conversion at the record's end
        const Beside::Record one = record(block, k);
        CHECK(one.pulses == (last - 20) / 100 + 1 && one.since == (last - 20) % 100);
        CHECK(one.marks == 0 && one.zero == 0 && one.temperature == 0);
    }
}

TEST(before_the_first_pulse_and_long_after_the_last_its_age_stays_at_its_end) {
    Clock clock;
    clock.beside.start(40);
    clock.run(41, never, never);
    Block block;
    clock.beside.put(block);
    CHECK(record(block, 0).since == 65535 && record(block, 0).pulses == 0);
    clock.run(
        1, [](uint32_t at) { return at % 64 == 0; }, never);
    clock.run(1240, never, never);
    clock.beside.put(block);
    CHECK(block.payload[5] == 31 && record(block, 30).since == 65535);
    CHECK(record(block, 30).pulses == 1 && record(block, 0).since == 39 * 64 - 1);
}

TEST(a_mark_is_a_press_that_lasts_30_ms_and_bouncing_is_one) {
    Clock clock;
    clock.beside.start(10);
    clock.run(11, never, [](uint32_t at) { return at < 191; });  // a conversion too short
    CHECK(clock.beside.marks() == 0);
    clock.run(20, never, [](uint32_t at) {
        const uint32_t since = at - 704;  // it bounces for a while, at either end
        return since < 800 ? since > 100 || since % 3 == 0 : since < 900 && since % 3 == 0;
    });
    CHECK(clock.beside.marks() == 1);
    clock.run(10, never, [](uint32_t at) { return (at - 1984) < 192; });
    CHECK(clock.beside.marks() == 2);
    clock.beside.start(10);
    clock.run(11, never, never);
    CHECK(clock.beside.marks() == 0);
}

TEST(records_that_find_no_room_are_missing_and_the_next_say_which_scan_they_are_of) {
    Clock clock;
    clock.beside.start(10);
    clock.beside.note_temperature(233);
    clock.run(701, never, never);
    CHECK(clock.beside.count() == Beside::kRecords && Beside::kRecords == 60);
    Block block;
    clock.beside.put(block);
    CHECK(record(block, 59).temperature == 233);
    clock.run(20, never, never);
    clock.beside.put(block);
    uint32_t first;
    memcpy(&first, block.payload, 4);
    CHECK(first == 710 && block.payload[5] == 2);
}

TEST(records_that_do_not_follow_are_not_put_into_one_block) {
    Clock clock;
    clock.beside.start(10);
    clock.run(11, never, never);
    const auto busy = [&](uint32_t scans) {  // the main loop keeps nothing
        for (uint32_t end = clock.scan + scans; clock.scan != end;) {
            clock.beside.look(false, false, clock.scan);
            if (++clock.conversion % 64 == 0) ++clock.scan;
        }
    };
    busy(30);  // the first of these waits, the others are lost
    clock.beside.keep();
    clock.run(10, never, never);
    CHECK(clock.beside.count() == 2);  // 10, 20; 50 does not follow
    Block block;
    clock.beside.put(block);
    clock.run(10, never, never);
    clock.beside.put(block);
    uint32_t first;
    memcpy(&first, block.payload, 4);
    CHECK(first == 60 && block.payload[5] == 1);
}
