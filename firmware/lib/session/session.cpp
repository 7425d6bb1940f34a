#include "session.h"

#include <string.h>

#include "board.h"
#include "identity.h"
#include "report.h"
#include "sdcard.h"

namespace {

const uint16_t kWakeEveryMs = 500;
const uint16_t kFlushLimitMs = 5000;
const uint8_t kTries = 3;
const uint16_t kBandgapMv = 1100;
const uint16_t kSupplyStepMv = 50;  // a larger change goes into the file
const uint8_t kSoon = 8;            // scans

// Of the converter's reference, from the code of the internal one; 0 if that makes no sense.
uint16_t supply_from(uint16_t code) {
    const uint32_t mv = code ? 1023ul * kBandgapMv / code : 0;
    return mv < 10000 ? static_cast<uint16_t>(mv) : 0;
}

Trouble card_trouble() {
    if (card.state() != SdCard::Ready) return kNoCard;
    return card.write_protected() ? kWriteProtected : kCardError;
}

// RAM holds two sectors. Both are the ring's during a session; before and after it one is FatFs's,
// the other holds the header, the summary, or what FatFs needs besides.
union First {
    First() {}
    Block block;
    logfile::Work work;
} first;
union {
    Block block;
    FATFS volume;
} second;

// A board with more RAM has blocks that are the ring's alone.
#ifdef __AVR_ATmega2560__
Block more[Ring::kBlocks - 2];
#else
Block* const more = nullptr;
#endif

}  // namespace

Session::Session(Sampler& sampler, ConfigProblem config_problem)
    : sampler_(sampler),
      config_problem_(config_problem),
      ring_(first.block, second.block, more),
      running_(false),
      asked_(false),
      stopped_(false),
      known_card_(false),
      in_flight_(false),
      sealed_(false) {}

void Session::begin() {
    if (!identity::clock_ppm(clock_ppm_)) clock_ppm_ = kUnknownPpm;
    supply_mv = supply_from(board::reference_code());
}

bool Session::wants_to_begin() {
    if (!asked_) return asked_ = true;
    if (running_ || stopped_ || trouble_ != kNoCard) return false;
    card.poll();
    if (card.state() == SdCard::Ready) return true;
    wake_card();
    return false;
}

Trouble Session::meet() {
    trouble_ = logfile::mount(second.volume);
    if (!trouble_ && (!known_card_ || card.id() != card_id_)) {
        known_card_ = true;
        card_id_ = card.id();
        logfile::recover(first.work, first.block, identity::session_number(),
                         report::put_recovered);
        config_errors = 0;
        logfile::read_config(first.work, take_config_line, this);
        if (!card.present()) trouble_ = kNoCard;  // then nothing of this is sure
    }
    if (trouble_ == kNoCard) known_card_ = false;
    return trouble_;
}

logfile::Work& Session::work() { return first.work; }

bool Session::interrupted() const { return settings.resume && board::unfinished; }

Trouble Session::start(bool resumes) {
    if (meet()) return trouble_;
    continues = resumes ? board::unfinished : 0;
    uint16_t number = identity::session_number();
    trouble_ =
        logfile::create(second.volume, first.work, first.block, number, settings.size_mb, place_);
    return trouble_ ? trouble_ : begin_file(number);
}

// The file is there: write its header, and go.
Trouble Session::begin_file(uint16_t number) {
    identity::set_session_number(number);
    board::sample(0);
    supply_mv = supply_from(board::reference_code());
    told_mv_ = supply_mv;
    untold_mv_ = 0;
    read_clock();
    memset(&tally, 0, sizeof tally);
    id_ = static_cast<uint32_t>(number) << 16 | board::dice();
    if (!write_header()) return trouble_ = card_trouble();
    trouble_ = logfile::publish(first.work);
    if (trouble_) return trouble_;

    ring_.begin(scan_size(settings.recorded()));
    card.longest_busy_ms = 0;
    in_flight_ = sealed_ = false;
    running_ = true;
    board::unfinished = id_;
    board::sample(settings.conversions);
    return kNoTrouble;
}

Trouble Session::stop(End end) {
    stopped_ = end != End::Full;
    if (stopped_) board::unfinished = continues = 0;
    const bool flushed = flush();
    running_ = false;
    store_clock();
    end_ = end;
    supply_mv = supply_from(board::reference_code());
    read_clock();
    trouble_ = flushed ? close_file() : card_trouble();
    if (trouble_) known_card_ = false;  // when the card is met again, its file is closed
    return trouble_;
}

bool Session::take(Scan& scan) {
    uint16_t sums[Sampler::kInputs];
    if (!sampler_.take(sums, scan.number, scan.late)) return false;
    scan.size = pack_scan(sums, settings.mask(), scan.packed);
    if (running_) {
        ring_.add(scan.number, scan.packed, scan.late);
        tally.late = scan.late;
        if (Sampler::reads_supply(scan.number)) read_supply(scan.number);
    }
    return true;
}

bool Session::poll() {
    if (!running_) return false;
    card.poll();
    if (in_flight_) return settle_block();
    Block* block = ring_.waiting();
    if (!block) {
        if (untold_mv_) tell_supply();
        return false;
    }
    if (card.state() != SdCard::Ready || card.id() != card_id_) {
        wake_card();
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
    const uint16_t mv = supply_from(sampler_.supply_code());
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
void Session::wake_card() {
    if (card.state() == SdCard::Starting) return;
    trouble_ = kNoCard;
    const uint16_t now_ms = static_cast<uint16_t>(board::milliseconds());
    if (static_cast<uint16_t>(now_ms - woken_ms_) < kWakeEveryMs) return;
    woken_ms_ = now_ms;
    card.begin();
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
    return logfile::cut(first.work, static_cast<uint16_t>(id_ >> 16), tally.blocks);
}

// Bring to the card what still waits; false if that fails.
bool Session::flush() {
    const uint32_t start_ms = board::milliseconds();
    do {
        board::feed_watchdog();
        ring_.finish(sampler_.due());
        poll();
        if (!ring_.waiting() && !ring_.depth() && !in_flight_ && !untold_mv_)
            return card.state() == SdCard::Ready;
    } while (board::milliseconds() - start_ms < kFlushLimitMs);
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
