// The SPI master with its real bit times, and the SD card at its other end.
#pragma once

#include <stdint.h>

#include <simavr/avr_spi.h>

typedef struct {
    avr_spi_t* port;
    uint8_t outgoing;
    uint32_t byte_cycles;  // of the transfer under way, 0 if there is none
    uint64_t bytes;
    uint32_t collisions;  // bytes written into a transfer under way, which are lost
} Spi;

struct Board;
void spi_attach(struct Board* board);
void spi_reset(struct Board* board);
