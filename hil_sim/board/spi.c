#include <assert.h>

#include "board.h"

static avr_cycle_count_t transfer_done(avr_t* avr, avr_cycle_count_t when, void* context) {
    (void)when;
    Board* board = context;
    Spi* spi = &board->spi;
    spi->port->input_data_register =
        sdcard_exchange(&board->card, spi->outgoing, board_now(board), spi->byte_cycles);
    spi->byte_cycles = 0;
    spi->bytes++;
    avr_raise_interrupt(avr, &spi->port->spi);
    return 0;
}

static void write_spdr(avr_t* avr, avr_io_addr_t address, uint8_t value, void* context) {
    (void)address;
    // Data sheet, table 19-5, by SPI2X, SPR1, SPR0.
    static const uint8_t clock_shift[8] = {2, 4, 6, 7, 1, 3, 5, 6};
    Board* board = context;
    Spi* spi = &board->spi;
    if (!avr_regbit_get(avr, spi->port->spe) || !avr_regbit_get(avr, spi->port->mstr)) return;
    if (spi->byte_cycles) {
        spi->collisions++;
        return;
    }
    avr_clear_interrupt(avr, &spi->port->spi);
    spi->outgoing = value;
    spi->byte_cycles = 8u << clock_shift[avr_regbit_get_array(avr, spi->port->spr, 3)];
    board_schedule(board, spi->byte_cycles, transfer_done);
}

void spi_attach(Board* board) {
    avr_spi_t* port = board->spi.port = (avr_spi_t*)board_module(board, "spi");
    assert(port);
    board->avr->io[AVR_DATA_TO_IO(port->r_spdr)].w.c = write_spdr;
    board->avr->io[AVR_DATA_TO_IO(port->r_spdr)].w.param = board;
}

void spi_reset(Board* board) { board->spi.byte_cycles = 0; }
