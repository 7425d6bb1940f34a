#include "logfile.h"

#include <string.h>

#include "files.h"
#include "sdcard.h"

#ifndef BLOCKS_PER_MB  // tests want files that are soon full
#define BLOCKS_PER_MB 2048
#endif

namespace {

const BYTE kModified = 0x40;  // FatFs's mark for a changed directory entry

// Of a large card not every small piece is looked for: reading its whole table takes too long. A
// piece of a 448th is met in some 448 readings of 2 to 4 ms.
const uint16_t kPieces = 448;

// Of small clusters a large file's chain takes too long to write: its end is at so many. They are
// 64 sectors of a FAT32's table, 4 MiB of clusters of 512 bytes, and 256 MiB of 32 kB.
const uint32_t kMostClusters = 8192;

// Not inlined, so that its memory is not on the stack below FatFs's deepest calls, which are those
// of f_open() when the directory has to grow.
__attribute__((noinline)) FRESULT choose_place(FATFS& volume, uint16_t size_mb,
                                               logfile::Place& place) {
    // One cluster more than wanted: the directory may take one.
    const uint32_t per_mb = BLOCKS_PER_MB / volume.csize;
    const uint32_t part = volume.n_fatent / kPieces;
    uint32_t wanted = size_mb * per_mb;
    if (wanted > kMostClusters) wanted = kMostClusters;
    logfile::Run run;
    const FRESULT result =
        logfile::find_room(volume, (part > per_mb ? part : per_mb) + 1, wanted + 1, run);
    if (result != FR_OK) return result;
    if (!run.length) return FR_DENIED;
    place.blocks = (run.length > wanted ? wanted : run.length - 1) * volume.csize;
    volume.last_clst = run.start - 1;  // behind which FatFs looks for free clusters
    return FR_OK;
}

}  // namespace

namespace logfile {

Trouble trouble(FRESULT result) {
    switch (result) {
        case FR_OK:
            return kNoTrouble;
        case FR_NOT_READY:
            return kNoCard;
        case FR_NO_FILESYSTEM:
            return kNoFileSystem;
        case FR_WRITE_PROTECTED:
            return kWriteProtected;
        case FR_DENIED:
            return kNoRoom;
        default:
            if (!card.present()) return kNoCard;
            return card.write_protected() ? kWriteProtected : kCardError;
    }
}

// Not inlined, so that its memory is not on the stack below FatFs.
__attribute__((noinline)) static void write_name(char name[13], uint16_t number) {
    Text text(name, 12);
    put_name(number, text);
    name[12] = 0;
}

FRESULT open_session(FIL& file, char name[13], uint16_t number, uint8_t mode) {
    write_name(name, number);
    return f_open(&file, name, mode);
}

void put_name(uint16_t number, Text& text) {
    text.put(FLASH("HOP"));
    text.number(number, 5);
    text.put(FLASH(".HOP"));
}

// The directory learns the new size before clusters are set free: if power fails in between, the
// file is whole and some clusters are lost, instead of a file that claims more than it has.
FRESULT cut_file(FIL& file, uint32_t size) {
    const FSIZE_t allocated = file.obj.objsize;
    FRESULT result = f_lseek(&file, size);
    if (result != FR_OK) return result;
    file.obj.objsize = size;
    file.flag |= kModified;
    result = f_sync(&file);
    if (result != FR_OK) return result;
    file.obj.objsize = allocated;
    result = f_truncate(&file);
    if (result != FR_OK) return result;
    return f_sync(&file);
}

Trouble mount(FATFS& volume) { return trouble(f_mount(&volume, "", 1)); }

Trouble create(FATFS& volume, Work& work, uint16_t& number, uint16_t size_mb, Place& place) {
    FRESULT result = choose_place(volume, size_mb, place);
    FIL& file = work.file;
    while (result == FR_OK) {
        if (!++number) ++number;
        result = open_session(file, work.name, number, FA_WRITE | FA_OPEN_ALWAYS);
        if (result == FR_OK && !f_size(&file)) break;
    }
    if (result == FR_OK) result = f_sync(&file);
    // What the directory has taken lies before it.
    file.obj.sclust = volume.last_clst + 1;
    place.first_sector = volume.database + (file.obj.sclust - 2) * volume.csize;
    if (result == FR_OK) result = chain(volume, file.obj.sclust, place.blocks / volume.csize);
    return trouble(result);
}

Trouble publish(Work& work, const Place& place) {
    FIL& file = work.file;
    file.obj.objsize = static_cast<FSIZE_t>(place.blocks) << 9;
    file.flag |= kModified;
    return trouble(f_sync(&file));
}

Trouble cut(Work& work, uint16_t number, uint32_t blocks) {
    FRESULT result = open_session(work.file, work.name, number, FA_WRITE);
    if (result == FR_OK) result = cut_file(work.file, blocks << 9);
    return trouble(result);
}

Trouble read_config(Work& work, TakeLine take, void* context) {
    FIL& file = work.file;
    Line& line = work.line;
    uint16_t line_number = 1;
    bool at_start = true;
    line.clear();
    FRESULT result = f_open(&file, "HOP.CFG", FA_READ);
    if (result == FR_NO_FILE) return kNoTrouble;
    for (bool more = result == FR_OK; more;) {
        char byte;
        UINT count;
        result = f_read(&file, &byte, 1, &count);
        if (result != FR_OK) break;
        more = count;
        if (!more) byte = '\n';  // the last line may lack its end
        // Some editors mark UTF-8 by three bytes at the start.
        at_start = at_start && more && strchr("\xEF\xBB\xBF", byte);
        if (at_start && byte) continue;
        const Line::State state = line.push(static_cast<uint8_t>(byte));
        if (state != Line::Collecting) {
            take(context, line_number, state, line.text());
            line.clear();
        }
        if (byte == '\n') ++line_number;
    }
    return trouble(result);
}

}  // namespace logfile
