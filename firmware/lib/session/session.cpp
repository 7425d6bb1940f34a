#include "session.h"

#include <string.h>

#include "beside.h"
#include "board.h"
#include "identity.h"
#include "report.h"
#include "sampler.h"
#include "sdcard.h"
#include "together.h"

namespace {

const uint16_t kWakeEveryMs = 500;
const uint16_t kFlushLimitMs = 5000;
const uint8_t kTries = 3;
const uint8_t kMostTries = 3;       // that lengthen the pause before the next: 0.5, 1, 2, 4 s
const uint16_t kSupplyStepMv = 50;  // a larger change goes into the file
const uint8_t kSoon = 8;            // scans

// Of the converter's reference, from the code of the internal one; 0 if that makes no sense.
uint16_t supply_from(uint16_t code) {
    const uint32_t mv = code ? board::kReferenceMv * board::kLargestCode / code : 0;
    return mv < 10000 ? static_cast<uint16_t>(mv) : 0;
}

Trouble card_trouble() {
    if (card.state() != SdCard::Ready) return kNoCard;
    return card.write_protected() ? kWriteProtected : kCardError;
}

}  // namespace

namespace memory {

First first;
Second second;
Block more[Ring::kBlocks - 2];

}  // namespace memory

using memory::first;
using memory::second;

void Session::begin() {
    if (!identity::clock_ppm(clock_ppm_)) clock_ppm_ = kUnknownPpm;
    supply_mv = supply_from(board::reference_code());
}

bool Session::wants_to_begin() {
    if (!asked_) return asked_ = true;
    if (running_ || stopped_ || !trouble_) return false;
    if (trouble_ != kNoCard && !interrupted() && !settings.start_at_power) return false;
    card.poll();
    if (card.state() == SdCard::Down) trouble_ = kNoCard;
    // A card that is full, or not to be written to, stays so until it is taken out.
    const bool lasts = trouble_ > kNoCard && trouble_ < kCardError;
    if (waking_ && card.state() == SdCard::Ready) {
        waking_ = false;
        if (tries_ < kMostTries) ++tries_;
        return true;
    }
    waking_ |= wake_card(trouble_ == kNoCard ? kWakeEveryMs : kWakeEveryMs << tries_, lasts);
    return false;
}

Trouble Session::meet() {
    trouble_ = logfile::mount(second.volume);
    if (!trouble_ && (!known_card_ || card.id() != card_id_)) {
        card_id_ = card.id();
        // The last session's file, and the card's last one, if that was made before the card was
        // changed for another.
        recover(identity::session_number());
        find_newest();
        recover(file_number());
        config_errors = 0;
        trouble_ = logfile::read_config(first.work, take_config_line, this);
        if (!card.present()) trouble_ = kNoCard;  // then nothing of this is sure
    }
    known_card_ = !trouble_;
    return trouble_;
}

uint16_t Session::last_number() const {
    return identity::later(identity::session_number(), file_number());
}

void Session::find_newest() { id_ = static_cast<uint32_t>(logfile::newest(first.work)) << 16; }

void Session::recover(uint16_t number) {
    if (!number || !logfile::recover(first.work, first.block, number, report::put_recovered))
        return;
    // A reset may have come before it was noted that this session is the one to go on with.
    const uint16_t unfinished = static_cast<uint16_t>(board::unfinished >> 16);
    if (unfinished && number == unfinished + 1) board::unfinished = first.block.session;
}

logfile::Work& Session::work() { return first.work; }

bool Session::interrupted() const { return settings.resume && board::unfinished; }

Trouble Session::start(bool resumes) {
    if (meet()) return trouble_;
    continues = resumes ? board::unfinished : 0;
    uint16_t number = last_number();
    trouble_ = logfile::create(second.volume, first.work, number, settings.size_mb, place_);
    return trouble_ ? trouble_ : begin_file(number);
}

