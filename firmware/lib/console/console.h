#pragma once
#include "session.h"

// Commands from the host, and what the host is told (SPEC.md, "Serial line").
class Console {
  public:
    // `meanwhile` is called again and again while a frame waits for the one before to leave:
    // sampling and card go on.
    constexpr Console(Session& session, void (*meanwhile)())
        : session_(session), meanwhile_(meanwhile) {}

    void poll();  // carry out a command, if there is one

    // Start or end a session and tell so; these return the trouble that was met.
    Trouble start(bool resumes = false);
    Trouble stop(End end);

    void sample_for_stream();  // without a session, sampling follows the setting

    void say(char type, const FlashChar* text);
    void say_mark(uint8_t number);
    void say_config_problem(uint16_t line_number, const FlashChar* problem);

  private:
    using LineWriter = bool (*)(const Session& session, uint8_t index, Text& text);

    Text compose();
    void say_lines(char type, LineWriter line);
    const FlashChar* carry_out(char* line);
    void answer(const FlashChar* problem, bool with_size);
    Trouble meet();
    // Not inlined: what these hold would lie on the stack below FatFs's deepest calls.
    void say_session() __attribute__((noinline));
    Trouble list() __attribute__((noinline));
    const FlashChar* get(char* arguments) __attribute__((noinline));
    const FlashChar* set(char* line) __attribute__((noinline));
    const FlashChar* set_time(const char* text) __attribute__((noinline));

    Session& session_;
    void (*meanwhile_)();
};
