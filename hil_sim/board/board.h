// The simulated board: an AVR, and around it what the wiring diagram shows.
//
// simavr runs the instructions, Timer1, ports, EEPROM and watchdog. Four of its
// peripherals are replaced here (adc.c, spi.c, uart.c, and the flag register of
// Timer1 in adc.c), because version 1.6 lacks what the logger stands on:
// hil_sim/README.md says which, and why.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

#include "adc.h"
#include "sdcard.h"
#include "signals.h"
#include "spi.h"
#include "trace.h"
#include "uart.h"

enum { CPU_HZ = 16000000 };

// A port pin of the AVR, such as { 'D', 2 }.
typedef struct {
    char port;
    uint8_t bit;
} Pin;

typedef struct Board {
    avr_t* avr;
    Pin card_select, button, led, self_test;
    Pin mark, wheel;  // of the Mega alone; port 0: there is none

    Adc adc;
    Spi spi;
    Uart uart;
    SdCard card;
    Signals signals;
    Trace trace;

    Interval holds[MAX_FAULTS];  // the main program stands still, interrupts go on
    size_t hold_count;
    bool held;  // asleep because of that

    bool powered;
    bool button_pressed, mark_pressed, led_on, wheel_low;
    uint32_t wheel_half;       // cycles of half a period of the wheel's pulses; 0: it stands
    bool was_reset;            // by the watchdog or by us; our peripherals follow
    uint64_t epoch;            // board time at which simavr's cycle counter was 0
    uint64_t run_cycle_limit;  // simavr's own, between two looks at its surroundings
    uint64_t idle_cycles;      // spent asleep since power-up
    uint32_t resets;           // since power-up, the first start not counted
} Board;

typedef enum { RESET_POWER_ON, RESET_EXTERNAL, RESET_BROWN_OUT } ResetCause;

// Load the ELF into the named MCU ("atmega328p", "atmega2560"); the power is
// off afterwards. False, with a line on stderr, if there is no such file or
// MCU.
bool board_open(Board* board, const char* mcu, const char* elf);

// What the boot section, the end of the flash, holds: every reset starts there
// from now on.
void board_set_boot_loader(Board* board, uint8_t* code, uint32_t size);

// Board time in CPU cycles since board_open. It goes on over resets and while
// the power is off.
uint64_t board_now(const Board* board);

// Run until board time `end`, or until the CPU stops for good. Returns the
// state as one word: "running", "off", "halted" (asleep with interrupts
// disabled) or "crashed" (invalid instruction or address).
const char* board_run(Board* board, uint64_t end);

// Power-on fills registers and RAM with noise (the same at every start) and
// resets the card.
void board_power_on(Board* board);
void board_power_off(Board* board);
void board_reset(Board* board, ResetCause cause);

// Let the CPU do nothing for so many cycles, interrupts included, as in a
// section of code that takes too long; the peripherals go on.
void board_hold(Board* board, uint64_t cycles);
void board_press(Board* board, bool pressed);
void board_press_mark(Board* board, bool pressed);
// The wheel's sensor pulls its line low for the second half of every period; 0:
// it stands.
void board_turn_wheel(Board* board, uint32_t period);

// Bytes from a RAM address upwards which nothing has written since power-on:
// what is left between the static data and the deepest stack.
uint32_t board_untouched(const Board* board, uint16_t address);

// Copy the EEPROM out of or into the MCU; `bytes` has board_eeprom_size bytes.
uint32_t board_eeprom_size(const Board* board);
void board_read_eeprom(const Board* board, uint8_t* bytes);
void board_write_eeprom(Board* board, uint8_t* bytes);

// A cycle timer that also fires in time when simavr is in the middle of a run
// of instructions.
void board_schedule(Board* board, uint32_t cycles, avr_cycle_timer_t callback);

// The simavr module of a kind ("spi", "adc", …) and name, or NULL. All begin
// with avr_io_t.
avr_io_t* board_module(const Board* board, const char* kind);
