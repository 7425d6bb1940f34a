#pragma once
// Whole sessions on a FAT image, and what a reader finds in the file.
#include <cstdio>
#include <cstring>
#include <string>

#include <ff.h>

#include <diskio.h>

#include "board.h"
#include "check.h"
#include "fake_board.h"
#include "session.h"

// Lines of HOP.CFG that were not understood, and the number of the last.
struct ConfigProblems {
    int count = 0;
    uint16_t last = 0;
};
inline ConfigProblems& config_problems() {
    static ConfigProblems found;
    return found;
}

struct Rig {
    Session session{[](uint16_t line, const FlashChar*) {
        ++config_problems().count;
        config_problems().last = line;
    }};
    uint32_t code = 0;

    Rig() {
        config_problems() = ConfigProblems();
        session.begin();
        session.settings.size_mb = 1;
    }

#ifndef BOARD_SIMULTANEOUS
    // So many scans of time pass; the main loop does what main.cpp's pump() does.
    void run(int scans) {
        Scan scan;
        uint8_t input = 0;  // of the conversion under way: scans begin and end with 0
        for (; scans; --scans) {
            for (int k = 0; k < 8 * fake::sampling; ++k) {
                const uint8_t next = fake::sampler.advance();
                fake::sampler.collect(input, code++ / 64 & 1023);
                input = next;
                if (input == Sampler::kSupply) {
                    input = fake::sampler.advance();
                    fake::sampler.collect(Sampler::kSupply, fake::reference_code);
                }
            }
            session.take(scan);
            const uint32_t until_us = fake::now_us + 10000;
            while (fake::now_us < until_us) {
                session.poll();
                fake::now_us += 156;
            }
        }
    }
#endif

    Trouble stop() {
        board::sample(0);
        return session.stop(End::Command);
    }
};

// Every test begins with the empty file system. False where there is none.
inline bool insert_card() {
    std::FILE* file = fake::image_path ? std::fopen(fake::image_path, "rb") : nullptr;
    if (!file) return false;
    std::fseek(file, 0, SEEK_END);
    fake::card.content.resize(static_cast<size_t>(std::ftell(file)));
    std::rewind(file);
    const bool whole = std::fread(fake::card.content.data(), fake::card.content.size(), 1, file);
    std::fclose(file);
    return whole;
}

struct File {
    FATFS volume;
    FIL file;
    ~File() { f_mount(nullptr, "", 0); }
    bool open(const char* name) {
        return f_mount(&volume, "", 1) == FR_OK && f_open(&file, name, FA_READ) == FR_OK;
    }
    uint32_t blocks() { return static_cast<uint32_t>(f_size(&file) / 512); }
    bool read(uint32_t position, Block& block) {
        UINT count;
        return f_lseek(&file, position * 512) == FR_OK &&
               f_read(&file, &block, 512, &count) == FR_OK && count == 512;
    }
};

struct Found {
    std::string kinds, supply;
    uint32_t scans = 0, due = 0, lost = 0;
};

// Read a session as SPEC.md says.
inline Found decode(const char* name) {
    File file;
    Found found;
    Block block;
    if (!file.open(name) || !file.read(0, block)) return found;
    const uint32_t session = block.session;
    for (uint32_t k = 0; k < file.blocks(); ++k) {
        if (!file.read(k, block) || !block.good(session, k)) continue;
        if (found.kinds.empty() || block.kind != 'D') found.kinds += block.kind;
        if (block.kind == 'V') found.supply += reinterpret_cast<const char*>(block.payload);
        if (block.kind != 'H') CHECK(block.first_scan == found.scans + block.lost);
        found.scans += block.count;
        found.lost = block.lost;
        found.due = block.first_scan + block.count;
    }
    return found;
}
