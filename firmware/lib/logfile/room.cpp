// Where is room for a file in one piece? FatFs's f_expand() answers for one size only, and reads
// the whole allocation table to say no; here one reading finds the best there is.
#include <ff.h>

#include <diskio.h>

#include "files.h"

namespace {

bool is_free(const uint8_t* entry, bool is_16) {
    if (entry[0] || entry[1]) return false;
    return is_16 || (!entry[2] && !(entry[3] & 0x0F));
}

}  // namespace

namespace logfile {

FRESULT find_room(const FATFS& volume, uint32_t wanted, uint8_t* sector, Run& longest) {
    longest = {0, 0};
    if (volume.fs_type == FS_FAT12) return FR_NO_FILESYSTEM;
    const bool is_16 = volume.fs_type == FS_FAT16;
    const uint8_t entry_size = is_16 ? 2 : 4;
    const uint16_t per_sector = 512 / entry_size;
    const uint32_t sectors = (volume.n_fatent + per_sector - 1) / per_sector;
    // Where the last file ended there is probably room.
    uint32_t position = volume.last_clst < volume.n_fatent ? volume.last_clst / per_sector : 0;
    uint32_t cluster = position * per_sector;
    Run run = {cluster, 0};
    for (uint32_t left = sectors; left; --left) {
        if (disk_read(0, sector, volume.fatbase + position, 1) != RES_OK) return FR_DISK_ERR;
        for (const uint8_t* entry = sector; entry < sector + 512; entry += entry_size, ++cluster) {
            // The first two entries are never free, so that no run goes on there from the end of
            // the table. Behind the last one there are no clusters.
            if (is_free(entry, is_16) && cluster < volume.n_fatent) {
                if (++run.length < wanted) continue;
                longest = run;
                return FR_OK;
            }
            if (run.length > longest.length) longest = run;
            run = {cluster + 1, 0};
        }
        if (++position == sectors) position = cluster = 0;
    }
    if (run.length > longest.length) longest = run;
    return FR_OK;
}

}  // namespace logfile
