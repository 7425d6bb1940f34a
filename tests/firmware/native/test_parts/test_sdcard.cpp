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
        CHECK(wake() && card.state() == SdCard::Ready);
        CHECK(write(5, 0xA5) && fake::card.content[5 * 512 + 511] == 0xA5);
        uint8_t data[512] = {};
        CHECK(card.read(5, data) && data[0] == 0xA5 && data[511] == 0xA5);
        CHECK(!card.read(64, data));  // there is no such sector
        CHECK(!write(64, 1) && write(63, 1));
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
    CHECK(card.write(1, data));
    int polls = 0;
    while (card.state() == SdCard::Busy) {
        const uint32_t before = fake::now_us;
        card.poll();
        CHECK(fake::now_us - before < 100);
        ++polls;
    }
    CHECK(card.written() && polls > 1000);
    CHECK(card.longest_busy_ms >= 599 && card.longest_busy_ms <= 601);
}

TEST(a_card_that_stays_busy_is_given_up_and_can_be_woken) {
    CHECK(wake());
    fake::card.busy_us = 10000000;
    CHECK(!write(1, 1) && card.state() == SdCard::Down);
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
    CHECK(wake() && !card.write_protected());
    fake::card.write_protected = true;
    CHECK(!write(1, 1) && card.write_protected());
    CHECK(wake() && card.write_protected());
}

TEST(a_card_that_lost_contact_is_not_ready) {
    CHECK(wake());
    fake::card.lose_power();
    CHECK(!card.present() && card.state() == SdCard::Down);
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
