// UART0 and the two wires to the host.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include <simavr/avr_uart.h>

enum { RECEIVE_BUFFER = 2 };  // bytes the receiver holds before it loses one

typedef struct {
    avr_uart_t* port;
    avr_io_write_t simavr_write;  // simavr's transmitter, which gets its byte time from here

    uint8_t* incoming;  // sent by the host and still on the wire
    size_t incoming_read, incoming_length, incoming_capacity;
    uint8_t received[RECEIVE_BUFFER];
    unsigned received_count;
    uint32_t overruns;  // bytes lost because the program did not read in time

    uint64_t* sent;  // cycle << 8 | byte: when the program handed it to the UART
    size_t sent_count, sent_capacity;
} Uart;

struct Board;
void uart_attach(struct Board* board);
void uart_reset(struct Board* board);

// Put bytes on the wire to the MCU, one after another at its own baud rate.
void uart_send(struct Board* board, const uint8_t* bytes, size_t count);
