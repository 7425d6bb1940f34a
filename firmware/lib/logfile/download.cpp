// What is on the card: for a host, and for the next session's number.
#include <string.h>

#include "files.h"
#include "identity.h"
#include "logfile.h"

namespace {

// HOP, five digits, .HOP
bool has_log_name(const FILINFO& entry) {
    if (!begins_with(entry.fname, FLASH("HOP"))) return false;
    for (uint8_t k = 3; k < 8; ++k) {
        if (entry.fname[k] < '0' || entry.fname[k] > '9') return false;
    }
    return same(entry.fname + 8, FLASH(".HOP"));
}

}  // namespace

namespace logfile {

Trouble open_folder(Work& work) { return trouble(f_opendir(&work.folder, "")); }

Trouble next_log(Work& work, Text& text) {
    FILINFO& entry = work.entry;
    do {
        const FRESULT result = f_readdir(&work.folder, &entry);
        if (result != FR_OK || !entry.fname[0]) return trouble(result);
    } while (entry.fattrib & AM_DIR || !has_log_name(entry));
    text.put(entry.fname);
    text.put(' ');
    text.number(entry.fsize);
    return kNoTrouble;
}

uint16_t newest(Work& work) {
    FILINFO& entry = work.entry;
    uint16_t number = 0;
    if (f_opendir(&work.folder, "") != FR_OK) return number;
    while (f_readdir(&work.folder, &entry) == FR_OK && entry.fname[0]) {
        // An empty file is no session's; but one that cannot be written to is in the way.
        const bool taken = entry.fsize || entry.fattrib & (AM_DIR | AM_RDO);
        if (!taken || !has_log_name(entry)) continue;
        entry.fname[8] = 0;
        uint32_t other;
        if (!read_number(entry.fname + 3, 0xFFFF, other)) continue;
        number = identity::later(number, static_cast<uint16_t>(other));
    }
    return number;
}

Trouble open_file(Work& work, const char* name, uint32_t block) {
    const FRESULT result = f_open(&work.file, name, FA_READ);
    if (result >= FR_NO_FILE && result <= FR_INVALID_NAME) return kNoFile;
    return trouble(result == FR_OK ? f_lseek(&work.file, block << 9) : result);
}

Trouble read_file(Work& work, void* data, uint8_t size, uint8_t& got) {
    UINT count;
    const FRESULT result = f_read(&work.file, data, size, &count);
    got = static_cast<uint8_t>(count);
    return trouble(result);
}

}  // namespace logfile
