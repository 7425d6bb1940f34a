#include "logfile.h"

#include <string.h>

#include "files.h"
#include "sdcard.h"

#ifndef BLOCKS_PER_MB  // tests want files that are soon full
#define BLOCKS_PER_MB 2048
#endif

namespace {

// The steps of create(). Not inlined, so that their memory is not on the stack below FatFs's
// deepest calls, which are those of f_open() when the directory has to grow.

__attribute__((noinline)) FRESULT choose_place(FATFS& volume, Block& scratch, uint16_t size_mb,
                                               logfile::Place& place) {
    // One cluster more than wanted: the directory may take one.
    const uint32_t per_mb = BLOCKS_PER_MB / volume.csize;
    logfile::Run run;
    const FRESULT result =
        logfile::find_room(volume, size_mb * per_mb + 1, reinterpret_cast<uint8_t*>(&scratch), run);
    if (result != FR_OK) return result;
    if (run.length < per_mb + 1) return FR_DENIED;
    place.blocks = (run.length - 1) * volume.csize;
    volume.last_clst = run.start - 1;  // behind which FatFs looks for free clusters
    return FR_OK;
}

__attribute__((noinline)) FRESULT allocate(const FATFS& volume, FIL& file, logfile::Place& place) {
    const FRESULT result = f_expand(&file, static_cast<FSIZE_t>(place.blocks) << 9, 1);
    place.first_sector = volume.database + (file.obj.sclust - 2) * volume.csize;
    return result;
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

FRESULT open_session(FIL& file, char name[13], uint16_t number, uint8_t mode) {
    Text text(name, 12);
    put_name(number, text);
    name[12] = 0;
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
    file.flag |= 0x40;  // FatFs's mark for a changed directory entry
    result = f_sync(&file);
    if (result != FR_OK) return result;
    file.obj.objsize = allocated;
    result = f_truncate(&file);
    if (result != FR_OK) return result;
    return f_close(&file);
}

Trouble mount(FATFS& volume) { return trouble(f_mount(&volume, "", 1)); }

Trouble create(FATFS& volume, Work& work, Block& scratch, uint16_t& number, uint16_t size_mb,
               Place& place) {
    FRESULT result = choose_place(volume, scratch, size_mb, place);
    FIL& file = work.file;
    while (result == FR_OK) {
        if (!++number) ++number;
        result = open_session(file, work.name, number, FA_WRITE | FA_OPEN_ALWAYS);
        if (result == FR_OK && !f_size(&file)) return trouble(allocate(volume, file, place));
    }
    return trouble(result);
}

Trouble publish(Work& work) { return trouble(f_sync(&work.file)); }

Trouble cut(Work& work, uint16_t number, uint32_t blocks) {
    FRESULT result = open_session(work.file, work.name, number, FA_WRITE);
    if (result == FR_OK) result = cut_file(work.file, blocks << 9);
    return trouble(result);
}

void read_config(Work& work, TakeLine take, void* context) {
    FIL& file = work.file;
    Line& line = work.line;
    uint16_t line_number = 1;
    bool at_start = true;
    line.clear();
    if (f_open(&file, "HOP.CFG", FA_READ) != FR_OK) return;
    for (bool more = true; more;) {
        char byte;
        UINT count;
        more = f_read(&file, &byte, 1, &count) == FR_OK && count;
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
    f_close(&file);
}

}  // namespace logfile
