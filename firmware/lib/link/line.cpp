#include "line.h"

Line::State Line::push(uint8_t byte) {
    if (byte == '\n' || byte == '\r') {
        const bool empty = !length_ && !bad_;
        const bool bad = bad_;
        if (empty || comment_) {
            clear();
            return Collecting;
        }
        text_[length_] = 0;
        return bad ? Refused : Complete;
    }
    if (byte == '\t') byte = ' ';
    if (comment_ || (!length_ && byte == ' ')) return Collecting;
    if (!length_ && byte == '#') {
        comment_ = true;
    } else if (byte < 0x20 || byte > 0x7E || length_ == kLongest) {
        bad_ = true;
    } else {
        text_[length_++] = static_cast<char>(byte);
    }
    return Collecting;
}
