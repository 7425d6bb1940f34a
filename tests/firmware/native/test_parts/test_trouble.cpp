// What becomes of a session when the card has changed, or fails, or is full.
#include <vector>

#include "files.h"
#include "session_rig.h"

// The card comes back; one byte of these sectors is another.
TEST(a_card_without_our_file_is_not_written_to) {
    for (const int changed : {0, 1, 2}) {
        fake::power_on();
        if (!insert_card()) return;
        Rig rig;
        CHECK(rig.session.start() == kNoTrouble);
        rig.run(100);
        fake::card.inserted = false;
        rig.run(100);
        fake::card.inserted = true;
        fake::card.lose_power();
        FATFS volume;
        FIL file;
        CHECK(logfile::mount(volume) == kNoTrouble);
        CHECK(f_open(&file, "HOP00001.HOP", FA_READ) == FR_OK);
        const uint32_t header = volume.database + (file.obj.sclust - 2) * volume.csize;
        if (changed) fake::card.content[(changed == 1 ? volume.dirbase : header) * 512 + 100] ^= 1;
        f_mount(nullptr, "", 0);
        fake::card.lose_power();
        const int writes = fake::card.writes;
        rig.run(300);
        CHECK(rig.session.over() == (changed != 0));
        CHECK((fake::card.writes == writes) == (changed != 0));
        board::sample(0);
        CHECK(rig.session.stop(End::Full) == kNoTrouble);
        CHECK(rig.session.end() == (changed ? End::Gone : End::Full));
        CHECK((fake::card.writes == writes) == (changed != 0));
        CHECK(rig.session.interrupted());
        CHECK(rig.session.tally.written + rig.session.lost() == rig.session.due());
        CHECK(rig.session.start(true) == kNoTrouble && !rig.session.over());
        CHECK(rig.stop() == kNoTrouble);
    }
}

// Attempts of a logger that shall begin, in so many seconds: 0.5 s apart, 1, 2, 4, and 4 s on.
static int attempts(Rig& rig, uint32_t seconds) {
    int count = 0;
    for (const uint32_t end_us = fake::now_us + seconds * 1000000; fake::now_us < end_us;) {
        if (rig.session.wants_to_begin()) {
            ++count;
            rig.session.start(rig.session.interrupted());
        }
        fake::now_us += 1000;
    }
    return count;
}

TEST(a_card_error_is_tried_again_with_growing_pauses) {
    if (!insert_card()) return;
    Rig rig;
    rig.session.wants_to_begin();
    fake::card.refuse = 3;
    CHECK(rig.session.start() == kCardError);
    CHECK(attempts(rig, 20) == 0);  // nothing shall begin
    rig.session.settings.start_at_power = true;
    fake::card.refuse = 1000;
    const int first = attempts(rig, 8);
    CHECK(first >= 3 && first <= 5);
    const int then = attempts(rig, 40);
    CHECK(then >= 9 && then <= 10);
    for (uint8_t byte : fake::eeprom) CHECK(byte == 0xFF);  // each write wears it
    fake::card.refuse = 0;
    CHECK(attempts(rig, 5) == 1 && rig.session.running());
    CHECK(decode("HOP00001.HOP").kinds == "H");
    CHECK(rig.stop() == kNoTrouble && attempts(rig, 20) == 0);
}

// Three refused writes, wherever they come: what was published is closed, and else its name is
// taken by the next attempt.
TEST(an_attempt_that_fails_leaves_no_file_open_and_no_number_out) {
    bool failed = true;
    for (int writes = 0; failed; ++writes) {
        fake::power_on();
        if (!insert_card()) return;
        Rig rig;
        fake::card.writes_left = writes;
        fake::card.failures = 3;
        const bool again = rig.session.start();
        failed = fake::card.failed;
        fake::card.writes_left = -1;
        if (again) CHECK(rig.session.start() == kNoTrouble);
        CHECK(rig.stop() == kNoTrouble);
        const std::string second = decode("HOP00002.HOP").kinds;
        CHECK(decode("HOP00001.HOP").kinds == "HS" && (second.empty() || second == "HS"));
        CHECK(again || second.empty());
    }
}

TEST(a_full_card_is_asked_again_when_another_comes) {
    if (!insert_card()) return;
    const std::vector<uint8_t> empty = fake::card.content;
    {
        FATFS volume;
        CHECK(logfile::mount(volume) == kNoTrouble);
        memset(&fake::card.content[volume.fatbase * 512], 0xFF, volume.fsize * 512);
        f_mount(nullptr, "", 0);
    }
    Rig rig;
    rig.session.settings.start_at_power = true;
    CHECK(attempts(rig, 1) == 1 && rig.session.trouble() == kNoRoom);
    CHECK(attempts(rig, 20) == 0 && rig.session.trouble() == kNoRoom);
    fake::card.content = empty;
    fake::card.lose_power();
    CHECK(attempts(rig, 10) == 1 && rig.session.running());
}
