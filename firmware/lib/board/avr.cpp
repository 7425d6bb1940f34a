#ifdef __AVR__
#include "avr.h"

#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/atomic.h>

#include "beside.h"
#include "crc16.h"

// Registers are named as in the ATmega328P's data sheet; the 2560 has the same ones. Sampling:
// Timer1 counts 2500 clocks again and again (CTC), each compare match B starts a conversion in
// hardware, and the interrupt at its end chooses the next input. The software's delays do not move
// the sampling instants.

namespace board {

uint32_t unfinished __attribute__((section(".noinit")));

}  // namespace board

namespace {

// Bits of ports: button D2, sensors' self-test D8, LED D9, card select and SPI where the board has
// them.
#ifdef __AVR_ATmega2560__
#define BUTTON_PORT PORTE
#define BUTTON_PIN PINE
#define LED_PORT PORTH
#define LED_DDR DDRH
#define TEST_PORT PORTH
#define TEST_DDR DDRH
const uint8_t kTest = _BV(5);
const uint8_t kButton = _BV(4), kLed = _BV(6);
const uint8_t kSelect = _BV(0), kSck = _BV(1), kMosi = _BV(2), kMiso = _BV(3);
#else
#define BUTTON_PORT PORTD
#define BUTTON_PIN PIND
#define LED_PORT PORTB
#define LED_DDR DDRB
#define TEST_PORT PORTB
#define TEST_DDR DDRB
const uint8_t kTest = _BV(0);
const uint8_t kButton = _BV(2), kLed = _BV(1);
const uint8_t kSelect = _BV(2), kSck = _BV(5), kMosi = _BV(3), kMiso = _BV(4);
#endif

const uint16_t kEarliestEnd = 1728;          // a conversion ends 13.5 × 128 clocks after its start
const uint8_t kConverterOn = _BV(ADEN) | 7;  // its clock: F_CPU/128

const uint8_t kTriggeredByTimer = _BV(ADTS2) | _BV(ADTS0);  // by Timer1's compare match B

#ifdef __AVR_ATmega2560__
// Beside the eight: mark button D3, pulses D4, both to ground, and a temperature at A8.
const uint8_t kMarkAndPulses = _BV(5);  // of ports E and G
const uint8_t kTemperature = 0x20;

// The input that is selected: the highest bit stands in another register.
uint8_t selected() { return static_cast<uint8_t>(ADMUX | (ADCSRB & _BV(MUX5)) << 2); }

void select(uint8_t input) {
    ADMUX = input & 0x1F;
    ADCSRB = static_cast<uint8_t>(kTriggeredByTimer | (input & 0x20) >> 2);
}

#define USART_UDRE_vect USART0_UDRE_vect
#define USART_RX_vect USART0_RX_vect
#define read_flash_byte pgm_read_byte_far
const uint8_t kBandgap = 0x1E;
#else
uint8_t selected() { return ADMUX; }
void select(uint8_t input) { ADMUX = input; }

#define read_flash_byte pgm_read_byte
const uint8_t kBandgap = 0x0E;
#endif

// MCUSR as this start has found it. RAM that still holds kAwake has kept its contents through it.
uint8_t reset_flags __attribute__((section(".noinit")));
uint16_t awake __attribute__((section(".noinit")));
const uint16_t kAwake = 0x5AC3;
uint32_t now_ms;

uint16_t convert() {
    ADCSRA |= _BV(ADSC);
    while (ADCSRA & _BV(ADSC)) {
    }
    return ADC;
}

// Before anything else: what has reset us, and no watchdog while variables are set up.
//
// Boot loaders clear the flags. Optiboot hands them on in r2 from its version 5 on, which the last
// byte of the flash tells; those that Arduino ships do not. Then the RAM tells at least whether the
// power was off. Optiboot starts the program by its watchdog after an external reset: before
// version 7 that cannot be told from ours, from then on both flags are up.
extern "C" void save_reset_flags() __attribute__((naked, used, section(".init3")));
void save_reset_flags() {
    uint8_t handed_on;
    asm volatile("mov %0, r2" : "=r"(handed_on));
    const uint8_t version = read_flash_byte(FLASHEND);
    uint8_t flags = MCUSR;
    if (!flags && version >= 5 && version != 0xFF) {
        flags = version < 7 ? handed_on & static_cast<uint8_t>(~_BV(WDRF)) : handed_on;
    }
    if (!flags && awake != kAwake) flags = _BV(PORF);
    if (flags & _BV(PORF) || awake != kAwake) board::unfinished = 0;
    reset_flags = flags;
    awake = kAwake;
    MCUSR = 0;
    wdt_disable();
}

// Let the next conversion start `clocks` after the last one. Only while a trigger starts nothing.
void set_round(uint16_t clocks) {
    const uint16_t top = clocks - 1;
    OCR1A = OCR1B = top;
    if (TCNT1 > top) TCNT1 = 0;  // has passed by: or else the timer would go round by its 16 bits
}

}  // namespace

