// A session that a reset has ended: where does it end, and how is it closed?
#include <ff.h>

#include <diskio.h>

#include "files.h"
#include "logfile.h"

namespace {

// A damaged block must not be taken for the end. SPEC.md has readers look that far, and what they
// find must not be cut off.
const uint8_t kPatience = 64;

bool read_block(FIL& file, uint32_t position, Block& block) {
    UINT count;
    return f_lseek(&file, position << 9) == FR_OK &&
           f_read(&file, &block, sizeof block, &count) == FR_OK && count == sizeof block;
}

bool is_good(FIL& file, uint32_t session, uint32_t position, Block& block) {
    return read_block(file, position, block) && block.good(session, position);
}

// The last good block, found by halving. Behind `end` there are always kPatience blocks that are
// not good, or the end of the file: no reader gets past them.
inline __attribute__((always_inline)) uint32_t last_good(FIL& file, uint32_t session,
                                                         uint32_t blocks, Block& block) {
    uint32_t good = 0;
    uint32_t end = blocks;
    while (end - good > 1) {
        const uint32_t middle = good + (end - good) / 2;
        const uint32_t limit = middle + kPatience < end ? middle + kPatience : end;
        // Upwards: FatFs finds the way to an earlier cluster from the file's beginning only.
        uint32_t probe = middle;
        while (probe < limit && !is_good(file, session, probe, block)) ++probe;
        if (probe < limit) {
            good = probe;
        } else {
            end = middle;
        }
    }
    return good;
}

// Write a summary behind the last good block, which is in `block` and at `end` − 1.
__attribute__((noinline)) bool summarise(FIL& file, Block& block, uint32_t end,
                                         logfile::Describe describe) {
    const uint32_t session = block.session;
    const uint32_t due = block.first_scan + block.count;
    const uint32_t lost = block.lost;
    const uint16_t late = block.late;
    block.clear('S');
    block.first_scan = due;
    block.lost = lost;
    block.late = late;
    describe(block, due - lost);
    block.seal(session, end);
    // A byte further: then FatFs tells the block's sector.
    return f_lseek(&file, (end << 9) + 1) == FR_OK &&
           disk_write(0, reinterpret_cast<const BYTE*>(&block), file.sect, 1) == RES_OK;
}

// Blocks of the file once it is closed; 0 if there is nothing to close.
__attribute__((noinline)) uint32_t closed_size(FIL& file, Block& block, uint16_t number,
                                               logfile::Describe describe) {
    const uint32_t blocks = static_cast<uint32_t>(f_size(&file) >> 9);
    if (!blocks || !read_block(file, 0, block)) return 0;
    const uint32_t session = block.session;
    if (!block.good(session, 0) || block.kind != 'H' || session >> 16 != number) return 0;
    if (is_good(file, session, blocks - 1, block) && block.kind == 'S') return 0;

    const uint32_t end = last_good(file, session, blocks, block) + 1;
    if (!is_good(file, session, end - 1, block)) return 0;
    if (block.kind == 'S' || end == blocks) return end;
    return summarise(file, block, end, describe) ? end + 1 : 0;
}

// Not inlined, so that its memory is not yet on the stack while FatFs opens the file.
__attribute__((noinline)) bool close(const FIL& opened, Block& block, uint16_t number,
                                     logfile::Describe describe) {
    FIL file = opened;  // `block` may lie in its memory
    const uint32_t blocks = closed_size(file, block, number, describe);
    if (blocks) logfile::cut_file(file, blocks << 9);
    return blocks;
}

}  // namespace

namespace logfile {

bool recover(Work& work, Block& block, uint16_t number, Describe describe) {
    return open_session(work.file, work.name, number, FA_READ | FA_WRITE) == FR_OK &&
           close(work.file, block, number, describe);
}

}  // namespace logfile
