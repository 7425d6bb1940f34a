#pragma once
#include <ff.h>
#include <stdint.h>

#include "panel.h"

// Shared by the parts of this folder.
namespace logfile {

Trouble trouble(FRESULT result);

FRESULT open_session(FIL& file, char name[13], uint16_t number, uint8_t mode);
// Find the longest run of free clusters, or the first one of `wanted`. `sector` is 512 bytes of
// working memory.
struct Run {
    uint32_t start;
    uint32_t length;
};
FRESULT find_room(const FATFS& volume, uint32_t wanted, uint8_t* sector, Run& longest)
    __attribute__((noinline));

FRESULT cut_file(FIL& file, uint32_t size);

}  // namespace logfile
