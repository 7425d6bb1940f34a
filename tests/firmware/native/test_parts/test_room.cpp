// Where a file finds room on the card.
#include <vector>

#include "files.h"
#include "session_rig.h"

// Let these clusters be free, and no others.
static void set_free(const FATFS& volume, const std::vector<logfile::Run>& runs) {
    uint8_t* table = &fake::card.content[volume.fatbase * 512];
    for (uint32_t k = 2; k < volume.n_fatent; ++k) {
        bool is_free = false;
        for (const logfile::Run& run : runs) is_free |= k - run.start < run.length;
        table[2 * k] = table[2 * k + 1] = is_free ? 0 : 0xFF;
    }
}

TEST(a_run_up_to_the_last_cluster_is_found_and_does_not_go_on_at_the_first) {
    if (!insert_card()) return;
    FATFS volume;
    CHECK(logfile::mount(volume) == kNoTrouble);
    const uint32_t full = volume.n_fatent & ~255u;  // the table's last sector
    uint8_t sector[512];
    logfile::Run found;
    for (uint32_t unused : {0, 100, 255}) {
        volume.n_fatent = full;
        const uint32_t last = full - unused - 90;
        set_free(volume, {{2, 60}, {last, 90 + unused}});
        volume.n_fatent -= unused;  // behind it zeros mean nothing
        for (uint32_t from : {uint32_t{2}, uint32_t{1000}, last, last + 80, volume.n_fatent, ~0u}) {
            volume.last_clst = from;
            CHECK(logfile::find_room(volume, 1000, sector, found) == FR_OK);
            CHECK(found.start == last && found.length == 90);
        }
    }
    volume.fs_type = FS_FAT12;  // whose entries are of 12 bits
    CHECK(logfile::find_room(volume, 10, sector, found) == FR_NO_FILESYSTEM);
    f_mount(nullptr, "", 0);
}

TEST(the_longest_run_of_free_clusters_is_found) {
    if (!insert_card()) return;
    FATFS volume;
    CHECK(logfile::mount(volume) == kNoTrouble);
    set_free(volume, {{500, 50}, {2000, 120}, {5000, 80}});
    uint8_t sector[512];
    logfile::Run found;
    fake::fed_us = fake::now_us;
    fake::longest_unfed_us = 0;
    CHECK(logfile::find_room(volume, 1000, sector, found) == FR_OK);
    CHECK(fake::longest_unfed_us < 20000 && fake::now_us - fake::fed_us < 20000);
    CHECK(found.start == 2000 && found.length == 120);
    volume.last_clst = 4900;  // the search begins behind, and comes round
    CHECK(logfile::find_room(volume, 1000, sector, found) == FR_OK);
    CHECK(found.start == 2000 && found.length == 120);
    CHECK(logfile::find_room(volume, 60, sector, found) == FR_OK);
    CHECK(found.start == 5000 && found.length == 60);
    set_free(volume, {{1000, 1200}});
    volume.last_clst = 1100;  // in the middle of it
    CHECK(logfile::find_room(volume, 2000, sector, found) == FR_OK);
    CHECK(found.start >= 1000 && found.start + found.length == 2200);
    f_mount(nullptr, "", 0);
}

// An entry is the number of the next cluster: any of its bits may be the only one that is set. The
// four highest of 32 mean nothing.
TEST(a_cluster_is_free_only_if_nothing_stands_in_its_entry) {
    if (!insert_card()) return;
    FATFS volume;
    CHECK(logfile::mount(volume) == kNoTrouble);
    volume.n_fatent = 512;
    volume.last_clst = 2;
    uint8_t* table = &fake::card.content[volume.fatbase * 512];
    uint8_t sector[512];
    logfile::Run found;
    for (int size : {2, 4}) {
        volume.fs_type = size == 2 ? FS_FAT16 : FS_FAT32;
        for (int bit = 0; bit < 8 * size; ++bit) {
            for (uint32_t k = 0; k < volume.n_fatent; ++k) {
                for (int at = 0; at < size; ++at) {
                    table[k * size + at] = at == bit / 8 ? 1 << bit % 8 : 0;
                }
            }
            memset(table, 0xFF, 2 * size);
            CHECK(logfile::find_room(volume, 1000, sector, found) == FR_OK);
            CHECK(found.length == (bit < 28 ? 0 : volume.n_fatent - 2));
        }
    }
    f_mount(nullptr, "", 0);
}

TEST(a_session_takes_what_room_there_is_from_a_megabyte_on) {
    const uint32_t per_mb = 2048;  // clusters of one sector
    for (uint32_t free : {per_mb - 1, per_mb, per_mb + 1, 3 * per_mb}) {
        if (!insert_card()) return;
        {
            FATFS volume;
            CHECK(logfile::mount(volume) == kNoTrouble);
            set_free(volume, {{1000, free}});
            f_mount(nullptr, "", 0);
        }
        Rig rig;
        rig.session.settings.size_mb = 4;
        CHECK(rig.session.start() == (free > per_mb ? kNoTrouble : kNoRoom));
        if (free > per_mb) {
            File file;
            CHECK(file.open("HOP00001.HOP") && file.blocks() == free - 1);
        }
        fake::power_on();
    }
}

TEST(a_card_that_fails_while_room_is_looked_for_is_not_called_full) {
    bool failed = true;
    for (int reads = 0; failed; ++reads) {
        if (!insert_card()) return;
        Rig rig;
        fake::card.reads_left = reads;
        const Trouble trouble = rig.session.start();
        failed = fake::card.failed;
        CHECK(!trouble || (failed && trouble == kCardError));
        fake::power_on();
    }
}
