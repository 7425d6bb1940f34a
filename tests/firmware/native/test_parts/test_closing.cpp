// Files are closed, by `stop` and after a reset, whatever the card does meanwhile.
#include <vector>

#include "identity.h"
#include "session_rig.h"

static uint32_t free_clusters() {
    FATFS volume;
    FATFS* found;
    DWORD count = 0;
    CHECK(f_mount(&volume, "", 1) == FR_OK && f_getfree("", &count, &found) == FR_OK);
    f_mount(nullptr, "", 0);
    return count;
}

static uint32_t file_blocks(const char* name) {
    File file;
    return file.open(name) ? file.blocks() : 0;
}

// The card reads, or writes, so many blocks more and then fails: three times, or for ever.
struct Failing {
    bool reading, for_ever;
};
const Failing kFailing[] = {{true, true}, {true, false}, {false, true}, {false, false}};

static void fail_after(const Failing& how, int blocks) {
    (how.reading ? fake::card.reads_left : fake::card.writes_left) = blocks;
    fake::card.failures = how.for_ever ? -1 : 3;
    fake::card.failed = 0;
}

static bool has_failed() { return fake::card.failed; }

static void heal() {
    fake::card.reads_left = fake::card.writes_left = -1;
    fake::card.lose_power();
}

TEST(a_closed_file_keeps_its_own_room_and_no_more) {
    if (!insert_card()) return;
    const uint32_t free = free_clusters();
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(500);
    CHECK(rig.stop() == kNoTrouble);
    CHECK(file_blocks("HOP00001.HOP") == 1 + 14 + 1);
    CHECK(free - free_clusters() == 1 + 14 + 1);  // clusters of one block
}

TEST(a_file_whose_entry_cannot_be_written_keeps_all_its_room) {
    if (!insert_card()) return;
    const uint32_t free = free_clusters();
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(500);
    {
        FATFS volume;
        CHECK(f_mount(&volume, "", 1) == FR_OK);
        fake::card.bad_sector = volume.dirbase;  // where the entry is
        f_mount(nullptr, "", 0);
    }
    CHECK(rig.stop() == kCardError);
    fake::card.bad_sector = ~0u;
    CHECK(file_blocks("HOP00001.HOP") == 2048 && free - free_clusters() == 2048);
    CHECK(rig.session.meet() == kNoTrouble && decode("HOP00001.HOP").scans == 500);
    CHECK(file_blocks("HOP00001.HOP") == 1 + 14 + 1 && free - free_clusters() == 1 + 14 + 1);
}

TEST(working_memory_may_hold_anything) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(500);
    CHECK(rig.stop() == kNoTrouble);
    FATFS volume;
    FIL file;
    CHECK(logfile::mount(volume) == kNoTrouble);
    CHECK(f_open(&file, "HOP.CFG", FA_WRITE | FA_CREATE_NEW) == FR_OK);
    UINT count;
    CHECK(f_write(&file, "rate=400", 8, &count) == FR_OK && f_close(&file) == FR_OK);
    logfile::Work work;
    memset(static_cast<void*>(&work), 0x55, sizeof work);
    CHECK(logfile::cut(work, 1, 10) == kNoTrouble);
    memset(static_cast<void*>(&work), 0x55, sizeof work);
    std::string line;
    logfile::read_config(
        work,
        [](void* context, uint16_t, Line::State state, char* text) {
            if (state == Line::Complete) *static_cast<std::string*>(context) += text;
        },
        &line);
    CHECK(line == "rate=400");
    f_mount(nullptr, "", 0);
    CHECK(file_blocks("HOP00001.HOP") == 10);
}

TEST(a_session_has_the_next_number_that_is_free) {
    if (!insert_card()) return;
    for (const char* name : {"HOP65535.HOP", "HOP00001.HOP", "HOP00002.HOP"}) {
        Rig rig;
        // Of a logger that has counted elsewhere.
        if (name[3] == '6') identity::set_session_number(65534);
        if (name[7] == '2') fake::eeprom.assign(64, 0xFF);  // a new logger
        CHECK(rig.session.start() == kNoTrouble);
        rig.run(50);
        CHECK(rig.stop() == kNoTrouble && decode(name).scans == 50);
    }
    CHECK(decode("HOP00001.HOP").scans == 50);
}