// The file is there: write its header, and go.
Trouble Session::begin_file(uint16_t number) {
    known_card_ = false;  // if this fails, the next meeting finds what has become of the file
    board::sample(0);
    supply_mv = supply_from(board::reference_code());
    told_mv_ = supply_mv;
    untold_mv_ = 0;
    read_clock();
    memset(&tally, 0, sizeof tally);
    id_ = static_cast<uint32_t>(number) << 16 | board::dice();
    if (!write_header()) return trouble_ = card_trouble();
    trouble_ = logfile::publish(first.work, place_);
    if (trouble_) return trouble_;
    board::unfinished = id_;
    // By its entry in the directory and its header the file is known again.
    if (!card.watch(0, first.work.file.dir_sect) || !card.watch(1, place_.first_sector)) {
        board::unfinished = continues;
        return trouble_ = card_trouble();
    }
    identity::set_session_number(number);

    ring_.begin(scan_size(settings.recorded()));
    card.longest_busy_ms = 0;
    in_flight_ = sealed_ = gone_ = false;
    tries_ = 0;
    running_ = known_card_ = true;
    const uint16_t rate_hz = board::kConversionsHz / settings.conversions;
    if (board::kHasBeside) {
        board::beside.start(static_cast<uint8_t>(rate_hz / Beside::kPerSecond));
    }
    board::sample(settings.conversions);
    return kNoTrouble;
}

Trouble Session::stop(End end) {
    stopped_ = end != End::Full;
    if (stopped_) board::unfinished = continues = 0;
    const bool flushed = flush();
    running_ = false;
    card.forget();
    store_clock();
    end_ = gone_ ? End::Gone : end;
    supply_mv = supply_from(board::reference_code());
    read_clock();
    known_card_ = false;  // when the card is met again, its file is closed
    if (flushed) {
        trouble_ = close_file();
        known_card_ = !trouble_;
    } else if (!gone_) {
        trouble_ = card_trouble();
    } else {
        trouble_ = stopped_ ? kNoFile : kNoTrouble;
    }
    return trouble_;
}

bool Session::take(Scan& scan) {
    board::Sum sums[board::kInputs];
    if (!board::sampler.take(sums, scan.number, scan.late)) return false;
    scan.size = pack_scan(sums, settings.mask(), scan.packed);
    if (running_) {
        ring_.add(scan.number, scan.packed, scan.late);
        tally.late = scan.late;
        if (board::Converter::reads_supply(scan.number)) read_supply(scan.number);
        if (board::kHasBeside) board::beside.keep();
    }
    return true;
}

bool Session::poll() {
    if (!running_ || gone_) return false;
    card.poll();
    if (in_flight_) return settle_block();
    Block* block = ring_.waiting();
    if (!block) {
        if (untold_mv_) {
            tell_supply();
        } else if (board::kHasBeside && board::beside.count() >= Beside::kSoon) {
            tell_beside();
        }
        return false;
    }
    if (card.state() != SdCard::Ready || card.id() != card_id_) {
        trouble_ = kNoCard;
        wake_card(kWakeEveryMs);
    } else if (card.changed()) {  // what is there now is not ours to write into
        gone_ = true;
    } else if (!sealed_) {  // in a step of its own: together with the transfer it would take too
                            // long
        block->seal(id_, tally.blocks);
        sealed_ = true;
    } else {
        const uint8_t scans = block->count;
        const bool taken = card.write(place_.first_sector + tally.blocks, block);
        scans_in_flight_ = taken ? scans : 0;
        in_flight_ = true;
        if (taken) {
            sealed_ = false;
            ring_.release();
        }
    }
    return false;
}

void Session::read_supply(uint32_t scan) {
    const uint16_t mv = supply_from(board::sampler.supply_code());
    if (!mv) return;
    supply_mv = mv;
    if (!tally.lowest_mv || mv < tally.lowest_mv) tally.lowest_mv = mv;
    const bool changed = static_cast<uint16_t>(mv - told_mv_ + kSupplyStepMv) > 2 * kSupplyStepMv;
    if (!changed || (untold_mv_ && mv >= untold_mv_)) return;
    untold_mv_ = mv;
    untold_scan_ = scan;
}

// A block about the supply takes the place of a waiting one. The card can have it at once and the
// other is nearly empty: no memory for a stall is spent on it.
void Session::tell_supply() {
    if (card.state() != SdCard::Ready || ring_.depth() >= kSoon) return;
    report::put_supply(ring_.insert('V'), untold_mv_, untold_scan_);
    told_mv_ = untold_mv_;
    untold_mv_ = 0;
}

