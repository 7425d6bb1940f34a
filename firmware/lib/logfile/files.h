#pragma once
#include <ff.h>
#include <stdint.h>

#include "panel.h"

// Shared by the parts of this folder.
namespace logfile {

Trouble trouble(FRESULT result);

FRESULT open_session(FIL& file, char name[13], uint16_t number, uint8_t mode);

// Find the longest run of free clusters that has `least`, or the first one of `wanted`; length 0:
// there is none.
struct Run {
    uint32_t start;
    uint32_t length;
};
FRESULT find_room(FATFS& volume, uint32_t least, uint32_t wanted, Run& longest)
    __attribute__((noinline));

// Chain so many free clusters that follow one another, in the allocation tables.
FRESULT chain(FATFS& volume, uint32_t first, uint32_t count) __attribute__((noinline));

FRESULT cut_file(FIL& file, uint32_t size);

}  // namespace logfile
