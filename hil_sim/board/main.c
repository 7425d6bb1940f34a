// board MCU ELF: the simulated board, driven over standard input and output.
//
// A request is one line of words, where a word `+N` announces N bytes that
// follow the line. Every request is answered by one line: "ok" and values, or
// "error" and a sentence; `+N` as the last value announces N bytes. Numbers are
// decimal; times are CPU cycles of board time; integers in the bytes are
// little-endian. hil_sim/wheelhop/hil_sim/process.py is the other end.
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "board.h"

enum { MAX_LINE = 4600, MAX_WORDS = 8, MAX_EEPROM = 4096 };

static Board board;
static FILE* control;  // standard output; what simavr prints goes to standard error

typedef struct {
    char* words[MAX_WORDS];
    size_t count;
    uint8_t* payload;
    size_t payload_length;
} Request;

static uint64_t number(const Request* request, size_t index) {
    return index < request->count ? strtoull(request->words[index], NULL, 10) : 0;
}

static bool is(const Request* request, size_t index, const char* word) {
    return index < request->count && strcmp(request->words[index], word) == 0;
}

static void reply_bytes(const void* bytes, size_t length) {
    fprintf(control, "ok +%zu\n", length);
    if (length) fwrite(bytes, 1, length, control);
}

static void ok(void) { fputs("ok\n", control); }

static void run(const Request* request) {
    const char* state = board_run(&board, number(request, 1));
    fprintf(control, "ok %" PRIu64 " %s\n", board_now(&board), state);
}

static void power(const Request* request) {
    if (is(request, 1, "on"))
        board_power_on(&board);
    else
        board_power_off(&board);
    ok();
}

static void reset(const Request* request) {
    board_reset(&board, is(request, 1, "brown-out") ? RESET_BROWN_OUT : RESET_EXTERNAL);
    ok();
}

static void set_boot_loader(const Request* request) {
    board_set_boot_loader(&board, request->payload, (uint32_t)request->payload_length);
    ok();
}

static void hold(const Request* request) {
    board_hold(&board, number(request, 1));
    ok();
}

static void press(const Request* request) {
    board_press(&board, number(request, 1));
    ok();
}

static void press_mark(const Request* request) {
    board_press_mark(&board, number(request, 1));
    ok();
}

static void turn_wheel(const Request* request) {
    board_turn_wheel(&board, (uint32_t)number(request, 1));
    ok();
}

static void set_self_test(const Request* request) {
    if (request->payload_length == sizeof board.adc.self_test)
        memcpy(board.adc.self_test, request->payload, sizeof board.adc.self_test);
    ok();
}

static void set_temperature(const Request* request) {
    board.adc.temperature = strtod(request->words[1], NULL);
    ok();
}

static void send_serial(const Request* request) {
    uart_send(&board, request->payload, request->payload_length);
    ok();
}

static void take_serial(const Request* request) {
    (void)request;
    reply_bytes(board.uart.sent, board.uart.sent_count * sizeof *board.uart.sent);
    board.uart.sent_count = 0;
}

// signals RATE_HZ REPEAT, and the table
static void set_signals(const Request* request) {
    Signals* signals = &board.signals;
    free(signals->codes);
    signals->codes = malloc(request->payload_length);
    memcpy(signals->codes, request->payload, request->payload_length);
    signals->rows = request->payload_length / (CHANNELS * sizeof(double));
    signals->rate_hz = strtod(request->words[1], NULL);
    signals->repeat = number(request, 2);
    ok();
}

static void set_reference(const Request* request) {
    board.adc.reference_mV = (uint32_t)number(request, 1);
    ok();
}

// card none | card KIND SERIAL, and the path of the image
static void insert_card(const Request* request) {
    static const struct {
        const char* name;
        CardKind kind;
    } kinds[] = {{"sdhc", CARD_SDHC}, {"sdsc", CARD_SDSC}, {"sd-v1", CARD_SD_V1}};
    CardKind kind = CARD_NONE;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (is(request, 1, kinds[i].name)) kind = kinds[i].kind;
    board.card.serial = (uint32_t)number(request, 2);
    if (sdcard_insert(&board.card, kind, (const char*)request->payload))
        ok();
    else
        fprintf(control, "error %s: %s\n", (const char*)request->payload, strerror(errno));
}