namespace board {

Sampler sampler;
Link serial;
#ifdef __AVR_ATmega2560__
Beside beside;
#endif

void begin() {
    TCCR0A = _BV(WGM01);  // Timer0 counts 250 times 64 clocks: a millisecond
    TCCR0B = _BV(CS01) | _BV(CS00);
    OCR0A = 249;
    TIMSK0 = _BV(OCIE0A);
    BUTTON_PORT |= kButton;  // pull-up
    LED_DDR |= kLed;
    TEST_DDR |= kTest;
    PORTB |= kSelect | kMiso;  // pull-up: an empty socket reads as 0xFF
    DDRB |= kSelect | kSck | kMosi;

    UBRR0 = F_CPU / 16 / 500000 - 1;
    UCSR0A = 0;
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);

    DIDR0 = 0x3F;
#ifdef __AVR_ATmega2560__
    DIDR2 = _BV(ADC8D);
    PORTE |= kMarkAndPulses;  // pull-ups
    PORTG |= kMarkAndPulses;
#endif
    ADMUX = 0;  // reference: the AREF pin, to which the sensors' 3.3 V are tied
    sample(0);
    set_sleep_mode(SLEEP_MODE_IDLE);
    wdt_enable(WDTO_2S);
    sei();
}

uint32_t milliseconds() {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { return now_ms; }
    return 0;  // which is not reached
}

uint16_t dice() { return static_cast<uint16_t>(milliseconds() << 8 | TCNT0); }

void feed_watchdog() { wdt_reset(); }

const FlashChar* reset_cause() {
    const uint8_t flags = reset_flags;
    if (flags & _BV(PORF)) return FLASH("power");
    if (flags & _BV(BORF)) return FLASH("brown-out");
    if (flags & _BV(EXTRF)) return FLASH("external");
    if (flags & _BV(WDRF)) return FLASH("watchdog");
    return FLASH("unknown");
}

void card_select(bool selected) {
    if (selected) {
        PORTB &= static_cast<uint8_t>(~kSelect);
    } else {
        PORTB |= kSelect;
    }
}

void spi_fast(bool fast) {
    SPCR = fast ? _BV(SPE) | _BV(MSTR) : _BV(SPE) | _BV(MSTR) | _BV(SPR1);
    SPSR = 0;  // F_CPU/4, or F_CPU/64
}

uint8_t spi_exchange(uint8_t sent) {
    SPDR = sent;
    while (!(SPSR & _BV(SPIF))) {
    }
    return SPDR;
}

// The CRC is computed while the byte is on its way.
uint16_t spi_send(const uint8_t* data, uint16_t size) {
    uint16_t crc = 0;
    while (size--) {
        const uint8_t byte = *data++;
        SPDR = byte;
        crc = crc16_update(crc, byte);
        while (!(SPSR & _BV(SPIF))) {
        }
    }
    return crc;
}

uint16_t spi_receive(uint8_t* data, uint16_t size) {
    uint16_t crc = 0;
    uint8_t byte = spi_exchange(0xFF);
    while (--size) {
        SPDR = 0xFF;
        crc = crc16_update(crc, byte);
        if (data) *data++ = byte;
        while (!(SPSR & _BV(SPIF))) {
        }
        byte = SPDR;
    }
    if (data) *data = byte;
    return crc16_update(crc, byte);
}

