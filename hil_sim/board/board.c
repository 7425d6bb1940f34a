#include "board.h"

#include <stdio.h>
#include <string.h>

#include <simavr/avr_eeprom.h>
#include <simavr/avr_ioport.h>
#include <simavr/sim_elf.h>

static const struct {
    const char* mcu;
    Pin card_select, button, led, self_test, mark, wheel;
} WIRING[] = {
    // Nano: D10, D2, D9, D8
    {"atmega328p", {'B', 2}, {'D', 2}, {'B', 1}, {'B', 0}, {0, 0}, {0, 0}},
    // Mega: D53, D2, D9, D8, D3, D4
    {"atmega2560", {'B', 0}, {'E', 4}, {'H', 6}, {'H', 5}, {'E', 5}, {'G', 5}},
};
enum { REGISTERS = 32, RAM_NOISE_SEED = 0x1f35, INTERRUPT_ENTRY_CYCLES = 4 };

// simavr hands its callbacks no context where it calls `sleep` and `reset`.
static Board* the_board;

static void log_errors(avr_t* avr, const int level, const char* format, va_list arguments) {
    (void)avr;
    if (level <= LOG_ERROR) vfprintf(stderr, format, arguments);
}

static void count_idle(avr_t* avr, avr_cycle_count_t cycles) {
    (void)avr;
    the_board->idle_cycles += cycles + 1;
}

// simavr counts cycles from 0 again after a reset; board time goes on.
static void begin_epoch(avr_t* avr) {
    the_board->epoch += avr->cycle;
    avr->cycle = 0;
    the_board->was_reset = true;
}

static void on_interrupt(avr_irq_t* irq, uint32_t vector, void* context) {
    (void)irq;
    Board* board = context;
    if (vector) {
        trace_add(&board->trace, board_now(board), TRACE_ISR_ENTER, (uint8_t)vector, 0);
        board->avr->cycle += INTERRUPT_ENTRY_CYCLES;  // simavr 1.6 charges none
    } else {
        trace_add(&board->trace, board_now(board), TRACE_ISR_EXIT, 0, 0);
    }
}

static void on_card_select(avr_irq_t* irq, uint32_t level, void* context) {
    (void)irq;
    sdcard_select(&((Board*)context)->card, !level);
}

static void on_led(avr_irq_t* irq, uint32_t level, void* context) {
    (void)irq;
    Board* board = context;
    bool on = level & 1;
    if (on != board->led_on) trace_add(&board->trace, board_now(board), TRACE_LED, 0, on);
    board->led_on = on;
}

static void on_self_test(avr_irq_t* irq, uint32_t level, void* context) {
    (void)irq;
    ((Board*)context)->adc.self_test_on = level & 1;
}

static avr_irq_t* pin_irq(const Board* board, Pin pin) {
    return avr_io_getirq(board->avr, AVR_IOCTL_IOPORT_GETIRQ(pin.port), pin.bit);
}

avr_io_t* board_module(const Board* board, const char* kind) {
    avr_io_t* module = board->avr->io_port;
    while (module && strcmp(module->kind, kind) != 0) module = module->next;
    return module;
}

bool board_open(Board* board, const char* mcu, const char* elf) {
    the_board = board;
    avr_global_logger_set(log_errors);
    size_t known = 0;
    while (known < sizeof WIRING / sizeof *WIRING && strcmp(WIRING[known].mcu, mcu) != 0) known++;
    if (known == sizeof WIRING / sizeof *WIRING) {
        fprintf(stderr, "%s: no wiring is known for this MCU\n", mcu);
        return false;
    }
    elf_firmware_t firmware = {0};
    if (elf_read_firmware(elf, &firmware) != 0 || firmware.flashsize == 0) {
        fprintf(stderr, "%s: not the ELF of an AVR program\n", elf);
        return false;
    }
    avr_t* avr = avr_make_mcu_by_name(mcu);
    if (!avr || avr_init(avr) != 0) return false;
    firmware.frequency = CPU_HZ;
    avr_load_firmware(avr, &firmware);
    board->avr = avr;
    avr->frequency = CPU_HZ;
    avr->sleep = count_idle;
    avr->reset = begin_epoch;  // the cores' own reset functions are empty
    board->run_cycle_limit = avr->run_cycle_limit;

    board->card_select = WIRING[known].card_select;
    board->button = WIRING[known].button;
    board->led = WIRING[known].led;
    board->self_test = WIRING[known].self_test;
    board->mark = WIRING[known].mark;
    board->wheel = WIRING[known].wheel;
    avr_irq_register_notify(pin_irq(board, board->card_select), on_card_select, board);
    avr_irq_register_notify(pin_irq(board, board->led), on_led, board);
    avr_irq_register_notify(pin_irq(board, board->self_test), on_self_test, board);
    avr_irq_register_notify(avr->interrupts.irq + AVR_INT_IRQ_RUNNING, on_interrupt, board);
    adc_attach(board);
    spi_attach(board);
    uart_attach(board);
    return true;
}

uint64_t board_now(const Board* board) { return board->epoch + board->avr->cycle; }

void board_schedule(Board* board, uint32_t cycles, avr_cycle_timer_t callback) {
    avr_t* avr = board->avr;
    avr_cycle_timer_register(avr, cycles, callback, board);
    if (avr->run_cycle_count > cycles) avr->run_cycle_count = cycles;
}

void board_set_boot_loader(Board* board, uint8_t* code, uint32_t size) {
    avr_t* avr = board->avr;
    const uint32_t start = avr->flashend + 1 - size;
    avr_loadcode(avr, code, size, start);
    avr->reset_pc = start;
}

