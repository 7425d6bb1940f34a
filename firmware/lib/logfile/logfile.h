#pragma once
#include <ff.h>
#include <stdint.h>

#include "block.h"
#include "line.h"
#include "panel.h"
#include "text.h"

// The card's file system, as far as log files need it. It is touched before and after a session
// only: while the session runs, blocks go straight to the sectors of a file that was allocated in
// one piece.
namespace logfile {

// Where a session's blocks go.
struct Place {
    uint32_t first_sector;
    uint32_t blocks;
};

// Working memory of the functions below. It is the caller's, who has better use for it at other
// times.
struct Work {
    FIL file;
    char name[13];
    Line line;
    DIR folder;
    FILINFO entry;
};

void put_name(uint16_t number, Text& text);  // of the file of session `number`

Trouble mount(FATFS& volume);

// The latest number that a log on the card has; 0: there is none.
uint16_t newest(Work& work);

// Create the file of the first session after `number` that has none, and allocate a place for it:
// one piece of `size_mb`, or of as much as there is, at least 1 MiB and a 448th of the card, at
// most 8192 clusters. It stays open in `work`, and empty in the directory: an empty file is no
// session's yet, and is taken by the next attempt.
Trouble create(FATFS& volume, Work& work, uint16_t& number, uint16_t size_mb, Place& place)
    __attribute__((noinline));  // its caller's registers need not be saved on FatFs's deepest calls

// Give the created file its place and its size, after its first block has been written: no reader
// shall find in it what an older file has left there.
Trouble publish(Work& work, const Place& place);

// Cut the file of session `number` behind its first `blocks` blocks.
Trouble cut(Work& work, uint16_t number, uint32_t blocks);

// Close the file of a session that a reset has ended; true if there was something to close, and a
// block of it is in `block`. `work` and `block` may lie in the same memory; `describe` writes the
// summary's text.
using Describe = void (*)(Block& summary, uint32_t written);
bool recover(Work& work, Block& block, uint16_t number, Describe describe);

// Hand every line of HOP.CFG to `take`, and `context` with it; nothing happens if there is no such
// file.
using TakeLine = void (*)(void* context, uint16_t line_number, Line::State state, char* text);
Trouble read_config(Work& work, TakeLine take, void* context) __attribute__((noinline));

// For a host: name and size of one log file after another, `HOP00012.HOP 4736512`. `text` stays
// empty when there is no other.
Trouble open_folder(Work& work);
Trouble next_log(Work& work, Text& text);

// For a host: a file from block number `block` on, `size` bytes or as many as there are. `got` is 0
// at its end.
Trouble open_file(Work& work, const char* name, uint32_t block);
Trouble read_file(Work& work, void* data, uint8_t size, uint8_t& got);

}  // namespace logfile