void Session::tell_beside() {
    if (card.state() != SdCard::Ready || ring_.depth() >= kSoon) return;
    board::beside.put(ring_.insert('I'));
}

void Session::set_clock_ppm(int16_t ppm) {
    clock_ppm_ = ppm;
    if (!running_) store_clock();  // the EEPROM takes longer than a scan
}

void Session::store_clock() {
    if (clock_ppm_ != kUnknownPpm) identity::set_clock_ppm(clock_ppm_);
}

void Session::read_clock() { unix_s = epoch_s ? epoch_s + board::milliseconds() / 1000 : 0; }

// The card has finished with a block, or is gone. A block that failed after the card had taken it
// cannot be repeated; the next one takes its place in the file.
bool Session::settle_block() {
    if (card.state() == SdCard::Busy) return false;
    in_flight_ = false;
    if (card.longest_busy_ms > tally.stall_ms) tally.stall_ms = card.longest_busy_ms;
    if (card.state() == SdCard::Ready && card.written()) {
        ++tally.blocks;
        tally.written += scans_in_flight_;
        refusals_ = 0;
        trouble_ = kNoTrouble;
        return true;
    }
    if (tally.card_errors != 0xFFFF) ++tally.card_errors;
    if (scans_in_flight_) {
        ring_.lose(scans_in_flight_);
        sealed_ = false;
    }
    trouble_ = card_trouble();
    if (++refusals_ >= kTries && card.state() == SdCard::Ready) card.begin();
    return false;
}

// The card was pulled, or shaken loose, or has hung: try from the start now and then. Another card
// does not count: our file is not there.
bool Session::wake_card(uint16_t pause_ms, bool leave_present) {
    if (card.state() == SdCard::Starting) return false;
    const uint16_t now_ms = static_cast<uint16_t>(board::milliseconds());
    if (static_cast<uint16_t>(now_ms - woken_ms_) < pause_ms) return false;
    woken_ms_ = now_ms;
    if (leave_present && card.present()) return false;
    card.begin();
    return true;
}

// The header takes the memory that FatFs has its open file in.
bool Session::write_header() {
    const FIL file = first.work.file;
    first.block.clear('H');
    report::put_header(*this, first.block);
    const bool written = write_now();
    first.work.file = file;
    return written;
}

// Write the first block behind the others, at once.
bool Session::write_now() {
    first.block.seal(id_, tally.blocks);
    for (uint8_t tries = kTries; tries; --tries) {
        if (!card.settle()) return false;
        card.write(place_.first_sector + tally.blocks, &first.block);
        if (card.settle() && card.written()) {
            ++tally.blocks;
            return true;
        }
    }
    return false;
}

Trouble Session::close_file() {
    first.block.clear('S');
    first.block.first_scan = due();
    first.block.lost = lost();
    first.block.late = tally.late;
    report::put_summary(*this, first.block);
    if (!write_now()) return card_trouble();
    const Trouble mounting = logfile::mount(second.volume);
    if (mounting) return mounting;
    return logfile::cut(first.work, file_number(), tally.blocks);
}

// Bring to the card what still waits; false if that fails.
bool Session::flush() {
    const uint32_t start_ms = board::milliseconds();
    while (!gone_ && board::milliseconds() - start_ms < kFlushLimitMs) {
        board::feed_watchdog();
        ring_.finish(board::sampler.due());
        poll();
        if (ring_.waiting() || ring_.depth() || in_flight_ || untold_mv_) continue;
        if (!board::kHasBeside || !board::beside.count()) return card.state() == SdCard::Ready;
        tell_beside();
    }
    ring_.finish(board::sampler.due());
    if (in_flight_) ring_.lose(scans_in_flight_);
    ring_.abandon();
    return false;
}

void Session::take_config_line(void* context, uint16_t number, Line::State state, char* text) {
    Session& session = *static_cast<Session*>(context);
    char* key;
    char* value;
    const FlashChar* problem =
        state == Line::Refused ? FLASH("too long or not plain text") : split(text, key, value);
    if (!problem) problem = session.settings.apply(key, value);
    if (!problem) return;
    if (session.config_errors != 0xFFFF) ++session.config_errors;
    session.config_problem_(number, problem);
}
