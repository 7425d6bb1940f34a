// Where is room for a file in one piece, and how is it taken? FatFs's f_expand() answers for one
// size only, and reads the whole allocation table to say no. A large card's table takes half a
// minute.
#include <ff.h>
#include <string.h>

#include <diskio.h>

#include "files.h"

namespace {

const LBA_t kNone = 0xFFFFFFFF;

// A cluster's entry in the first table, in FatFs's sector of memory; nullptr if the card cannot be
// read. Nothing may wait there to be written. What else is in the sector need not be `read` where
// all of it will be overwritten.
uint8_t* entry_of(FATFS& volume, uint32_t cluster, bool read = true) {
    const bool is_16 = volume.fs_type == FS_FAT16;
    const LBA_t sector = volume.fatbase + (cluster >> (is_16 ? 8 : 7));
    if (sector != volume.winsect) {
        volume.winsect = kNone;
        if (read && disk_read(0, volume.win, sector, 1) != RES_OK) return nullptr;
        volume.winsect = sector;
    }
    const uint16_t at = static_cast<uint16_t>(cluster) << (is_16 ? 1 : 2);
    return volume.win + at % 512;
}

// The first cluster from `at` on, upwards or downwards, that is not free; `end` if all are.
uint32_t pass_free(FATFS& volume, uint32_t at, uint32_t end, int8_t step, FRESULT& result) {
    const bool is_16 = volume.fs_type == FS_FAT16;
    const uint8_t* entry = nullptr;
    for (; at != end; at += step, entry += is_16 ? 2 * step : 4 * step) {
        const uint8_t edge = step > 0 ? 0 : 127;  // where another sector may begin
        if (!entry || at % 128 == edge) entry = entry_of(volume, at);
        if (!entry) result = FR_DISK_ERR;
        if (!entry || entry[0] || entry[1]) break;
        if (!is_16 && (entry[2] || entry[3] & 0x0F)) break;
    }
    return at;
}

}  // namespace

namespace logfile {

// As Boyer and Moore look for a word: a run of `least` clusters that begins at `at` is looked at
// from its far end, so that a taken cluster there rules out all before it, unread.
FRESULT find_room(FATFS& volume, uint32_t least, uint32_t wanted, Run& longest) {
    longest = {0, 0};
    if (volume.fs_type == FS_FAT12) return FR_NO_FILESYSTEM;
    FRESULT result = FR_OK;
    const uint32_t clusters = volume.n_fatent;
    // Where the last file ended there is probably room.
    const uint32_t first = volume.last_clst - 2 < clusters - 2 ? volume.last_clst : 2;
    bool round = false;                           // it goes on at the beginning
    for (uint32_t at = first, known = first;;) {  // `at` to `known` are free
        uint32_t end = at + least;
        if (end > clusters && !round) {
            round = true;
            at = known = 2;
            continue;
        }
        if (end > clusters || (round && at >= first)) return FR_OK;
        const uint32_t probe = pass_free(volume, end - 1, known - 1, -1, result) + 1;
        if (result != FR_OK) return result;
        if (probe > known) {
            at = probe;
            known = end;
            continue;
        }
        const uint32_t limit = clusters - at < wanted ? clusters : at + wanted;
        if (end < limit) end = pass_free(volume, end, limit, 1, result);
        if (result != FR_OK) return result;
        longest = {at, end - at};
        if (longest.length >= wanted) return FR_OK;
        least = longest.length + 1;
        at = known = end;
    }
}

FRESULT chain(FATFS& volume, uint32_t first, uint32_t count) {
    const uint8_t size = volume.fs_type == FS_FAT16 ? 2 : 4;
    const uint8_t last = size == 2 ? 255 : 127;  // entry of a sector
    if (volume.free_clst <= volume.n_fatent - 2) volume.free_clst -= count;
    volume.last_clst = first + count - 1;
    volume.fsi_flag |= 1;  // FatFs's mark for changed counts
    while (count) {
        const bool whole = !(static_cast<uint8_t>(first) & last) && count > last;
        uint8_t* entry = entry_of(volume, first, !whole);
        if (!entry) return FR_DISK_ERR;
        do {
            const uint32_t next = --count ? ++first : 0x0FFFFFFF;
            memcpy(entry, &next, size);
            entry += size;
        } while (count && entry != volume.win + 512);
        const LBA_t sector = volume.winsect;
        if (disk_write(0, volume.win, sector, 1) != RES_OK) return FR_DISK_ERR;
        // The other table is a copy that nobody reads while this one is whole.
        if (volume.n_fats == 2) disk_write(0, volume.win, sector + volume.fsize, 1);
    }
    return FR_OK;
}

}  // namespace logfile
