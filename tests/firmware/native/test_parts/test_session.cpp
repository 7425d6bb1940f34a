// Whole sessions on a FAT image.
#include <vector>

#include "files.h"
#include "identity.h"
#include "sdcard.h"
#include "session_rig.h"

TEST(a_session_is_in_its_file) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(1000);
    CHECK(rig.stop() == kNoTrouble);
    const Found found = decode("HOP00001.HOP");
    CHECK(found.kinds == "HS" && found.scans == 1000 && found.due == 1000 && found.lost == 0);
    CHECK(rig.session.tally.written == 1000 && rig.session.lost() == 0);
}

TEST(the_time_of_its_end_is_the_summarys) {
    if (!insert_card()) return;
    Rig rig;
    rig.session.epoch_s = 1800000000;
    CHECK(rig.session.start() == kNoTrouble);
    const uint32_t begun = rig.session.unix_s;
    rig.run(500);
    CHECK(rig.stop() == kNoTrouble);
    CHECK(begun >= 1800000000 && rig.session.unix_s - begun >= 5 && rig.session.unix_s - begun < 9);
}

TEST(a_stall_of_600_ms_loses_nothing) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(100);
    fake::card.busy_us = 600000;
    rig.run(37);  // one block meets it, at whatever phase
    while (card.state() != SdCard::Busy) rig.run(1);
    fake::card.busy_us = 300;
    rig.run(200);
    CHECK(rig.stop() == kNoTrouble && rig.session.lost() == 0);
    CHECK(rig.session.tally.stall_ms >= 599 && rig.session.deepest() <= rig.session.room());
}

TEST(the_count_of_card_errors_stays_at_its_end) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.session.tally.card_errors = 65534;
    fake::card.refuse = 3;
    rig.run(100);
    CHECK(fake::card.refuse == 0 && rig.session.tally.card_errors == 65535);
    CHECK(rig.stop() == kNoTrouble && rig.session.lost() == 0);
}

TEST(written_and_lost_make_due_whatever_the_card_does) {
    uint32_t seed = 3;
    for (int round = 0; round < 12; ++round) {
        fake::power_on();
        if (!insert_card()) return;
        Rig rig;
        CHECK(rig.session.start() == kNoTrouble);
        for (int step = 0; step < 25; ++step) {
            seed = seed * 1664525 + 1013904223;
            const uint32_t dice = seed >> 24;
            fake::card.busy_us = dice % 5 ? 300 : 7000 * (seed >> 16 & 255);
            if (dice % 7 == 1) fake::card.refuse = 1 + dice % 4;
            if (dice % 7 == 2) fake::card.fail_later = 1;
            if (dice % 11 == 3) fake::card.lose_power();
            rig.run(1 + static_cast<int>(dice) % 90);
        }
        fake::card.busy_us = 300;
        fake::card.refuse = fake::card.fail_later = 0;
        rig.run(200);
        CHECK(rig.stop() == kNoTrouble);
        const Session& session = rig.session;
        CHECK(session.due() == fake::sampler.due());
        CHECK(session.tally.written + session.lost() == session.due());
        const Found found = decode("HOP00001.HOP");
        CHECK(found.kinds == "HS" && found.scans == session.tally.written);
        CHECK(found.due == session.due() && found.lost == session.lost());
    }
}

TEST(another_card_is_not_written_to) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(100);
    fake::card.inserted = false;
    rig.run(100);
    fake::card.inserted = true;
    fake::card.lose_power();
    fake::card.serial_number = 2;
    const int writes = fake::card.writes;
    rig.run(300);
    CHECK(fake::card.writes == writes && rig.session.trouble() == kNoCard);
    fake::card.lose_power();
    fake::card.serial_number = 1;
    rig.run(300);
    CHECK(rig.session.trouble() == kNoTrouble && rig.stop() == kNoTrouble);
    const Found found = decode("HOP00001.HOP");
    CHECK(found.kinds == "HS" && found.scans + found.lost == 800 && found.lost > 0);
}

