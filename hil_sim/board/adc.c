// Sources: ATmega48A/PA/88A/PA/168A/PA/328/P data sheet, section 24
// "Analog-to-Digital Converter": 24.3 (auto triggering), 24.4 (timing, table
// 24-1), 24.5 (when the multiplexer is latched), 24.9.2 (register
// bits); 16.11.9 for TIFR1.
#include <assert.h>
#include <math.h>
#include <string.h>

#include "board.h"

enum { ADPS = 7, ADIE = 3, ADIF = 4, ADATE = 5, ADSC = 6, ADEN = 7 };  // bits of ADCSRA
enum { ADTS_FREE_RUNNING = 0, ADTS_TIMER1_COMPARE_B = 5, ADTS_MASK = 7, REFS_SHIFT = 6 };
enum { TRIGGER_SYNCHRONISATION = 3, CODES = 1024, TEMPERATURE_CODE = 330, LONGER_FIRST = 12 };

static uint32_t adc_clock(uint8_t adcsra) {
    unsigned shift = adcsra & ADPS;
    return 1u << (shift ? shift : 1);
}

static uint16_t code_of(Board* board, avr_adc_mux_t mux, double time_s) {
    double code = 0;
    if (mux.kind == ADC_MUX_SINGLE && mux.src < CHANNELS)
        code = signals_at(&board->signals, mux.src, time_s) +
               (board->adc.self_test_on ? board->adc.self_test[mux.src] : 0);
    else if (mux.kind == ADC_MUX_SINGLE && mux.src == CHANNELS)
        code = board->adc.temperature;
    else if (mux.kind == ADC_MUX_REF)
        code = (double)mux.src / board->adc.reference_mV * CODES;
    else if (mux.kind == ADC_MUX_TEMP)
        code = TEMPERATURE_CODE;
    return code <= 0 ? 0 : code >= CODES ? CODES - 1 : (uint16_t)floor(code);
}

static avr_cycle_count_t conversion_done(avr_t* avr, avr_cycle_count_t when, void* context);

// Latch the multiplexer and sample. Triggered, the sample is held 2 ADC clocks
// and 3 CPU cycles after the edge and the result is there after 13.5; started
// by hand, after 1.5 and 13. The start lies `ago` cycles back: simavr's timers
// fire at the end of an instruction.
static void start_conversion(Board* board, bool triggered, uint32_t ago) {
    avr_t* avr = board->avr;
    Adc* adc = &board->adc;
    avr_regbit_set(avr, adc->port->adsc);
    uint32_t clock = adc_clock(avr->data[adc->port->r_adcsra]);
    uint32_t half_clocks_to_sample = (triggered ? 4 : 3) + (adc->first ? 2 * LONGER_FIRST : 0);
    uint32_t half_clocks = (triggered ? 27 : 26) + (adc->first ? 2 * LONGER_FIRST : 0);
    uint32_t extra = triggered ? TRIGGER_SYNCHRONISATION : 0;
    adc->first = false;

    uint8_t selected = avr_regbit_get_array(avr, adc->port->mux, 6);
    uint64_t start = board_now(board) - ago;
    double sampled_at = (double)(start + half_clocks_to_sample * clock / 2 + extra);
    adc->result = code_of(board, adc->port->muxmode[selected], sampled_at / CPU_HZ);
    adc->conversions++;
    if (avr->data[adc->port->r_admux] >> REFS_SHIFT) adc->reference_conflicts++;
    trace_add(&board->trace, start, TRACE_CONVERSION, selected, adc->result);
    uint32_t duration = half_clocks * clock / 2 + extra;
    board_schedule(board, duration > ago ? duration - ago : 1, conversion_done);
}

static avr_cycle_count_t conversion_done(avr_t* avr, avr_cycle_count_t when, void* context) {
    Board* board = context;
    avr_adc_t* port = board->adc.port;
    uint16_t shown = avr_regbit_get(avr, port->adlar) ? board->adc.result << 6 : board->adc.result;
    avr->data[port->r_adcl] = (uint8_t)shown;
    avr->data[port->r_adch] = (uint8_t)(shown >> 8);
    avr_regbit_clear(avr, port->adsc);
    avr_raise_interrupt(avr, &port->adc);
    bool free_running = avr_regbit_get(avr, port->adate) &&
                        (avr->data[port->r_adcsrb] & ADTS_MASK) == ADTS_FREE_RUNNING;
    if (free_running) start_conversion(board, false, (uint32_t)(avr->cycle - when));
    return 0;
}

