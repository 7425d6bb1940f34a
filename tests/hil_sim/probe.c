// A firmware that does what it is told over the serial line, one letter at a time: the tests use it
// to look at the simulated board from the inside.
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <stdbool.h>

enum { BUFFER = 1100 };
static uint8_t buffer[BUFFER];
static volatile uint16_t codes[256];
static volatile uint16_t converted, wanted;
static volatile uint16_t dawdle_at, dawdle_loops;
static uint8_t reset_cause;
static volatile uint8_t overrun;
static uint8_t never_set[4] __attribute__((section(".noinit")));

EMPTY_INTERRUPT(TIMER1_COMPA_vect)

static void put(uint8_t byte) {
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    UDR0 = byte;
}

static uint8_t get(void) {
    while (!(UCSR0A & _BV(RXC0))) {
    }
    if (UCSR0A & _BV(DOR0)) overrun = 1;
    return UDR0;
}

static uint16_t get16(void) {
    uint16_t low = get();
    return low | (uint16_t)get() << 8;
}

static void put16(uint16_t value) {
    put((uint8_t)value);
    put((uint8_t)(value >> 8));
}

static void wait(uint16_t loops) {
    while (loops--) __asm__ volatile("nop");
}

ISR(ADC_vect) {
    uint16_t i = converted;
    TIFR1 = _BV(OCF1B);
    uint8_t next = (i + 1) & 15;
    ADMUX = next < 8 ? next : 15 - next;
    codes[i & 255] = ADC;
    converted = i + 1;
    if (dawdle_loops && i == dawdle_at) wait(dawdle_loops);
    if (converted == wanted) ADCSRA &= (uint8_t)~_BV(ADIE);
}

// count conversions by Timer1 in palindrome order, then send their codes
static void convert(uint16_t count) {
    converted = 0;
    wanted = count;
    TCCR1B = 0;
    TCNT1 = 0;
    TCCR1A = 0;
    OCR1A = OCR1B = 2499;
    TIFR1 = 0xff;
    ADMUX = 0;
    ADCSRB = 5;
    ADCSRA = _BV(ADEN) | _BV(ADATE) | _BV(ADIE) | _BV(ADIF) | 7;
    TCCR1B = _BV(WGM12) | _BV(CS10);
    set_sleep_mode(SLEEP_MODE_IDLE);
    while (converted < wanted) sleep_mode();
    TCCR1B = 0;
    ADCSRA = 0;
    for (uint16_t i = 0; i < count; i++) put16(codes[i & 255]);
}

// one conversion started by hand: the code, and Timer1 cycles it took
static void convert_once(uint8_t mux) {
    TCCR1A = 0;
    TCCR1B = _BV(CS10);
    ADMUX = mux;
    ADCSRB = 0;
    ADCSRA = _BV(ADEN) | 7;
    for (uint8_t i = 0; i < 2; i++) {  // the first takes longer
        TCNT1 = 0;
        ADCSRA |= _BV(ADSC);
        while (ADCSRA & _BV(ADSC)) {
        }
    }
    uint16_t took = TCNT1;
    TCCR1B = 0;
    put16(ADC);
    put16(took);
    ADCSRA = 0;
}

// let compare matches A and B set their flags, clear that of B, and show what is left; then let A
// interrupt once
static void match(void) {
    TCCR1A = 0;
    TCCR1B = 0;
    TCNT1 = 0;
    OCR1A = 400;
    OCR1B = 300;
    TIFR1 = 0xff;
    TCCR1B = _BV(WGM12) | _BV(CS10);
    wait(400);
    TCCR1B = 0;
    TIFR1 = _BV(OCF1B);
    put(TIFR1 & (_BV(OCF1A) | _BV(OCF1B)));
    TIFR1 = _BV(OCF1A);
    TIMSK1 = _BV(OCIE1A);
    TCNT1 = 0;
    TCCR1B = _BV(WGM12) | _BV(CS10);
    wait(150);
    TCCR1B = 0;
    TIMSK1 = 0;
    put(TIFR1 & (_BV(OCF1A) | _BV(OCF1B)));
}

static void exchange(uint16_t count) {
    for (uint16_t i = 0; i < count; i++) buffer[i] = get();
    for (uint16_t i = 0; i < count; i++) {
        SPDR = buffer[i];
        while (!(SPSR & _BV(SPIF))) {
        }
        buffer[i] = SPDR;
    }
    for (uint16_t i = 0; i < count; i++) put(buffer[i]);
}

static uint8_t __attribute__((noinline)) recurse(uint8_t depth) {
    volatile uint8_t frame[16];
    for (uint8_t i = 0; i < 16; i++) frame[i] = depth;
    return depth ? (uint8_t)(recurse((uint8_t)(depth - 1)) + frame[3]) : frame[5];
}

static void obey(uint8_t letter) {
    switch (letter) {
        case 'e':
            put(get());
            break;
        case 'a':
            convert_once(get());
            break;
        case 'c':
            convert(get16());
            break;
        case 'd':
            dawdle_at = get16();
            dawdle_loops = get16();
            put('d');
            break;
        case 'x':
            exchange(get16());
            break;
        case 's':
            if (get())
                PORTB |= _BV(2);
            else
                PORTB &= (uint8_t)~_BV(2);
            put('s');
            break;
        case 'f': {
            uint8_t f = get();
            SPCR = _BV(SPE) | _BV(MSTR) | (f & 3);
            SPSR = f >> 2;
            put('f');
            break;
        }
        case 'k': {
            uint8_t at = get();
            eeprom_write_byte((uint8_t*)(uint16_t)at, get());
            put('k');
            break;
        }
        case 'b':
            put(PIND & _BV(2) ? 1 : 0);
            break;
        case 'l':
            if (get())
                PORTB |= _BV(1);
            else
                PORTB &= (uint8_t)~_BV(1);
            put('l');
            break;
        case 'i':
            match();
            break;
        case 'n':
            for (uint8_t i = 0; i < 4; i++) put(never_set[i]);
            break;
        case 'r':
            put(recurse(get()));
            break;
        case 'm':
            put(reset_cause);
            break;
        case 'p':
            wait(get16());
            put('p');
            break;
        case 'w':
            put('w');
            wdt_enable(WDTO_15MS);
            for (;;) {
            }
        case 'h':
            put('h');
            while (!(UCSR0A & _BV(TXC0))) {
            }
            cli();
            sleep_mode();
            break;
    }
}

int main(void) {
    reset_cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
    UBRR0 = 3;  // 500000 baud
    UCSR0A = _BV(U2X0);
    UCSR0B = _BV(TXEN0) | _BV(RXEN0);
    DDRB = _BV(1) | _BV(2) | _BV(3) | _BV(5);
    PORTB = _BV(2);
    PORTD = _BV(2);
    SPCR = _BV(SPE) | _BV(MSTR) | 3;
    sei();
    put('!');
    for (;;) obey(get());
}