TEST(a_session_that_a_reset_ended_is_closed_when_the_card_is_met_again) {
    for (int scans : {0, 36, 37, 38, 500, 3000}) {
        fake::power_on();
        if (!insert_card()) return;
        Found before;
        {
            Rig rig;
            CHECK(rig.session.start() == kNoTrouble);
            rig.run(scans);
        }
        before = decode("HOP00001.HOP");
        CHECK(before.kinds == "H" && scans - static_cast<int>(before.scans) <= 37);
        Rig rig;
        CHECK(rig.session.meet() == kNoTrouble);
        const Found found = decode("HOP00001.HOP");
        CHECK(found.kinds == "HS" && found.scans == before.scans && found.due == before.scans);
        File file;
        CHECK(file.open("HOP00001.HOP") && file.blocks() == before.scans / 37 + 2);
    }
}

TEST(a_file_whose_header_is_not_its_own_is_left_as_it_is) {
    for (const bool same_name : {false, true}) {
        fake::power_on();
        if (!insert_card()) return;
        {
            Rig rig;
            CHECK(rig.session.start() == kNoTrouble);
            rig.run(500);
        }
        {
            File card;
            CHECK(card.open("HOP00001.HOP") && f_close(&card.file) == FR_OK);
            if (!same_name) CHECK(f_rename("HOP00001.HOP", "HOP00002.HOP") == FR_OK);
            if (!same_name) identity::set_session_number(2);
            if (same_name) {  // no header at its start
                char wrong = 'D';
                UINT count;
                CHECK(f_open(&card.file, "HOP00001.HOP", FA_WRITE) == FR_OK);
                CHECK(f_lseek(&card.file, 4) == FR_OK);
                CHECK(f_write(&card.file, &wrong, 1, &count) == FR_OK);
                CHECK(f_close(&card.file) == FR_OK);
            }
        }
        Rig rig;
        CHECK(rig.session.meet() == kNoTrouble);
        File file;
        CHECK(file.open(same_name ? "HOP00001.HOP" : "HOP00002.HOP") && file.blocks() == 2048);
    }
}

// Long runs of damage: what SPEC.md's reader finds before the file is closed it finds afterwards.
TEST(recovery_cuts_nothing_that_a_reader_reaches) {
    if (!insert_card()) return;
    const int blocks = 1200;
    {
        Rig rig;
        CHECK(rig.session.start() == kNoTrouble);
        rig.run(37 * blocks + 1);
    }
    const std::vector<uint8_t> intact = fake::card.content;
    uint32_t seed = 5;
    for (int round = 0; round < 40; ++round) {
        fake::card.content = intact;
        std::vector<bool> bad(blocks + 1);
        if (round < 8) {  // where halving looks: the file has 2048 blocks
            for (int k = 0; k < 63; ++k) {
                for (int middle : {1024, 512, 1136, 1184}) {
                    if (middle - 8 * round + k <= blocks) bad[middle - 8 * round + k] = true;
                }
            }
        } else {
            for (int runs = 12; runs; --runs) {
                seed = seed * 1664525 + 1013904223;
                for (uint32_t k = 0; k < (seed >> 8) % 64; ++k) {
                    bad[1 + ((seed >> 14) + k) % blocks] = true;
                }
            }
        }
        for (size_t at = 0; at + 512 <= fake::card.content.size(); at += 512) {
            uint8_t* block = &fake::card.content[at];
            const int position = block[12] | block[13] << 8;
            if (!memcmp(block, "HOP1D", 5) && position <= blocks && bad[position]) block[99] ^= 1;
        }
        uint32_t reached = 0;
        for (uint32_t k = 1, row = 0; k <= static_cast<uint32_t>(blocks) && row < 64; ++k) {
            row = bad[k] ? row + 1 : 0;
            if (!row) reached = k;
        }
        Rig rig;
        CHECK(rig.session.meet() == kNoTrouble);
        File file;
        Block block;
        CHECK(file.open("HOP00001.HOP") && file.blocks() >= reached + 2);
        CHECK(file.read(file.blocks() - 1, block) && block.kind == 'S');
        CHECK(block.first_scan >= 37 * reached);
    }
}

