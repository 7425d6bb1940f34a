#include "console.h"

#include <string.h>

#include "board.h"
#include "identity.h"
#include "link.h"
#include "report.h"
#include "text.h"

namespace {

const uint32_t kLastBlock = 0xFFFFFFFF / 512;  // that a file on a FAT can have
const uint8_t kPiece = Link::kPayload - 4;     // of a file, in a frame

// A decimal number that may be negative.
bool read_signed(const char* text, int16_t most, int16_t& value) {
    const bool negative = *text == '-';
    uint32_t size;
    if (!read_number(text + negative, static_cast<uint32_t>(most), size)) return false;
    value = static_cast<int16_t>(negative ? -static_cast<int16_t>(size) : size);
    return true;
}

// Cut a text at its first blank; returns what follows.
char* cut(char* text) {
    char* blank = strchr(text, ' ');
    if (!blank) return text + strlen(text);
    *blank = 0;
    return blank + 1;
}

const FlashChar* text_of(Trouble trouble) {
    return trouble ? report::trouble_text(trouble) : nullptr;
}

const FlashChar* not_now() { return FLASH("not during a session"); }

bool status_line(const Session& session, uint8_t index, Text& text) {
    if (index > 1) return report::summary_line(session, index - 2, text);
    text.put(index ? FLASH("card=") : FLASH("state="));
    if (index) {
        text.put(report::trouble_text(session.trouble()));
    } else {
        text.put(session.running() ? FLASH("recording") : FLASH("ready"));
    }
    return true;
}

}  // namespace

void Console::poll() {
    const FlashChar* problem;
    char* line = board::serial.command(problem);
    if (!line) return;
    const bool reset = !problem && same(line, FLASH("reset"));
    const bool with_size = begins_with(line, FLASH("get "));
    if (!problem && !reset) problem = carry_out(line);
    answer(problem, with_size);
    while (reset) {  // until the watchdog bites
    }
    board::serial.next_command();
}

void Console::answer(const FlashChar* problem, bool with_size) {
    Text text = compose();
    if (problem) {
        text.put(problem);
    } else if (with_size) {
        text.number(f_size(&session_.work().file));
    } else if (session_.running()) {
        logfile::put_name(session_.file_number(), text);
    }
    board::serial.send(problem ? 'E' : 'K', static_cast<uint8_t>(text.length()));
}

Trouble Console::start(bool resumes) {
    const Trouble trouble = session_.start(resumes);
    if (trouble) {
        sample_for_stream();
        return trouble;
    }
    say_session();
    say_lines('H', report::header_line);
    return kNoTrouble;
}

Trouble Console::stop(End end) {
    board::sample(0);
    meanwhile_();  // fetches the last scan
    const Trouble trouble = session_.stop(end);
    say_lines('S', report::summary_line);
    sample_for_stream();
    return trouble;
}

void Console::say(char type, const FlashChar* line) {
    Text text = compose();
    text.put(line);
    board::serial.send(type, static_cast<uint8_t>(text.length()));
}

void Console::say_mark(uint8_t number) {
    Text text = compose();
    text.put(FLASH("mark "));
    text.number(number);
    board::serial.send('M', static_cast<uint8_t>(text.length()));
}

void Console::say_config_problem(uint16_t line_number, const FlashChar* problem) {
    Text text = compose();
    text.put(FLASH("HOP.CFG line "));
    text.number(line_number);
    text.put(FLASH(": "));
    text.put(problem);
    board::serial.send('M', static_cast<uint8_t>(text.length()));
}

// Wait for the frame before to leave, and for the stream's if it has one; the text written is the
// payload of the next one.
Text Console::compose() {
    bool sending;
    do {
        sending = board::serial.sending();
        meanwhile_();
    } while (sending || board::serial.sending());
    return Text(board::serial.payload(), Link::kPayload);
}

void Console::say_lines(char type, LineWriter line) {
    for (uint8_t index = 0;; ++index) {
        Text text = compose();
        if (!line(session_, index, text)) return;
        board::serial.send(type, static_cast<uint8_t>(text.length()));
    }
}

void Console::say_session() {
    Text text = compose();
    text.put(FLASH("session="));
    text.hex(session_.id(), 8);
    board::serial.send('H', static_cast<uint8_t>(text.length()));
}