static void set_card_times(const Request* request) {
    CardConfig* config = &board.card.config;
    config->write_busy = number(request, 1);
    config->read_latency = number(request, 2);
    config->start_up = number(request, 3);
    config->pull_at = number(request, 4);
    config->write_protected = number(request, 5);
    config->sheet_latency = number(request, 6);
    config->ignores_crc = number(request, 7);
    config->late_busy = (unsigned)number(request, 8);
    config->fault_count = config->reply_fault_count = config->gap_count = board.hold_count = 0;
    memset(board.card.commands, 0, sizeof board.card.commands);
    ok();
}

static bool has_room(size_t count) {
    if (count < MAX_FAULTS) return true;
    fprintf(control, "error more than %d faults\n", MAX_FAULTS);
    return false;
}

// bad-reply COMMAND NTH REPLY
static void add_bad_reply(const Request* request) {
    CardConfig* config = &board.card.config;
    if (!has_room(config->reply_fault_count)) return;
    config->replies[config->reply_fault_count++] = (BadReply){
        .command = (uint8_t)(number(request, 1) & 63),
        .nth = number(request, 2),
        .reply = (uint8_t)number(request, 3),
    };
    ok();
}

// loose FROM TO
static void add_gap(const Request* request) {
    CardConfig* config = &board.card.config;
    if (!has_room(config->gap_count)) return;
    config->gaps[config->gap_count++] =
        (Interval){.from = number(request, 1), .to = number(request, 2)};
    ok();
}

// hold-program FROM TO
static void add_hold(const Request* request) {
    if (!has_room(board.hold_count)) return;
    board.holds[board.hold_count++] =
        (Interval){.from = number(request, 1), .to = number(request, 2)};
    ok();
}

// fault KIND WRITE VALUE [TAIL]
static void add_fault(const Request* request) {
    static const char* const kinds[] = {"stall", "reject", "flip", "cut"};
    static const char* const tails[] = {"old", "ones", "noise"};
    Fault fault = {.write = number(request, 2), .value = number(request, 3)};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (is(request, 1, kinds[i])) fault.kind = (FaultKind)i;
    for (size_t i = 0; i < sizeof tails / sizeof *tails; i++)
        if (is(request, 4, tails[i])) fault.tail = (Tail)i;
    CardConfig* config = &board.card.config;
    if (!has_room(config->fault_count)) return;
    config->faults[config->fault_count++] = fault;
    ok();
}

static void record(const Request* request) {
    board.trace.on = number(request, 1);
    board.card.journal_on = number(request, 2);
    ok();
}

static void take_trace(const Request* request) {
    (void)request;
    reply_bytes(board.trace.events, board.trace.count * sizeof *board.trace.events);
    board.trace.count = 0;
}

static void take_journal(const Request* request) {
    (void)request;
    reply_bytes(board.card.journal, board.card.journal_count * sizeof *board.card.journal);
    board.card.journal_count = 0;
}

static void untouched(const Request* request) {
    fprintf(control, "ok %" PRIu32 "\n", board_untouched(&board, (uint16_t)number(request, 1)));
}

static void take_eeprom(const Request* request) {
    (void)request;
    uint8_t bytes[MAX_EEPROM];
    board_read_eeprom(&board, bytes);
    reply_bytes(bytes, board_eeprom_size(&board));
}

static void set_eeprom(const Request* request) {
    if (request->payload_length == board_eeprom_size(&board)) {
        board_write_eeprom(&board, request->payload);
        ok();
    } else {
        fprintf(control, "error the EEPROM has %" PRIu32 " bytes\n", board_eeprom_size(&board));
    }
}

