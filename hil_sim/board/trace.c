#include "trace.h"

#include <stdio.h>
#include <stdlib.h>

void* grown(void* array, size_t* capacity, size_t wanted, size_t size) {
    if (wanted <= *capacity) return array;
    *capacity = wanted + wanted / 2 + 64;
    array = realloc(array, *capacity * size);
    if (!array) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    return array;
}

void trace_add(Trace* trace, uint64_t cycle, TraceKind kind, uint8_t which, uint16_t value) {
    if (!trace->on) return;
    trace->events = grown(trace->events, &trace->capacity, trace->count + 1, sizeof *trace->events);
    trace->events[trace->count++] =
        (TraceEvent){.cycle = cycle, .kind = (uint8_t)kind, .which = which, .value = value};
}
