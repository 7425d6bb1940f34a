#pragma once
#include "board.h"
#include "link.h"
#include "sampler.h"

// The ATmega328P or 2560 itself: what main.cpp needs beyond board.h.
namespace board {

void begin();
bool button_down();
void set_led(bool lit);
void sleep();  // until the next interrupt

}  // namespace board
