#include "signals.h"

#include <math.h>

double signals_at(const Signals* signals, unsigned channel, double time_s) {
    if (signals->rows == 0) return 0;
    double row = time_s * signals->rate_hz;
    if (signals->repeat) row = fmod(row, (double)signals->rows);
    if (!signals->repeat && row >= (double)(signals->rows - 1)) row = (double)(signals->rows - 1);
    size_t before = (size_t)row, after = (before + 1) % signals->rows;
    double here = signals->codes[before * CHANNELS + channel];
    double there = signals->codes[after * CHANNELS + channel];
    return here + (row - (double)before) * (there - here);
}
