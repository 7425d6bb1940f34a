#pragma once
#include <stdint.h>
#include <string.h>

#include "block.h"

// Inputs beside the eight: pulses of a wheel, a button for marks, a temperature (SPEC.md, "Inputs
// beside the eight"). The sampling clock looks at them, once with every conversion: no line of
// theirs, however noisy, has an interrupt that could make a conversion late.
class Beside {
  public:
    // What there is to tell at the end of a scan.
    struct Record {
        uint16_t pulses;       // so far, modulo 65536
        uint16_t since;        // conversions since the last one was seen; stays at 65535
        uint16_t temperature;  // code of its input when it was read last; 0: not yet
        uint8_t marks;         // so far, modulo 256
        uint8_t zero;
    };
    static const uint8_t kRecords = 60;  // in a block
    static const uint8_t kSoon = 40;     // of them are worth one
    static const uint8_t kPerSecond = 10;
    static const uint8_t kSettle = 192;  // conversions, 30 ms: contacts bounce

    // Begin with a session; a record after every `every` scans. Interrupt must be off.
    void start(uint8_t every) {
        now_ = {0, 0xFFFF, 0, 0, 0};
        scan_ = settling_ = count_ = marks_ = 0;
        every_ = left_ = every;
        ready_ = false;
    }

    // Interrupt only, at the end of a conversion of the eight; `scan` is the number of scans that
    // were finished before it. A record is what was seen until then.
    void look(bool pulse, bool button, uint32_t scan) {
        if (static_cast<uint8_t>(scan) != scan_) {
            scan_ = static_cast<uint8_t>(scan);
            if (!--left_) tell(scan);
        }
        if (pulse && !pulse_) {
            ++now_.pulses;
            now_.since = 0;
        } else if (now_.since != 0xFFFF) {
            ++now_.since;
        }
        pulse_ = pulse;
        if (button == button_) {
            settling_ = 0;
        } else if (++settling_ == kSettle) {
            settling_ = 0;
            button_ = button;
            if (button) ++now_.marks;
        }
    }

    // Interrupt only.
    void note_temperature(uint16_t code) { now_.temperature = code; }

    // Main loop: keep the record that is ready, if there is one.
    void keep() {
        if (!ready_) return;
        __atomic_signal_fence(__ATOMIC_SEQ_CST);
        // Those of a block follow one another; where they do not, or find no room, the next wait.
        if (!count_) first_scan_ = told_scan_;
        const bool follows = first_scan_ + static_cast<uint32_t>(count_) * every_ == told_scan_;
        if (count_ < kRecords && follows) records_[count_++] = told_;
        marks_ = told_.marks;
        __atomic_signal_fence(__ATOMIC_SEQ_CST);
        ready_ = false;
    }

    uint8_t count() const { return count_; }  // records that wait
    uint8_t marks() const { return marks_; }  // in the last record

    // Main loop: bring the waiting records into a block of kind `I`; none waits then.
    void put(Block& block) {
        uint8_t* at = block.payload;
        memcpy(at, &first_scan_, sizeof first_scan_);
        at[4] = every_;
        at[5] = count_;
        memcpy(at + 6, records_, count_ * sizeof(Record));
        count_ = 0;
    }

    uint32_t pulses_per_km = 0;  // as HOP.CFG says; 0: not known

  private:
    void tell(uint32_t scan) {
        left_ = every_;
        if (ready_) return;  // the main loop is so late that this record is lost: numbers tell
        told_ = now_;
        told_scan_ = scan;
        ready_ = true;
    }

    Record now_ = {};   // the interrupt's
    Record told_ = {};  // the main loop's, once ready_
    Record records_[kRecords] = {};
    uint32_t told_scan_ = 0;
    uint32_t first_scan_ = 0;
    uint8_t scan_ = 0;
    uint8_t settling_ = 0;
    uint8_t every_ = 0;
    uint8_t left_ = 0;
    uint8_t count_ = 0;
    uint8_t marks_ = 0;
    bool pulse_ = false;
    bool button_ = false;
    volatile bool ready_ = false;
};
static_assert(sizeof(Beside::Record) == 8, "as in SPEC.md");
static_assert(6 + Beside::kRecords * sizeof(Beside::Record) == Block::kPayload, "fills a block");
