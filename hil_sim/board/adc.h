// The ADC of the ATmega328P and 2560, as their data sheets describe it.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <simavr/avr_adc.h>
#include <simavr/avr_timer.h>

typedef struct {
    avr_adc_t* port;
    avr_timer_t* timer;     // Timer1, whose compare match B triggers
    uint32_t reference_mV;  // at the AREF pin
    double self_test[8];    // codes by which the sensors' self-test shifts the eight
                            // inputs
    bool self_test_on;
    double temperature;  // code at the ninth input
    bool first;          // since it was enabled: this conversion takes longer
    bool compare_flag;   // OCF1B: only its rising edge triggers
    uint16_t result;     // of the conversion under way
    uint64_t conversions;
    uint64_t missed;               // compare matches that started no conversion, while ADTS
                                   // selects them
    uint32_t reference_conflicts;  // conversions with an internal reference while
                                   // AREF is driven
} Adc;

struct Board;
void adc_attach(struct Board* board);
void adc_reset(struct Board* board);
