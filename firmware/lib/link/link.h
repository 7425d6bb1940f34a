#pragma once
#include <stdint.h>

#include "flash.h"
#include "line.h"

// The serial line: frames to the host, command lines from it (SPEC.md, "Serial line").
//
// One frame is sent at a time and one command line is held: the interrupts own them while they
// move, the main loop owns them otherwise, and the two volatile flags say whose turn it is.
class Link {
  public:
    static const uint8_t kPayload = 48;

    // Main loop: while nothing is being sent, write a payload and send it.
    bool sending() const { return sending_; }
    uint8_t* payload() { return frame_ + 4; }
    void send(char type, uint8_t payload_size);

    // Main loop: a command line without its checksum, or nullptr; `problem` if there is one that is
    // no good.
    char* command(const FlashChar*& problem);
    void next_command();

    // Interrupts
    bool transmit(uint8_t& byte);  // false: nothing more to send
    void receive(uint8_t byte, bool damaged);

  private:
    uint8_t frame_[kPayload + 7] = {};  // delimiter, code, type, counter, payload, CRC, delimiter
    uint8_t size_ = 0;
    uint8_t sent_ = 0;
    uint8_t counter_ = 0;
    volatile bool sending_ = false;

    Line line_;
    bool dropping_ = false;  // the rest of a line whose beginning came too early
    volatile Line::State received_ = Line::Collecting;
};