// memory ADDRESS COUNT
static void take_memory(const Request* request) {
    uint64_t first = number(request, 1), count = number(request, 2);
    if (first + count <= board.avr->ramend + 1u)
        reply_bytes(board.avr->data + first, count);
    else
        fputs("error no such memory\n", control);
}

// set-memory ADDRESS, and the bytes
static void set_memory(const Request* request) {
    uint64_t first = number(request, 1);
    if (first > board.avr->ioend && first + request->payload_length <= board.avr->ramend + 1u) {
        memcpy(board.avr->data + first, request->payload, request->payload_length);
        ok();
    } else {
        fputs("error no such memory\n", control);
    }
}

static void counters(const Request* request) {
    (void)request;
    fprintf(control,
            "ok idle_cycles=%" PRIu64 " resets=%" PRIu32 " conversions=%" PRIu64 " missed=%" PRIu64
            " reference_conflicts=%" PRIu32 " spi_bytes=%" PRIu64 " spi_collisions=%" PRIu32
            " serial_overruns=%" PRIu32 " card_writes=%" PRIu64 " card_reads=%" PRIu64
            " card_violations=%" PRIu32 "\n",
            board.idle_cycles, board.resets, board.adc.conversions, board.adc.missed,
            board.adc.reference_conflicts, board.spi.bytes, board.spi.collisions,
            board.uart.overruns, board.card.writes, board.card.reads, board.card.violations);
}

static void last_violation(const Request* request) {
    (void)request;
    const char* text = board.card.last_violation ? board.card.last_violation : "";
    reply_bytes(text, strlen(text));
}

static const struct {
    const char* word;
    void (*act)(const Request*);
} REQUESTS[] = {
    {"run", run},
    {"power", power},
    {"reset", reset},
    {"boot-loader", set_boot_loader},
    {"hold", hold},
    {"press", press},
    {"press-mark", press_mark},
    {"wheel", turn_wheel},
    {"self-test", set_self_test},
    {"temperature", set_temperature},
    {"send", send_serial},
    {"take-serial", take_serial},
    {"signals", set_signals},
    {"reference", set_reference},
    {"card", insert_card},
    {"card-times", set_card_times},
    {"fault", add_fault},
    {"bad-reply", add_bad_reply},
    {"loose", add_gap},
    {"hold-program", add_hold},
    {"record", record},
    {"take-trace", take_trace},
    {"take-journal", take_journal},
    {"untouched", untouched},
    {"take-eeprom", take_eeprom},
    {"set-eeprom", set_eeprom},
    {"memory", take_memory},
    {"set-memory", set_memory},
    {"counters", counters},
    {"last-violation", last_violation},
};

static bool read_request(char* line, Request* request) {
    if (!fgets(line, MAX_LINE, stdin)) return false;
    line[strcspn(line, "\n")] = '\0';
    *request = (Request){0};
    for (char* word = strtok(line, " "); word && request->count < MAX_WORDS;
         word = strtok(NULL, " "))
        request->words[request->count++] = word;
    char* last = request->count ? request->words[request->count - 1] : "";
    if (*last != '+') return true;
    request->payload_length = strtoull(last + 1, NULL, 10);
    request->payload = malloc(request->payload_length + 1);
    request->payload[request->payload_length] = '\0';
    return fread(request->payload, 1, request->payload_length, stdin) == request->payload_length;
}

static void answer(const Request* request) {
    for (size_t i = 0; i < sizeof REQUESTS / sizeof *REQUESTS; i++)
        if (is(request, 0, REQUESTS[i].word)) {
            REQUESTS[i].act(request);
            return;
        }
    fputs("error unknown request\n", control);
}

int main(int argc, char** argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: board MCU ELF\n");
        return 2;
    }
    control = fdopen(dup(STDOUT_FILENO), "w");
    dup2(STDERR_FILENO, STDOUT_FILENO);
    if (!board_open(&board, argv[1], argv[2])) return 1;

    char line[MAX_LINE];
    Request request;
    ok();
    fflush(control);
    while (read_request(line, &request)) {
        answer(&request);
        fflush(control);
        free(request.payload);
    }
    return 0;
}