TEST(recovery_goes_on_over_damaged_blocks) {
    if (!insert_card()) return;
    {
        Rig rig;
        CHECK(rig.session.start() == kNoTrouble);
        rig.run(37 * 300 + 1);
    }
    for (size_t at = 0; at + 512 <= fake::card.content.size(); at += 512) {
        uint8_t* block = &fake::card.content[at];
        if (memcmp(block, "HOP1D", 5) == 0 && block[12] % 4 != 3) block[100] ^= 1;  // three in four
    }
    Rig rig;
    CHECK(rig.session.meet() == kNoTrouble);
    File file;
    Block block;
    CHECK(file.open("HOP00001.HOP") && file.blocks() == 301);
    CHECK(file.read(300, block) && block.kind == 'S' && block.first_scan == 37 * 299);
}

TEST(an_old_session_in_the_same_sectors_is_not_taken_for_data) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(37 * 40);
    CHECK(rig.stop() == kNoTrouble);
    {
        File file;
        CHECK(file.open("HOP00001.HOP") && f_unlink("HOP00001.HOP") == FR_OK);
    }
    {
        Rig next;
        CHECK(next.session.start() == kNoTrouble);
        next.run(37 * 5 + 1);
    }
    const Found found = decode("HOP00002.HOP");
    CHECK(found.kinds == "H" && found.scans == 37 * 5);
}

TEST(a_full_file_ends_the_session_in_time) {
    if (!insert_card()) return;
    Rig rig;
    rig.session.settings.conversions = 2;
    CHECK(rig.session.start() == kNoTrouble);
    for (int k = 0; k < 3000 && !rig.session.over(); ++k) rig.run(37);
    CHECK(rig.session.over() && rig.stop() == kNoTrouble);
    CHECK(decode("HOP00001.HOP").kinds == "HS" && rig.session.lost() == 0);
}

TEST(trouble_has_its_name) {
    Rig rig;
    fake::card.inserted = false;
    CHECK(rig.session.start() == kNoCard);
    fake::card.inserted = true;
    CHECK(rig.session.start() == kNoFileSystem);
    if (!insert_card()) return;
    fake::card.write_protected = true;
    fake::card.lose_power();
    CHECK(rig.session.start() == kWriteProtected);
    fake::card.write_protected = false;
    fake::card.lose_power();
    CHECK(rig.session.start() == kNoTrouble && rig.session.running());
}

TEST(a_block_is_written_three_times_before_it_is_given_up) {
    const BYTE block[512] = {1, 2, 3};
    CHECK(disk_initialize(0) == 0);
    fake::card.refuse = 2;
    CHECK(disk_write(0, block, 5, 1) == RES_OK && fake::card.writes == 3);
    CHECK(fake::card.content[5 * 512 + 2] == 3);
    fake::card.refuse = 1000;
    CHECK(disk_write(0, block, 6, 1) == RES_ERROR && fake::card.writes == 6);
}

TEST(neighbouring_blocks_are_written_and_read_in_their_order) {
    BYTE blocks[4 * 512];
    for (int k = 0; k < 4 * 512; ++k) blocks[k] = static_cast<BYTE>(k / 3);
    CHECK(disk_initialize(0) == 0 && disk_write(0, blocks, 5, 4) == RES_OK);
    CHECK(!memcmp(&fake::card.content[5 * 512], blocks, sizeof blocks));
    BYTE found[4 * 512];
    CHECK(disk_read(0, found, 5, 4) == RES_OK && !memcmp(found, blocks, sizeof blocks));
}