void eeprom_read(uint8_t address, void* data, uint8_t size) {
    eeprom_read_block(data, reinterpret_cast<const void*>(address), size);
}

void eeprom_write(uint8_t address, const void* data, uint8_t size) {
    eeprom_update_block(data, reinterpret_cast<void*>(address), size);
}

void self_test(bool on) {
    if (on) {
        TEST_PORT |= kTest;
    } else {
        TEST_PORT &= static_cast<uint8_t>(~kTest);
    }
}

void sample(uint8_t conversions) {
    self_test(false);
    TCCR1B = 0;  // no more triggers
    ADCSRA = 0;
    if (!conversions) return;
    sampler.start(conversions);
    select(Sampler::input(0));
    ADCSRA = kConverterOn;
    convert();  // the first one after switching on takes longer than the timer's round
    ADCSRB = kTriggeredByTimer;
    TCCR1A = 0;
    TCNT1 = 0;
    OCR1A = OCR1B = Sampler::kClocks - 1;
    TIFR1 = _BV(OCF1B);
    ADCSRA = kConverterOn | _BV(ADATE) | _BV(ADIE) | _BV(ADIF);
    TCCR1B = _BV(WGM12) | _BV(CS10);
}

uint16_t reference_code() {
    ADCSRA = kConverterOn;
    select(kBandgap);
    uint16_t code = 0;
    for (uint8_t k = 0; k < 8; ++k)
        code = convert();  // the reference needs a millisecond to settle
    ADCSRA = 0;
    return code;
}

void start_transmitter() { UCSR0B |= _BV(UDRIE0); }

bool button_down() { return !(BUTTON_PIN & kButton); }

void set_led(bool lit) {
    if (lit) {
        LED_PORT |= kLed;
    } else {
        LED_PORT &= static_cast<uint8_t>(~kLed);
    }
}

void sleep() { sleep_mode(); }

}  // namespace board

ISR(ADC_vect) {
    const uint8_t ended = selected();
    const uint8_t next = board::sampler.advance();
#ifdef __AVR_ATmega2560__
    const uint8_t reference = board::sampler.temperature_next() ? kTemperature : kBandgap;
#else
    const uint8_t reference = kBandgap;
#endif
    select(next == Sampler::kSupply ? reference : next);
    set_round(board::sampler.clocks());
    // While this flag is up a trigger starts nothing: no conversion of the old input, and none at
    // the end of the old round (data sheet, "Changing Channel or Reference Selection"). If the
    // timer has come round already and no conversion runs, that trigger has passed by. The order
    // matters: a trigger between the next two lines does start its conversion.
    TIFR1 = _BV(OCF1B);
    const uint16_t clocks = TCNT1;
    if (clocks < kEarliestEnd && !(ADCSRA & _BV(ADSC))) board::sampler.note_late_trigger();
#ifdef __AVR_ATmega2560__
    if (ended == kTemperature) {
        board::beside.note_temperature(ADC);
        return;
    }
#endif
#ifdef __AVR_ATmega2560__
    const bool pulse = !(PING & kMarkAndPulses), mark = !(PINE & kMarkAndPulses);
    if (ended < Sampler::kSupply) board::beside.look(pulse, mark, board::sampler.due());
#endif
    board::sampler.collect(ended == kBandgap ? Sampler::kSupply : ended, ADC);
}

ISR(TIMER0_COMPA_vect) { ++now_ms; }

ISR(USART_UDRE_vect) {
    uint8_t byte;
    if (board::serial.transmit(byte)) {
        UDR0 = byte;
    } else {
        UCSR0B &= static_cast<uint8_t>(~_BV(UDRIE0));
    }
}

ISR(USART_RX_vect) {
    const bool damaged = UCSR0A & (_BV(FE0) | _BV(DOR0));
    board::serial.receive(UDR0, damaged);
}
#endif
