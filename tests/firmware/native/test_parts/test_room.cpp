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
    logfile::Run found;
    for (uint32_t unused : {0, 100, 255}) {
        volume.n_fatent = full;
        const uint32_t last = full - unused - 90;
        set_free(volume, {{2, 60}, {last, 90 + unused}});
        volume.n_fatent -= unused;  // behind it zeros mean nothing
        for (uint32_t from : {uint32_t{2}, uint32_t{1000}, last, last + 80, volume.n_fatent, ~0u}) {
            volume.last_clst = from;
            CHECK(logfile::find_room(volume, 33, 1000, found) == FR_OK);
            CHECK(found.start == last && found.length == 90);
        }
    }
    volume.fs_type = FS_FAT12;  // whose entries are of 12 bits
    CHECK(logfile::find_room(volume, 33, 10, found) == FR_NO_FILESYSTEM);
    f_mount(nullptr, "", 0);
}

TEST(the_longest_run_of_free_clusters_is_found) {
    if (!insert_card()) return;
    FATFS volume;
    CHECK(logfile::mount(volume) == kNoTrouble);
    set_free(volume, {{500, 50}, {2000, 120}, {5000, 80}});
    logfile::Run found;
    fake::fed_us = fake::now_us;
    fake::longest_unfed_us = 0;
    CHECK(logfile::find_room(volume, 33, 1000, found) == FR_OK);
    CHECK(fake::longest_unfed_us < 20000 && fake::now_us - fake::fed_us < 20000);
    CHECK(found.start == 2000 && found.length == 120);
    volume.last_clst = 4900;  // the search begins behind, and comes round
    CHECK(logfile::find_room(volume, 33, 1000, found) == FR_OK);
    CHECK(found.start == 2000 && found.length == 120);
    CHECK(logfile::find_room(volume, 33, 60, found) == FR_OK);
    CHECK(found.start == 5000 && found.length == 60);
    set_free(volume, {{1000, 1200}});
    volume.last_clst = 1100;  // in the middle of it
    CHECK(logfile::find_room(volume, 33, 2000, found) == FR_OK);
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
            CHECK(logfile::find_room(volume, 33, 1000, found) == FR_OK);
            CHECK(found.length == (bit < 28 ? 0 : volume.n_fatent - 2));
        }
    }
    f_mount(nullptr, "", 0);
}

TEST(a_run_of_the_least_length_is_found_wherever_it_lies_and_a_shorter_one_is_not) {
    if (!insert_card()) return;
    FATFS volume;
    CHECK(logfile::mount(volume) == kNoTrouble);
    logfile::Run found;
    for (uint32_t start = 2; start < 1500; start += 37) {
        for (uint32_t from : {uint32_t{2}, start + 150, uint32_t{9000}}) {
            for (uint32_t length : {299, 300, 301}) {
                set_free(volume, {{start, length}, {start + 2000, 200}});
                volume.last_clst = from;
                volume.winsect = 0;
                CHECK(logfile::find_room(volume, 300, 1000, found) == FR_OK);
                CHECK(found.length == (length < 300 ? 0 : length));
                CHECK(length < 300 || found.start == start);
            }
        }
    }
    f_mount(nullptr, "", 0);
}

// A large card's table is not read: one cluster in every `least` rules out all of them.
TEST(a_full_card_is_known_by_few_readings) {
    if (!insert_card()) return;
    FATFS volume;
    CHECK(logfile::mount(volume) == kNoTrouble);
    set_free(volume, {});
    logfile::Run found;
    for (uint32_t least : {512, 1024, 2048}) {
        const int before = fake::card.commands[17];
        CHECK(logfile::find_room(volume, least, 4096, found) == FR_OK && !found.length);
        const int readings = fake::card.commands[17] - before;
        CHECK(readings <= static_cast<int>(volume.n_fatent / least));
    }
    f_mount(nullptr, "", 0);
}

// The next cluster's number in each entry, an end in the last one, and nothing else changed.
TEST(clusters_are_chained_in_both_tables) {
    for (const int size : {2, 4}) {
        for (const logfile::Run run : {logfile::Run{200, 700},
                                       {192, 700},
                                       {256, 64},
                                       {256, 127},
                                       {256, 128},
                                       {256, 255},
                                       {256, 256},
                                       {320, 300}}) {
            if (!insert_card()) return;
            FATFS volume;
            CHECK(logfile::mount(volume) == kNoTrouble);
            volume.fs_type = size == 2 ? FS_FAT16 : FS_FAT32;
            volume.free_clst = 5000;
            const uint32_t bytes = volume.fsize * 512;
            uint8_t* tables = &fake::card.content[volume.fatbase * 512];
            for (uint32_t at = 0; at < 2 * bytes; ++at) tables[at] = at % bytes % 251;
            const std::vector<uint8_t> before = fake::card.content;
            CHECK(logfile::chain(volume, run.start, run.length) == FR_OK);
            const uint32_t last = run.start + run.length - 1;
            for (int copy = 0; copy < 2; ++copy) {
                const size_t table = (volume.fatbase + copy * volume.fsize) * 512;
                for (uint32_t k = 100; k < 1100; ++k) {
                    uint32_t entry = 0, was = 0;
                    memcpy(&entry, &fake::card.content[table + k * size], size);
                    memcpy(&was, &before[table + k * size], size);
                    const uint32_t end = size == 2 ? 0xFFFF : 0x0FFFFFFF;
                    const bool ours = k >= run.start && k <= last;
                    CHECK(entry == (!ours ? was : k < last ? k + 1 : end));
                }
            }
            CHECK(volume.free_clst == 5000 - run.length && volume.last_clst == last);
            CHECK(volume.fsi_flag & 1);
            f_mount(nullptr, "", 0);
        }
    }
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
        CHECK(!trouble || (failed && trouble == kCardError && !rig.session.interrupted()));
        fake::power_on();
    }
}
