#pragma once
#include <string.h>

#include "board.h"
#include "link.h"
#include "session.h"

// Sends scans and block acknowledgements as frames, as soon as the serial line is free. What cannot
// be sent before the next one comes is dropped: the file has it.
class ScanStream {
  public:
    // Send this scan; false if the one before was dropped for it.
    bool offer(uint32_t session, const Scan& scan) {
        const bool in_time = !scan_size_;
        memcpy(scan_, &session, 4);
        memcpy(scan_ + 4, &scan.number, 4);
        memcpy(scan_ + 8, scan.packed, scan.size);
        scan_size_ = 8 + scan.size;
        return in_time;
    }

    void acknowledge() { block_is_safe_ = true; }

    void poll(const Session& session) {
        if (board::serial.sending()) return;
        if (scan_size_) {
            memcpy(board::serial.payload(), scan_, scan_size_);
            board::serial.send('D', scan_size_);
            scan_size_ = 0;
        } else if (block_is_safe_) {
            send_acknowledgement(session);
            block_is_safe_ = false;
        }
    }

  private:
    void send_acknowledgement(const Session& session) {
        const Session::Tally& tally = session.tally;
        const uint32_t counts[] = {session.id(), tally.blocks, session.due(), tally.written,
                                   session.lost()};
        const uint16_t shorts[] = {tally.late, tally.stall_ms};
        const uint8_t bytes[] = {
            static_cast<uint8_t>(session.deepest() < 255 ? session.deepest() : 255),
            static_cast<uint8_t>(tally.card_errors < 255 ? tally.card_errors : 255)};
        uint8_t* payload = board::serial.payload();
        memcpy(payload, counts, sizeof counts);
        memcpy(payload + sizeof counts, shorts, sizeof shorts);
        memcpy(payload + sizeof counts + sizeof shorts, bytes, sizeof bytes);
        board::serial.send('B', sizeof counts + sizeof shorts + sizeof bytes);
    }

    uint8_t scan_[8 + board::kScanBytes] = {};
    uint8_t scan_size_ = 0;  // 0: none waits
    bool block_is_safe_ = false;
};
