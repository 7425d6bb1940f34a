#include <cstring>

#include "check.h"
#include "fake_board.h"
#include "sdcard.h"

namespace {

bool wake() {
    card.begin();
    return card.settle();
}

bool write(uint32_t sector, int fill) {
    uint8_t data[512];
    memset(data, fill, sizeof data);
    card.write(sector, data);
    return card.settle() && card.written();
}

}  // namespace

TEST(sectors_are_written_and_read_on_both_kinds_of_card) {
    for (bool by_sector : {true, false}) {
        fake::power_on();
        fake::card.by_sector = by_sector;
        card.begin();
        CHECK(!fake::card.fast);  // a card that wakes up takes no more than 400 kHz
        CHECK(wake() && card.state() == SdCard::Ready && fake::card.fast);
        card.begin();
        CHECK(!fake::card.fast && wake());
        CHECK(write(5, 0xA5) && fake::card.content[5 * 512 + 511] == 0xA5);
        uint8_t data[512] = {};
        CHECK(card.read(5, data) && data[0] == 0xA5 && data[511] == 0xA5);
        CHECK(!fake::card.holds_bus());
        CHECK(!card.read(64, data));  // there is no such sector
        CHECK(!write(64, 1) && write(63, 1));
        CHECK(!fake::card.holds_bus());  // others may use the bus
    }
}

TEST(a_card_of_another_kind_may_follow) {
    for (int k = 0; k < 6; ++k) {
        fake::card.lose_power();
        fake::card.serial_number = static_cast<uint8_t>(k);
        fake::card.by_sector = k % 3 == 0;
        fake::card.version_1 = k % 3 == 1;
        CHECK(wake() && write(3, k) && fake::card.content[3 * 512 + 99] == k);
    }
}

TEST(no_card_is_found_out_in_time) {
    fake::card.inserted = false;
    CHECK(!wake() && card.state() == SdCard::Down);
    CHECK(fake::now_us < 1500000);
}

TEST(polling_a_busy_card_never_waits) {
    CHECK(wake());
    fake::card.busy_us = 600000;
    uint8_t data[512] = {};
    CHECK(card.write(1, data) && !fake::card.holds_bus());  // others may use the bus
    int polls = 0;
    while (card.state() == SdCard::Busy) {
        const uint32_t before = fake::now_us;
        card.poll();
        CHECK(fake::now_us - before < 100 && !fake::card.holds_bus());
        ++polls;
    }
    CHECK(card.written() && polls > 1000);
    CHECK(card.longest_busy_ms >= 599 && card.longest_busy_ms <= 601);
}

TEST(a_card_that_stays_busy_is_given_up_and_can_be_woken) {
    CHECK(wake());
    fake::card.busy_us = 10000000;
    CHECK(!write(1, 1) && card.state() == SdCard::Down);
    CHECK(fake::now_us > 2000000 && fake::now_us < 2200000);
    fake::card.lose_power();
    fake::card.busy_us = 300;
    CHECK(wake() && write(1, 2));
}

TEST(refused_and_failed_writes_are_told) {
    CHECK(wake());
    fake::card.refuse = 1;
    CHECK(!write(1, 1) && card.state() == SdCard::Ready && write(1, 1));
    fake::card.fail_later = 1;
    CHECK(!write(2, 1) && card.state() == SdCard::Ready && write(2, 1));
}

TEST(write_protection_is_told_by_sheet_and_status) {
    fake::card.write_protected = true;
    CHECK(wake() && card.write_protected());
    fake::card.write_protected = false;
    CHECK(wake() && !card.write_protected());
    fake::card.write_protected = true;
    CHECK(!write(1, 1) && card.write_protected());
    CHECK(wake() && card.write_protected());
}

TEST(a_card_that_lost_contact_is_not_ready) {
    CHECK(wake());
    fake::card.lose_power();
    CHECK(!card.present() && card.state() == SdCard::Down && !fake::card.holds_bus());
    CHECK(wake());
    fake::card.inserted = false;
    CHECK(!write(1, 1) && card.state() == SdCard::Down);
}

TEST(another_card_has_another_id) {
    CHECK(wake());
    const uint16_t id = card.id();
    CHECK(wake() && card.id() == id);
    fake::card.serial_number = 2;
    CHECK(wake() && card.id() != id);
}

TEST(a_bad_reply_while_the_card_starts_is_card_down_and_never_another_addressing) {
    for (bool by_sector : {true, false}) {
        for (int command : {0, 8, 9, 10, 16, 55, 58, 59}) {
            for (uint8_t reply : {0xFF, 0x08, 0x04, 0x7F, 0x01, 0x00}) {
                fake::power_on();
                fake::card.by_sector = by_sector;
                CHECK(wake() && write(3, 0x33));
                const uint16_t id = card.id();
                fake::card.bad_command = static_cast<uint8_t>(command);
                fake::card.bad_reply = reply;
                fake::card.bad_replies = 1;
                fake::card.lose_power();
                if (!wake()) CHECK(card.state() == SdCard::Down && wake());
                CHECK(card.id() == id);
                CHECK(write(5, 0xA5) && fake::card.content[5 * 512] == 0xA5);
                CHECK(fake::card.content[3 * 512] == 0x33);
                // That a card says yes and does nothing cannot be seen from outside.
                CHECK(fake::card.checks() || (command == 59 && reply == 0));
            }
        }
    }
}

