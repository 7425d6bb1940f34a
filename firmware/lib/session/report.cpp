#include "report.h"

#include "beside.h"
#include "board.h"
#include "identity.h"
#include "version.h"

namespace {

void put_clock(Text& text, int16_t ppm) {
    text.put(FLASH("clock_ppm="));
    if (ppm != Session::kUnknownPpm) text.signed_number(ppm);
}

void put(Text& text, const FlashChar* key, uint32_t value) {
    text.put(key);
    text.number(value);
}

__attribute__((noinline)) void put_supply_mv(Text& text, uint16_t mv) {
    put(text, FLASH("supply_mv="), mv);
}

__attribute__((noinline)) void put_unix_s(Text& text, const Session& session) {
    put(text, FLASH("unix_s="), session.unix_s);
}

const FlashChar* end_text(End end) {
    switch (end) {
        case End::Button:
            return FLASH("button");
        case End::Full:
            return FLASH("full");
        case End::Gone:
            return FLASH("gone");
        default:
            return FLASH("command");
    }
}

// What the headers of some boards say besides: before their last line, by which a listener knows
// that it has all of them.
const uint8_t kBesideLines = board::kHasBeside ? 2 : 0;
const uint8_t kBoardLines = kBesideLines + (board::kFormat == '1' ? 0 : 4);
const uint8_t kLastLine = 12;

void board_line(uint8_t index, Text& text) {
    if (board::kHasBeside && index < 2) {
        if (index) {
            put(text, FLASH("pulses_per_km="), board::beside.pulses_per_km);
        } else {
            text.put(FLASH("beside=mark pulses temperature"));
        }
        return;
    }
    switch (index - kBesideLines) {
        case 0:
            text.put(FLASH("order=together"));
            break;
        case 1:
            put(text, FLASH("sum_bits="), board::kSumBits);
            break;
        case 2:
            put(text, FLASH("code_bits="), board::kCodeBits);
            break;
        default:
            put(text, FLASH("conversions_hz="), board::kConversionsHz);
    }
}

using Line = bool (*)(const Session& session, uint8_t index, Text& text);

void put_lines(const Session& session, Line line, Block& block) {
    Text text(block.payload, Block::kPayload);
    for (uint8_t index = 0; line(session, index, text); ++index) text.put('\n');
}

}  // namespace

namespace report {

bool header_line(const Session& session, uint8_t index, Text& text) {
    const Settings& settings = session.settings;
    char calibration[identity::kCalibrationSize];
    if (kBoardLines && index >= kLastLine) {
        if (index < kLastLine + kBoardLines) {
            board_line(index - kLastLine, text);
            return true;
        }
        index -= kBoardLines;
    }
    switch (index) {
        case 0:
            text.put(FLASH("firmware=" FIRMWARE_VERSION));
            break;
        case 1:
            put(text, FLASH("device="), identity::device());
            break;
        case 2:
            identity::calibration(calibration);
            text.put(FLASH("calibration="));
            text.put(calibration);
            break;
        case 3:
            text.put(FLASH("name="));
            text.put(settings.name);
            break;
        case 4:
            put(text, FLASH("rate_hz="), board::kConversionsHz / settings.conversions);
            break;
        case 5:
            put(text, FLASH("conversions="), settings.conversions);
            break;
        case 6:
            text.put(FLASH("channels="));
            settings.put_channels(text);
            break;
        case 7:
            put_clock(text, session.clock_ppm());
            break;
        case 8:
            put_unix_s(text, session);
            break;
        case 9:
            put_supply_mv(text, session.supply_mv);
            break;
        case 10:
            text.put(FLASH("reset="));
            text.put(board::reset_cause());
            break;
        case 11:
            put(text, FLASH("config_errors="), session.config_errors);
            break;
        case kLastLine:
            text.put(FLASH("continues="));
            if (session.continues) text.hex(session.continues, 8);
            break;
        default:
            return false;
    }
    return true;
}

bool summary_line(const Session& session, uint8_t index, Text& text) {
    const Session::Tally& tally = session.tally;
    switch (index) {
        case 0:
            text.put(FLASH("end="));
            if (!session.running()) text.put(end_text(session.end()));
            break;
        case 1:
            put(text, FLASH("due="), session.due());
            break;
        case 2:
            put(text, FLASH("written="), tally.written);
            break;
        case 3:
            put(text, FLASH("lost="), session.lost());
            break;
        case 4:
            put(text, FLASH("late="), tally.late);
            break;
        case 5:
            put(text, FLASH("stall_ms="), tally.stall_ms);
            break;
        case 6:
            put(text, FLASH("deepest="), session.deepest());
            break;
        case 7:
            put(text, FLASH("room="), session.room());
            break;
        case 8:
            put(text, FLASH("card_errors="), tally.card_errors);
            break;
        case 9:
            put(text, FLASH("unsent="), tally.unsent);
            break;
        case 10:
            put_supply_mv(text, session.supply_mv);
            break;
        case 11:
            put_clock(text, session.clock_ppm());
            break;
        case 12:
            put_unix_s(text, session);
            break;
        case 13:
            put(text, FLASH("lowest_mv="), tally.lowest_mv);
            break;
        default:
            return false;
    }
    return true;
}

void put_header(const Session& session, Block& block) { put_lines(session, header_line, block); }

void put_summary(const Session& session, Block& block) { put_lines(session, summary_line, block); }

void put_supply(Block& block, uint16_t mv, uint32_t scan) {
    Text text(block.payload, Block::kPayload);
    put_supply_mv(text, mv);
    put(text, FLASH("\nscan="), scan);
    text.put('\n');
}

void put_recovered(Block& block, uint32_t written) {
    Text text(block.payload, Block::kPayload);
    put(text, FLASH("end=recovered\ndue="), block.first_scan);
    put(text, FLASH("\nwritten="), written);
    put(text, FLASH("\nlost="), block.lost);
    put(text, FLASH("\nlate="), block.late);
    text.put(FLASH("\nreset="));
    text.put(board::reset_cause());
    text.put('\n');
}

const FlashChar* trouble_text(Trouble trouble) {
    switch (trouble) {
        case kNoFile:
            return FLASH("no such file");
        case kNoCard:
            return FLASH("no card, or it does not answer");
        case kNoFileSystem:
            return FLASH("no FAT file system: format FAT32 with MBR");
        case kNoRoom:
            return FLASH("no room in one piece: delete files or format");
        case kWriteProtected:
            return FLASH("card is write-protected");
        case kCardError:
            return FLASH("card error");
        case kConfigError:
            return FLASH("HOP.CFG has a line that is not understood");
        default:
            return FLASH("ok");
    }
}

}  // namespace report
