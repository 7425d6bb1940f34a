// What FatFs asks of a disk: the card, waiting where SdCard itself does not.
#include <ff.h>

#include <diskio.h>

#include "board.h"
#include "sdcard.h"

namespace {

const uint8_t kTries = 3;

}  // namespace

DSTATUS disk_status(BYTE) {
    const DSTATUS ready = card.state() == SdCard::Down ? STA_NOINIT : 0;
    return static_cast<DSTATUS>(ready | (card.write_protected() ? STA_PROTECT : 0));
}

DSTATUS disk_initialize(BYTE drive) {
    if (!card.present()) card.begin();
    card.settle();
    return disk_status(drive);
}

DRESULT disk_read(BYTE, BYTE* data, LBA_t sector, UINT count) {
    for (; count; --count, ++sector, data += 512) {
        uint8_t tries = kTries;
        while (!card.finish() || !card.read(sector, data)) {
            if (!--tries) return RES_ERROR;
        }
        board::feed_watchdog();
    }
    return RES_OK;
}

DRESULT disk_write(BYTE, const BYTE* data, LBA_t sector, UINT count) {
    for (; count; --count, ++sector, data += 512) {
        uint8_t tries = kTries;
        do {
            if (!tries-- || !card.finish()) return RES_ERROR;
            card.write(sector, data);
        } while (!card.finish() || !card.written());
    }
    return RES_OK;
}

// A card writes each sector before it stops being busy: there is nothing to flush.
DRESULT disk_ioctl(BYTE, BYTE command, void*) { return command == CTRL_SYNC ? RES_OK : RES_PARERR; }
