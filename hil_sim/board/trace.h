// What happened when, to the cycle: the basis of every statement on jitter and worst cases.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    TRACE_CONVERSION = 1,  // which: channel by the multiplexer; value: code
    TRACE_MISSED = 2,      // a trigger edge that started no conversion
    TRACE_ISR_ENTER = 3,   // which: vector number
    TRACE_ISR_EXIT = 4,
    TRACE_LED = 5,  // value: 1 on, 0 off
    TRACE_RESET = 6,
} TraceKind;

// One event of 16 bytes, as it goes over the control pipe.
typedef struct {
    uint64_t cycle;
    uint8_t kind, which;
    uint16_t value;
    uint32_t unused;
} TraceEvent;

typedef struct {
    bool on;
    TraceEvent* events;
    size_t count, capacity;
} Trace;

void trace_add(Trace* trace, uint64_t cycle, TraceKind kind, uint8_t which, uint16_t value);

// `wanted` elements of `size` bytes fit into the array afterwards; ends the program if not.
void* grown(void* array, size_t* capacity, size_t wanted, size_t size);