const FlashChar* Console::carry_out(char* line) {
    Trouble trouble = kNoTrouble;
    session_.read_clock();  // info and status tell the time of now
    const bool starts = same(line, FLASH("start"));
    if (starts || same(line, FLASH("stop"))) {
        if (starts == session_.running()) return nullptr;
        say('L', FLASH("wait"));  // the card may take long
        trouble = starts ? start() : stop(End::Command);
    } else if (same(line, FLASH("status"))) {
        say_lines('L', status_line);
    } else if (same(line, FLASH("info"))) {
        say_lines('L', report::header_line);
    } else if (same(line, FLASH("stream on")) || same(line, FLASH("stream off"))) {
        session_.settings.stream = line[8] == 'n';
        if (!session_.running()) sample_for_stream();
    } else if (begins_with(line, FLASH("test o"))) {  // on, off
        if (session_.running()) return not_now();
        board::self_test(line[6] == 'n');
    } else if (begins_with(line, FLASH("set "))) {
        return set(line + 4);
    } else if (begins_with(line, FLASH("time "))) {
        return set_time(line + 5);
    } else if (same(line, FLASH("list")) || begins_with(line, FLASH("get "))) {
        if (session_.running()) return not_now();
        trouble = meet();
        if (trouble) return text_of(trouble);
        if (line[0] == 'g') return get(line + 4);
        trouble = list();
    } else {
        return FLASH("unknown command");
    }
    return text_of(trouble);
}

Trouble Console::meet() {
    const Trouble trouble = session_.meet();
    sample_for_stream();  // HOP.CFG may have been read
    return trouble;
}

Trouble Console::list() {
    Trouble trouble = logfile::open_folder(session_.work());
    while (!trouble) {
        Text text = compose();
        trouble = logfile::next_log(session_.work(), text);
        if (!text.length()) break;
        board::serial.send('L', static_cast<uint8_t>(text.length()));
    }
    return trouble;
}

const FlashChar* Console::get(char* name) {
    char* first = cut(name);
    char* many = cut(first);
    uint32_t block;
    uint32_t count;
    if (!read_number(first, kLastBlock, block) || !read_number(many, 0xFFFF, count) || !count) {
        return wrong_value();
    }
    logfile::Work& work = session_.work();
    Trouble trouble = logfile::open_file(work, name, block);
    for (uint32_t left = count << 9; left && !trouble;) {
        compose();
        const uint32_t at = f_tell(&work.file);
        const uint16_t to_end = 512 - at % 512;
        uint8_t got;
        trouble = logfile::read_file(work, board::serial.payload() + sizeof at,
                                     to_end < kPiece ? to_end : kPiece, got);
        if (!got) break;
        memcpy(board::serial.payload(), &at, sizeof at);
        board::serial.send('F', sizeof at + got);
        left -= got;
    }
    return text_of(trouble);
}

const FlashChar* Console::set(char* line) {
    char* key;
    char* value;
    const FlashChar* problem = split(line, key, value);
    if (problem) return problem;
    if (same(key, FLASH("clock_ppm"))) {
        int16_t ppm;
        if (!read_signed(value, identity::kLargestPpm, ppm)) return wrong_value();
        session_.set_clock_ppm(ppm);
        return nullptr;
    }
    if (session_.running()) return not_now();
    if (same(key, FLASH("device"))) {
        uint32_t number;
        if (!read_number(value, 65534, number)) return wrong_value();
        identity::set_device(static_cast<uint16_t>(number));
    } else if (same(key, FLASH("calibration"))) {
        if (strlen(value) >= identity::kCalibrationSize) return wrong_value();
        identity::set_calibration(value);
    } else {
        problem = session_.settings.apply(key, value);
        sample_for_stream();
    }
    return problem;
}

const FlashChar* Console::set_time(const char* text) {
    uint32_t now_s;
    if (!read_number(text, 0xFFFFFFFF, now_s)) return wrong_value();
    session_.epoch_s = now_s - board::milliseconds() / 1000;
    return nullptr;
}

void Console::sample_for_stream() {
    board::sample(session_.settings.stream ? session_.settings.conversions : 0);
}
