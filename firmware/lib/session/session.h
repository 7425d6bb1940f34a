#pragma once
#include <stdint.h>

#include "flash.h"
#include "logfile.h"
#include "panel.h"
#include "ring.h"
#include "settings.h"
#include "traits.h"

struct Scan {
    uint32_t number;
    uint16_t late;
    uint8_t size;
    uint8_t packed[board::kScanBytes];
};

enum class End : uint8_t { Command, Button, Full, Gone };

namespace memory {

// RAM holds two sectors. Both are the ring's during a session; before and after it one is FatFs's,
// the other holds the header, the summary, or what FatFs needs besides.
union First {
    First() {}
    Block block;
    logfile::Work work;
};
union Second {
    Block block;
    FATFS volume;
};
extern First first;
extern Second second;

// A board with more RAM has blocks that are the ring's alone.
extern Block more[];

}  // namespace memory

// One recording: from scans to blocks on the card, and what there is to tell about it.
class Session {
  public:
    // How a session went so far, with due(), lost() and deepest(); kept after its end.
    struct Tally {
        uint32_t blocks;   // safe on the card, header included
        uint32_t written;  // scans in them
        uint32_t unsent;   // scans that were not streamed
        uint16_t late;
        uint16_t stall_ms;
        uint16_t card_errors;
        uint16_t lowest_mv;  // lowest reading; 0: none yet
    };

    // `config_problem` is told every line of HOP.CFG that was not understood.
    using ConfigProblem = void (*)(uint16_t line_number, const FlashChar* problem);
    explicit constexpr Session(ConfigProblem config_problem)
        : config_problem_(config_problem),
          ring_(memory::first.block, memory::second.block, memory::more),
          running_(false),
          asked_(false),
          stopped_(false),
          known_card_(false),
          in_flight_(false),
          sealed_(false),
          gone_(false),
          waking_(false),
          tries_(0) {}

    void begin();

    // Whether to meet the card, and to begin if that is due: once after a start, again when a
    // card comes that was not there, and after any other trouble with it while there is a session
    // to begin, until somebody has ended one. Never waits.
    bool wants_to_begin();

    // Mount the card. A card not met before: close what a reset left open, read HOP.CFG; again
    // at the next meeting if the card was gone at the end of it.
    Trouble meet();

    // Without a session: memory for reading the card's files, until the next meet() or start().
    logfile::Work& work();

    // Sampling too. `resumes`: goes on with the session of before.
    Trouble start(bool resumes = false);
    Trouble stop(End end);  // after sampling was stopped and its last scan taken
    bool running() const { return running_; }
    // A reset, or the end of its file, has ended a session that shall go on.
    bool interrupted() const;
    // The file takes no more: it is full, or no longer on the card.
    bool over() const { return running_ && (gone_ || tally.blocks + kReserve > place_.blocks); }

    // Fetch a finished scan from the sampler; while a session runs it is kept for the card.
    bool take(Scan& scan);

    // Bring the card one step further. Returns true when a block has become safe. Never waits.
    bool poll();

    Trouble trouble() const { return trouble_; }
    uint32_t id() const { return id_; }
    uint16_t file_number() const { return static_cast<uint16_t>(id_ >> 16); }
    End end() const { return end_; }
    uint32_t due() const { return ring_.due(); }
    uint32_t lost() const { return ring_.lost(); }
    uint16_t deepest() const { return ring_.deepest(); }
    uint16_t room() const { return ring_.room(); }
    void read_clock();  // into unix_s

    static const int16_t kUnknownPpm = INT16_MIN;
    int16_t clock_ppm() const { return clock_ppm_; }
    void set_clock_ppm(int16_t ppm);

    Settings settings;
    Tally tally = {};
    uint32_t epoch_s = 0;  // when the logger was switched on, since 1970; 0: no host has told
    // When the session began or ended, so that card and line say the same; 0: no host has told.
    uint32_t unix_s = 0;
    uint32_t continues = 0;  // id of the session that this one goes on with
    uint16_t config_errors = 0;
    uint16_t supply_mv = 0;  // the last reading; 0: no sensible one

  private:
    // Blocks of a file that are left for what may still come: the ring's, one of the supply, one of
    // inputs beside the eight, and the summary.
    static const uint8_t kReserve = Ring::kBlocks + 3 + board::kHasBeside;

    Trouble begin_file(uint16_t number) __attribute__((noinline));
    void find_newest() __attribute__((noinline));  // these save memory on the stack
    uint16_t last_number() const __attribute__((noinline));
    void recover(uint16_t number);
    bool write_header() __attribute__((noinline));
    bool write_now();
    bool flush();
    Trouble close_file();
    bool settle_block();
    bool wake_card(uint16_t pause_ms, bool leave_present = false);
    void store_clock();
    void read_supply(uint32_t scan);
    void tell_supply();
    void tell_beside();
    static void take_config_line(void* session, uint16_t number, Line::State state, char* text);

    ConfigProblem config_problem_;
    Ring ring_;
    logfile::Place place_ = {};
    uint32_t id_ = 0;  // of the running or the last session; or the number of the card's last log
    int16_t clock_ppm_ = kUnknownPpm;
    uint32_t untold_scan_ = 0;
    uint16_t told_mv_ = 0;    // what the file says of the supply,
    uint16_t untold_mv_ = 0;  // and what it has still to say; 0: nothing
    uint16_t woken_ms_ = 0;
    uint16_t card_id_ = 0;
    uint8_t scans_in_flight_ = 0;
    uint8_t refusals_ = 0;
    Trouble trouble_ = kNoTrouble;
    End end_ = End::Command;
    bool running_ : 1;
    bool asked_ : 1;    // whether to begin
    bool stopped_ : 1;  // the last session, by the user
    bool known_card_ : 1;
    bool in_flight_ : 1;  // the card is busy with a block of ours
    bool sealed_ : 1;     // the waiting block has its CRC
    bool gone_ : 1;       // the card has come back without our file
    bool waking_ : 1;     // the card was started because of trouble
    uint8_t tries_ : 2;   // of a card that is there: each waits twice as long as the one before
};
