#pragma once
#include <stdint.h>

// Collects characters to a line. Blanks before it are dropped, and so are lines that begin with
// `#`.
class Line {
  public:
    static const uint8_t kLongest = 59;
    enum State : uint8_t { Collecting, Complete, Refused };  // Refused: too long, or not plain text

    // Returns Complete or Refused at the end of a line that is not empty; clear() before the next
    // one.
    State push(uint8_t byte);
    void clear() { length_ = 0, comment_ = bad_ = false; }
    char* text() { return text_; }

  private:
    char text_[kLongest + 1] = {};
    uint8_t length_ = 0;
    bool comment_ = false;
    bool bad_ = false;
};
