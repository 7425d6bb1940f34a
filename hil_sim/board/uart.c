#include <assert.h>
#include <string.h>

#include "board.h"

enum { BITS_PER_BYTE = 10 };  // 8N1

static uint32_t byte_cycles(const Board* board) {
    const avr_uart_t* port = board->uart.port;
    avr_t* avr = board->avr;
    uint32_t divisor = avr_regbit_get(avr, port->ubrrl) | (uint32_t)avr_regbit_get(avr, port->ubrrh)
                                                              << 8;
    return (divisor + 1) * (avr_regbit_get(avr, port->u2x) ? 8 : 16) * BITS_PER_BYTE;
}

static avr_cycle_count_t deliver(avr_t* avr, avr_cycle_count_t when, void* context) {
    Board* board = context;
    Uart* uart = &board->uart;
    if (uart->incoming_read == uart->incoming_length) return 0;
    uint8_t byte = uart->incoming[uart->incoming_read++];
    if (avr_regbit_get(avr, uart->port->rxen)) {
        if (uart->received_count == RECEIVE_BUFFER) {
            uart->overruns++;
            avr_regbit_set(avr, uart->port->dor);
        } else {
            uart->received[uart->received_count++] = byte;
            avr_raise_interrupt(avr, &uart->port->rxc);
        }
    }
    return when + byte_cycles(board);
}

// The receive flag stays up, and interrupts again, until the last byte has been read.
static uint8_t read_udr(avr_t* avr, avr_io_addr_t address, void* context) {
    (void)address;
    Board* board = context;
    Uart* uart = &board->uart;
    if (uart->received_count == 0) return 0;
    uint8_t byte = uart->received[0];
    memmove(uart->received, uart->received + 1, --uart->received_count);
    avr_clear_interrupt(avr, &uart->port->rxc);
    avr_regbit_clear(avr, uart->port->rxc.raised);
    avr_regbit_clear(avr, uart->port->dor);
    if (uart->received_count) avr_raise_interrupt(avr, &uart->port->rxc);
    return byte;
}

static void write_udr(avr_t* avr, avr_io_addr_t address, uint8_t value, void* context) {
    Board* board = context;
    Uart* uart = &board->uart;
    uart->port->cycles_per_byte = byte_cycles(board);
    uart->simavr_write(avr, address, value, uart->port);
}

static void on_sent(avr_irq_t* irq, uint32_t value, void* context) {
    (void)irq;
    Board* board = context;
    Uart* uart = &board->uart;
    if (!board->powered) return;
    uart->sent = grown(uart->sent, &uart->sent_capacity, uart->sent_count + 1, sizeof *uart->sent);
    uart->sent[uart->sent_count++] = board_now(board) << 8 | (value & 0xff);
}

void uart_send(Board* board, const uint8_t* bytes, size_t count) {
    Uart* uart = &board->uart;
    bool was_silent = uart->incoming_read == uart->incoming_length;
    if (was_silent) uart->incoming_read = uart->incoming_length = 0;
    uart->incoming =
        grown(uart->incoming, &uart->incoming_capacity, uart->incoming_length + count, 1);
    memcpy(uart->incoming + uart->incoming_length, bytes, count);
    uart->incoming_length += count;
    if (was_silent && count) board_schedule(board, byte_cycles(board), deliver);
}

void uart_attach(Board* board) {
    Uart* uart = &board->uart;
    avr_t* avr = board->avr;
    avr_uart_t* port = NULL;
    for (avr_io_t* module = avr->io_port; module; module = module->next)
        if (strcmp(module->kind, "uart") == 0 && ((avr_uart_t*)module)->name == '0')
            port = (avr_uart_t*)module;
    assert(port);
    uart->port = port;
    port->flags = 0;  // neither print nor sleep

    unsigned udr = AVR_DATA_TO_IO(port->r_udr);
    uart->simavr_write = avr->io[udr].w.c;
    avr->io[udr].w.c = write_udr;
    avr->io[udr].w.param = board;
    avr->io[udr].r.c = read_udr;
    avr->io[udr].r.param = board;
    avr_irq_register_notify(port->io.irq + UART_IRQ_OUTPUT, on_sent, board);
}

// simavr has dropped all timers: what is on the wire goes on arriving.
void uart_reset(Board* board) {
    Uart* uart = &board->uart;
    uart->received_count = 0;
    if (uart->incoming_read < uart->incoming_length)
        board_schedule(board, byte_cycles(board), deliver);
}