// A line that a pull-up holds up; simavr passes on changes of level only.
static void put_line(Board* board, Pin pin, bool low) {
    if (pin.port == 0) return;
    avr_raise_irq(pin_irq(board, pin), low);
    avr_raise_irq(pin_irq(board, pin), !low);
}

static avr_cycle_count_t turn_wheel(avr_t* avr, avr_cycle_count_t when, void* context) {
    (void)avr;
    Board* board = context;
    board->wheel_low = !board->wheel_low;
    put_line(board, board->wheel, board->wheel_low);
    return when + board->wheel_half;
}

// Bring the parts of this program behind the MCU's reset.
static void follow_reset(Board* board) {
    board->was_reset = false;
    adc_reset(board);
    spi_reset(board);
    uart_reset(board);
    sdcard_select(&board->card, false);
    board->adc.self_test_on = false;
    put_line(board, board->button, board->button_pressed);  // the pins read 0 now
    put_line(board, board->mark, board->mark_pressed);
    put_line(board, board->wheel, board->wheel_low);
    board_turn_wheel(board, 2 * board->wheel_half);
    trace_add(&board->trace, board_now(board), TRACE_RESET, 0, 0);
}

void board_reset(Board* board, ResetCause cause) {
    avr_t* avr = board->avr;
    avr_reset(avr);
    avr->state = cpu_Running;
    const avr_regbit_t flags[] = {
        [RESET_POWER_ON] = avr->reset_flags.porf,
        [RESET_EXTERNAL] = avr->reset_flags.extrf,
        [RESET_BROWN_OUT] = avr->reset_flags.borf,
    };
    avr_regbit_set(avr, flags[cause]);
    follow_reset(board);
}

// The noise found in registers and RAM at power-up: one byte for each address.
static uint8_t ram_noise(uint16_t address) {
    uint32_t mixed = (address ^ RAM_NOISE_SEED) * 2654435761u;
    return (uint8_t)(mixed >> 24);
}

void board_power_on(Board* board) {
    avr_t* avr = board->avr;
    for (uint32_t address = 0; address <= avr->ramend; address++)
        if (address < REGISTERS || address > avr->ioend)
            avr->data[address] = ram_noise((uint16_t)address);
    board->powered = true;
    board_reset(board, RESET_POWER_ON);
    board->idle_cycles = 0;
    board->resets = 0;
    sdcard_power_on(&board->card);
}

void board_power_off(Board* board) {
    board->powered = false;
    board->uart.incoming_read = board->uart.incoming_length = 0;
}

void board_hold(Board* board, uint64_t cycles) {
    board->avr->cycle += cycles;
    board->avr->run_cycle_count = 0;
}

void board_press(Board* board, bool pressed) {
    board->button_pressed = pressed;
    avr_raise_irq(pin_irq(board, board->button), !pressed);
}

void board_press_mark(Board* board, bool pressed) {
    board->mark_pressed = pressed;
    put_line(board, board->mark, pressed);
}

void board_turn_wheel(Board* board, uint32_t period) {
    avr_cycle_timer_cancel(board->avr, turn_wheel, board);
    board->wheel_half = period / 2;
    if (board->wheel_half) board_schedule(board, board->wheel_half, turn_wheel);
}

uint32_t board_untouched(const Board* board, uint16_t address) {
    uint32_t count = 0;
    while (address + count <= board->avr->ramend &&
           board->avr->data[address + count] == ram_noise((uint16_t)(address + count)))
        count++;
    return count;
}

uint32_t board_eeprom_size(const Board* board) { return board->avr->e2end + 1; }

void board_read_eeprom(const Board* board, uint8_t* bytes) {
    avr_eeprom_desc_t all = {.size = board_eeprom_size(board)};
    avr_ioctl(board->avr, AVR_IOCTL_EEPROM_GET,
              &all);  // without a buffer: where it is
    memcpy(bytes, all.ee, all.size);
}

void board_write_eeprom(Board* board, uint8_t* bytes) {
    avr_eeprom_desc_t all = {.ee = bytes, .size = board_eeprom_size(board)};
    avr_ioctl(board->avr, AVR_IOCTL_EEPROM_SET, &all);
}

static bool stands_still(const Board* board) {
    const uint64_t now = board_now(board);
    for (size_t i = 0; i < board->hold_count; i++)
        if (board->holds[i].from <= now && now < board->holds[i].to) return true;
    return false;
}

// While the main program is to stand still it sleeps between interrupts,
// wherever it is. Steps are single instructions then: it must not go on behind
// an interrupt.
static void hold_program(Board* board) {
    avr_t* avr = board->avr;
    const bool still = board->hold_count && stands_still(board);
    avr->run_cycle_limit = still ? 1 : board->run_cycle_limit;
    const bool in_main = avr->sreg[S_I] && !avr->interrupts.running_ptr;
    const bool is_quiet = !avr_has_pending_interrupts(avr);
    if (still && in_main && is_quiet && avr->state == cpu_Running) {
        avr->state = cpu_Sleeping;
        board->held = true;
    } else if (!still && board->held) {
        avr->state = cpu_Running;
        board->held = false;
    }
}

const char* board_run(Board* board, uint64_t end) {
    avr_t* avr = board->avr;
    while (board->powered && board_now(board) < end) {
        hold_program(board);
        int state = avr_run(avr);
        if (board->was_reset) {
            board->resets++;
            follow_reset(board);
        }
        if (board->card.power_cut) board_power_off(board);
        if (state == cpu_Done || state == cpu_Crashed) {
            board->epoch += end - board_now(board);
            return state == cpu_Done ? "halted" : "crashed";
        }
    }
    if (board->powered) return "running";
    if (board_now(board) < end) board->epoch += end - board_now(board);
    return "off";
}
