#pragma once
#include "session.h"
#include "text.h"

// The text of header and summary, the same in the file and on the serial line (SPEC.md, "Text of
// header and summary").
namespace report {

// Write line number `index` without its end; false if there is no such line.
bool header_line(const Session& session, uint8_t index, Text& text);
bool summary_line(const Session& session, uint8_t index, Text& text);

void put_header(const Session& session, Block& block);
void put_summary(const Session& session, Block& block);
void put_supply(Block& block, uint16_t mv, uint32_t scan);
void put_recovered(Block& block, uint32_t written);

const FlashChar* trouble_text(Trouble trouble);

}  // namespace report
