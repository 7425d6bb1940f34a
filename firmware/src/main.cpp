// wheelhop's data logger: eight accelerometers, one SD card, one serial line, one button, one
// light.
//
// An interrupt (board/avr.cpp) sums conversions to scans (sampler). The main loop packs each scan
// into a block (ring), brings full blocks to a file on the card without ever waiting for it
// (session, sdcard), sends scans to the host (stream) and does what the host asks for (console).
// What is written and sent: SPEC.md; why so: DESIGN.md.
#include "avr.h"
#include "beside.h"
#include "console.h"
#include "panel.h"
#include "report.h"
#include "scan_stream.h"
#include "session.h"

namespace {

void pump() __attribute__((noinline));  // its memory is not on the stack below FatFs
void tell_config_problem(uint16_t line_number, const FlashChar* problem);

Session session(tell_config_problem);
ScanStream stream;
Console console(session, pump);
Button button;
Trouble shown = kNoTrouble;  // what the light shows

// What must not wait: it also runs while the console waits for the serial line.
void pump() {
    Scan scan;
    if (session.take(scan) && session.settings.stream) {
        const uint32_t id = session.running() ? session.id() : 0;
        if (!stream.offer(id, scan) && session.running()) ++session.tally.unsent;
    }
    if (session.poll()) stream.acknowledge();
    stream.poll(session);
}

void tell_config_problem(uint16_t line_number, const FlashChar* problem) {
    console.say_config_problem(line_number, problem);
}

void say_ready() __attribute__((noinline));  // nor does main() hold what this does
void say_ready() { console.say('M', FLASH("ready")); }

void tell_trouble() {
    const Trouble trouble = session.trouble();
    if (trouble != shown) console.say('M', report::trouble_text(trouble));
    shown = trouble;
}

// Whoever presses the button for marks sees that it was seen.
void tell_mark() {
    static uint8_t told;
    const uint8_t marks = session.running() ? board::beside.marks() : 0;
    if (marks && marks != told) console.say_mark(marks);
    told = marks;
}

void show_light() {
    const bool losing = session.lost() || session.trouble();
    const Light light = !session.running() ? Light::Ready
                        : losing           ? Light::Losing
                                           : Light::Recording;
    const Trouble trouble = session.trouble()       ? session.trouble()
                            : session.config_errors ? kConfigError
                                                    : kNoTrouble;
    board::set_led(led_lit(light, trouble, board::milliseconds()));
}

void loop() {
    board::feed_watchdog();
    if (session.wants_to_begin()) {
        session.meet();
        const bool resumes = session.interrupted();
        if (resumes || session.settings.start_at_power) {
            console.start(resumes);
        } else {
            console.sample_for_stream();
        }
    }
    pump();
    console.poll();
    if (session.over() && !console.stop(End::Full) && session.settings.resume) console.start(true);
    if (button.pressed(board::button_down(), board::milliseconds())) {
        session.running() ? console.stop(End::Button) : console.start();
    }
    tell_trouble();
    if (board::kHasBeside) tell_mark();
    show_light();
    board::sleep();
}

}  // namespace

int main() __attribute__((OS_main));  // nobody wants registers back
int main() {
    board::begin();
    session.begin();
    say_ready();
    for (;;) loop();
}
