// Voltages at the eight analog inputs, as a function of board time.
#pragma once

#include <stdbool.h>
#include <stddef.h>

enum { CHANNELS = 8 };

// A table of ADC codes, not rounded, one row of CHANNELS per 1/rate seconds from board time 0.
// Between the rows straight lines; before and after it the first and last row, or, repeated, the
// first row again 1/rate after the last.
typedef struct {
    double* codes;
    size_t rows;
    double rate_hz;
    bool repeat;
} Signals;

double signals_at(const Signals* signals, unsigned channel, double time_s);