TEST(a_file_that_is_not_there_is_told_from_a_card_that_is_not) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    rig.run(50);
    CHECK(rig.stop() == kNoTrouble);
    FATFS volume;
    logfile::Work work;
    CHECK(logfile::mount(volume) == kNoTrouble);
    fake::card.inserted = false;  // the directory has not been read yet
    const Trouble trouble = logfile::open_file(work, "HOP00001.HOP", 0);
    CHECK(trouble == kNoCard);
    fake::card.inserted = true;
    CHECK(logfile::mount(volume) == kNoTrouble);
    for (const char* name : {"HOP00099.HOP", "HOP/1.HOP", "HOP*.HOP", ""}) {
        CHECK(logfile::open_file(work, name, 0) == kNoFile && kNoFile != kNoTrouble);
    }
    for (uint32_t block : {3u, 0u}) {
        CHECK(logfile::open_file(work, "HOP00001.HOP", block) == kNoTrouble);
        uint8_t got, data[16];
        CHECK(logfile::read_file(work, data, sizeof data, got) == kNoTrouble && got == 16);
        CHECK(!memcmp(data, block ? "HOP1S" : "HOP1H", 5) && data[12] == block);
    }
    f_mount(nullptr, "", 0);
}

static void write_config(const std::string& text) {
    FATFS volume;
    FIL file;
    UINT count;
    CHECK(f_mount(&volume, "", 1) == FR_OK);
    CHECK(f_open(&file, "HOP.CFG", FA_WRITE | FA_CREATE_ALWAYS) == FR_OK);
    CHECK(f_write(&file, text.data(), static_cast<UINT>(text.size()), &count) == FR_OK);
    CHECK(f_close(&file) == FR_OK && count == text.size());
    f_mount(nullptr, "", 0);
}

TEST(hop_cfg_is_read_as_editors_leave_it) {
    const std::string mark = "\xEF\xBB\xBF";  // of UTF-8
    for (const std::string& text :
         {mark + "rate = 400\r\nname = kerb\r\nresume = off",
          std::string("rate=400\nname=kerb\nresume=off\n"),
          std::string("# seat\n\n  rate = 400\n\tname = kerb\nresume = off\n")}) {
        if (!insert_card()) return;
        write_config(text);
        Rig rig;
        CHECK(rig.session.meet() == kNoTrouble && config_problems().count == 0);
        CHECK(rig.session.config_errors == 0 && rig.session.settings.conversions == 2);
        CHECK(std::string(rig.session.settings.name) == "kerb" && !rig.session.settings.resume);
        fake::power_on();
    }
}

TEST(a_line_that_is_not_understood_is_counted_and_told_by_its_number) {
    if (!insert_card()) return;
    write_config("rate = 400\n\nnonsense\nname = k\xEF\n" + std::string(70, 'x') +
                 "\nresume = off\n");
    Rig rig;
    CHECK(rig.session.meet() == kNoTrouble && config_problems().count == 3);
    CHECK(config_problems().last == 5);
    CHECK(rig.session.config_errors == 3 && !rig.session.settings.resume);
}

TEST(log_files_are_those_with_five_digits_in_their_name) {
    if (!insert_card()) return;
    FATFS volume;
    FIL file;
    CHECK(f_mount(&volume, "", 1) == FR_OK);
    for (const char* name :
         {"HOP0000A.HOP", "HOPA0000.HOP", "HOP00019.HOP", "HOP00-01.HOP", "HOP0001.HOP",
          "HIP00001.HOP", "HOP90000.HOP", "HOP00001.TXT", "HOP.CFG"}) {
        CHECK(f_open(&file, name, FA_WRITE | FA_CREATE_NEW) == FR_OK && f_close(&file) == FR_OK);
    }
    CHECK(f_mkdir("HOP00003.HOP") == FR_OK);
    logfile::Work work;
    CHECK(logfile::open_folder(work) == kNoTrouble);
    std::string found;
    for (bool more = true; more;) {
        char line[40] = {};
        Text text(line, sizeof line - 1);
        CHECK(logfile::next_log(work, text) == kNoTrouble);
        more = text.length();
        found += std::string(line) + "\n";
    }
    CHECK(found == "HOP00019.HOP 0\nHOP90000.HOP 0\n\n");
    f_mount(nullptr, "", 0);
}