static void write_adcsra(avr_t* avr, avr_io_addr_t address, uint8_t value, void* context) {
    Board* board = context;
    avr_adc_t* port = board->adc.port;
    bool was_enabled = avr_regbit_get(avr, port->aden);
    bool converting = avr_regbit_get(avr, port->adsc);
    bool flag = avr_regbit_get(avr, port->adc.raised);
    avr->data[address] = (uint8_t)((value & ~(1 << ADIF | 1 << ADSC)) | flag << ADIF);
    if (value & 1 << ADIF) avr_clear_interrupt(avr, &port->adc);
    if (!(value & 1 << ADEN)) {
        avr_cycle_timer_cancel(avr, conversion_done, board);
        return;
    }
    if (!was_enabled) board->adc.first = true;
    if (converting)
        avr_regbit_set(avr, port->adsc);
    else if (value & 1 << ADSC)
        start_conversion(board, false, 0);
}

// simavr warns of trigger sources it does not know; here they are plain bits.
static void write_plain(avr_t* avr, avr_io_addr_t address, uint8_t value, void* context) {
    (void)context;
    avr->data[address] = value;
}

static uint8_t read_plain(avr_t* avr, avr_io_addr_t address, void* context) {
    (void)context;
    return avr->data[address];
}

// Cycles since compare match B, which is at the overflow if it is at the top.
static uint32_t since_compare_b(const Board* board) {
    const avr_timer_t* timer = board->adc.timer;
    uint64_t after_overflow = timer->comp[AVR_TIMER_COMPB].comp_cycles;
    if (after_overflow == timer->tov_cycles) after_overflow = 0;
    return (uint32_t)(board->avr->cycle - timer->tov_base - after_overflow);
}

// The interrupt flag of compare match B goes up (1) or is cleared (0).
static void on_compare_b(avr_irq_t* irq, uint32_t level, void* context) {
    (void)irq;
    Board* board = context;
    Adc* adc = &board->adc;
    avr_t* avr = board->avr;
    bool edge = level && !adc->compare_flag;
    adc->compare_flag = level;
    bool selected = avr_regbit_get(avr, adc->port->aden) && avr_regbit_get(avr, adc->port->adate) &&
                    (avr->data[adc->port->r_adcsrb] & ADTS_MASK) == ADTS_TIMER1_COMPARE_B;
    if (!level || !selected) return;
    if (edge && !avr_regbit_get(avr, adc->port->adsc)) {
        start_conversion(board, true, since_compare_b(board));
    } else {
        adc->missed++;
        trace_add(&board->trace, board_now(board), TRACE_MISSED, 0, 0);
    }
}

// Writing a one clears that flag and no other.
static void write_tifr1(avr_t* avr, avr_io_addr_t address, uint8_t value, void* context) {
    (void)address;
    avr_timer_t* timer = ((Board*)context)->adc.timer;
    avr_int_vector_t* vectors[] = {
        &timer->overflow,
        &timer->icr,
        &timer->comp[AVR_TIMER_COMPA].interrupt,
        &timer->comp[AVR_TIMER_COMPB].interrupt,
        &timer->comp[AVR_TIMER_COMPC].interrupt,
    };
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++)
        if (vectors[i]->vector && value & 1 << vectors[i]->raised.bit)
            avr_clear_interrupt(avr, vectors[i]);
}

static avr_timer_t* timer1(const Board* board) {
    for (avr_io_t* module = board->avr->io_port; module; module = module->next)
        if (strcmp(module->kind, "timer") == 0 && ((avr_timer_t*)module)->name == '1')
            return (avr_timer_t*)module;
    return NULL;
}

static void replace_write(Board* board, avr_io_addr_t address, avr_io_write_t handler) {
    board->avr->io[AVR_DATA_TO_IO(address)].w.c = handler;
    board->avr->io[AVR_DATA_TO_IO(address)].w.param = board;
}

void adc_attach(Board* board) {
    avr_adc_t* port = board->adc.port = (avr_adc_t*)board_module(board, "adc");
    avr_timer_t* timer = board->adc.timer = timer1(board);
    assert(port && timer);
    replace_write(board, port->r_adcsra, write_adcsra);
    replace_write(board, port->r_adcsrb, write_plain);
    replace_write(board, timer->overflow.raised.reg, write_tifr1);
    board->avr->io[AVR_DATA_TO_IO(port->r_adcl)].r.c = read_plain;
    board->avr->io[AVR_DATA_TO_IO(port->r_adch)].r.c = read_plain;
    avr_irq_register_notify(timer->comp[AVR_TIMER_COMPB].interrupt.irq + AVR_INT_IRQ_PENDING,
                            on_compare_b, board);
}

void adc_reset(Board* board) {
    board->adc.first = false;
    board->adc.compare_flag = false;
}