TEST(a_card_never_seen_that_does_not_say_how_it_counts_is_asked_again) {
    for (bool by_sector : {true, false}) {
        for (uint8_t reply : {0xFF, 0x08, 0x04, 0x7F, 0x01}) {
            fake::power_on();
            fake::card.by_sector = by_sector;
            fake::card.bad_command = 58;
            fake::card.bad_reply = reply;
            fake::card.bad_replies = 1;
            CHECK(!wake() && card.state() == SdCard::Down);
            CHECK(wake() && fake::card.checks());
            CHECK(write(5, 0xA5) && fake::card.content[5 * 512] == 0xA5);
        }
    }
}

// Only "illegal command" says that a card cannot check.
TEST(a_card_never_seen_whose_answer_to_cmd59_is_an_error_is_asked_again) {
    for (uint8_t reply : {0xFF, 0x08, 0x7F, 0x40, 0x01, 0x05}) {
        fake::power_on();
        fake::card.bad_command = 59;
        fake::card.bad_reply = reply;
        fake::card.bad_replies = 1;
        CHECK(!wake() && card.state() == SdCard::Down);
        CHECK(wake() && fake::card.checks());
    }
}

TEST(a_question_that_was_refused_is_not_waited_for) {
    for (uint8_t command : {9, 10, 58, 59}) {
        fake::power_on();
        fake::card.bad_command = command;
        fake::card.bad_reply = 0x08;
        fake::card.bad_replies = 1;
        CHECK(!wake() && fake::now_us < 50000);
    }
}

TEST(a_card_that_starts_leaves_the_bus_between_questions) {
    card.begin();
    while (card.state() == SdCard::Starting) {
        card.poll();
        CHECK(!fake::card.holds_bus() || fake::card.commands[9]);
    }
    CHECK(!fake::card.holds_bus());
}

TEST(a_card_that_counts_otherwise_than_its_sheet_says_is_refused) {
    fake::card.by_sector = true;
    fake::card.sheet_says_bytes = true;
    CHECK(!wake());
    fake::card.by_sector = false;
    CHECK(wake());
}

TEST(starting_never_waits_for_a_slow_sheet) {
    for (uint32_t late_us : {0u, 20000u, 90000u, 110000u, 400000u}) {
        fake::power_on();
        fake::card.sheet_late_us = late_us;
        card.begin();
        uint32_t longest = 0;
        while (card.state() == SdCard::Starting) {
            const uint32_t before = fake::now_us;
            card.poll();
            if (fake::now_us - before > longest) longest = fake::now_us - before;
        }
        CHECK(longest < 1000);
        CHECK((card.state() == SdCard::Ready) == (late_us < 100000));
    }
}

TEST(the_card_checks_what_it_is_sent) {
    CHECK(wake() && fake::card.checks());
    fake::card.disturb = 1;  // a bit of the next block, on its way
    CHECK(!write(4, 0x44) && fake::card.content[4 * 512] != 0x44);
    CHECK(write(4, 0x44) && fake::card.content[4 * 512] == 0x44);
    fake::power_on();
    fake::card.knows_checks = false;  // an old card: better without than not at all
    CHECK(wake() && !fake::card.checks() && write(1, 1));
}

TEST(what_is_read_is_checked) {
    CHECK(wake() && write(2, 0x22));
    uint8_t data[512];
    fake::card.disturb_read = 1;
    CHECK(!card.read(2, data));
    CHECK(card.read(2, data) && data[7] == 0x22);
    fake::card.disturb_sheet = 1;
    const uint32_t before_us = fake::now_us;
    CHECK(!wake() && fake::now_us - before_us < 50000);  // it need not be waited for
    CHECK(wake());
}

TEST(a_status_that_comes_broken_protects_no_card_for_good) {
    CHECK(wake());
    fake::card.bad_command = 13;
    fake::card.bad_reply = 0;  // and no second byte: the bus reads as ones
    fake::card.bad_replies = 1;
    CHECK(!write(1, 1));
    CHECK(write(1, 1) && !card.write_protected());
}

// The watchdog bites after 2 s.
TEST(the_watchdog_is_fed_while_a_card_is_waited_for) {
    for (const bool settles : {true, false}) {
        fake::power_on();
        fake::card.sheet_late_us = 80000;
        CHECK(wake());
        fake::card.busy_us = 1800000;
        uint8_t data[512] = {};
        CHECK(card.write(1, data));
        CHECK(settles ? card.settle() : card.finish());
        CHECK(fake::longest_unfed_us < 10000 && fake::now_us - fake::fed_us < 10000);
    }
}