// Whatever has happened to its blocks since: the end of it is known.
TEST(a_file_that_was_closed_is_not_touched_again) {
    if (!insert_card()) return;
    {
        Rig rig;
        CHECK(rig.session.start() == kNoTrouble);
        rig.run(37 * 200);
        CHECK(rig.stop() == kNoTrouble);
    }
    for (size_t at = 0; at + 512 <= fake::card.content.size(); at += 512) {
        uint8_t* block = &fake::card.content[at];
        if (!memcmp(block, "HOP1D", 5) && block[12] >= 60) block[99] ^= 1;
    }
    const std::vector<uint8_t> before = fake::card.content;
    const int writes = fake::card.writes;
    Rig rig;
    CHECK(rig.session.meet() == kNoTrouble);
    CHECK(fake::card.writes == writes && fake::card.content == before);
}

TEST(only_a_session_that_was_cut_off_is_gone_on_with) {
    for (const bool stopped : {true, false}) {
        fake::power_on();
        if (!insert_card()) return;
        uint32_t id;
        {
            Rig rig;
            CHECK(rig.session.start() == kNoTrouble);
            rig.run(500);
            id = rig.session.id();
            if (stopped) CHECK(rig.stop() == kNoTrouble);
        }
        Rig rig;
        CHECK(rig.session.meet() == kNoTrouble && rig.session.interrupted() != stopped);
        CHECK(rig.session.start(true) == kNoTrouble);
        CHECK(rig.session.continues == (stopped ? 0 : id));
    }
}

// The later the card fails, the further closing has come: the entry is never ahead of the rest.
TEST(an_entry_is_shortened_once_the_files_end_is_found_and_not_before) {
    bool shortened = false;
    for (int reads = 0; reads < 10; ++reads) {
        fake::power_on();
        if (!insert_card()) return;
        Rig rig;
        CHECK(rig.session.start() == kNoTrouble);
        rig.run(100);
        fail_after({true, false}, reads);
        rig.stop();
        heal();
        const bool is_short = file_blocks("HOP00001.HOP") < 2048;
        CHECK(is_short || !shortened);
        shortened = is_short;
    }
    CHECK(shortened);
}

TEST(a_card_that_fails_while_a_session_is_stopped_keeps_what_was_acknowledged) {
    for (const Failing& how : kFailing) {
        bool failed = true;
        for (int blocks = 0; failed; blocks += 1 + blocks / 4) {
            fake::power_on();
            if (!insert_card()) return;
            const uint32_t free = free_clusters();
            uint32_t written;
            {
                Rig rig;
                CHECK(rig.session.start() == kNoTrouble);
                rig.run(100);
                fail_after(how, blocks);
                const Trouble trouble = rig.stop();
                failed = has_failed();
                heal();
                CHECK(failed || !trouble);
                written = rig.session.tally.written;
                const uint32_t taken = free - free_clusters();
                const uint32_t claimed = file_blocks("HOP00001.HOP");
                CHECK(trouble ? taken >= claimed : taken == claimed);
            }
            Rig rig;
            CHECK(rig.session.meet() == kNoTrouble);
            const Found found = decode("HOP00001.HOP");
            CHECK(found.kinds == "HS" && found.scans >= written && written >= 74);
        }
    }
}

TEST(a_card_that_fails_while_a_reset_session_is_closed_loses_nothing) {
    if (!insert_card()) return;
    {
        Rig rig;
        CHECK(rig.session.start() == kNoTrouble);
        rig.run(37 * 20 + 1);
    }
    const std::vector<uint8_t> intact = fake::card.content;
    for (const Failing& how : kFailing) {
        bool failed = true;
        for (int blocks = 0; failed; blocks += 1 + blocks) {
            fake::card.content = intact;
            for (const bool well : {false, true}) {
                if (!well) fail_after(how, blocks);
                Rig rig;
                const Trouble trouble = rig.session.meet();
                if (!well) failed = has_failed();
                if (!failed || well) CHECK(trouble == kNoTrouble);
                heal();
                const Found found = decode("HOP00001.HOP");
                CHECK(found.scans == 37 * 20);
                CHECK(found.kinds == "HS" || (found.kinds == "H" && failed && !well));
            }
        }
    }
}
