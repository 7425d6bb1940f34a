#pragma once
#include <stdint.h>

// Trouble that a person must know of: the number of flashes of the LED (SPEC.md, "LED").
enum Trouble : uint8_t {
    kNoTrouble = 0,
    kNoFile = 1,  // of the name that a host has asked for: no light shows it
    kNoCard = 2,
    kNoFileSystem = 3,
    kNoRoom = 4,
    kWriteProtected = 5,
    kCardError = 6,
    kConfigError = 7,
};

enum class Light : uint8_t { Ready, Recording, Losing };

// Is the LED lit at this time? While a session runs, that is shown; otherwise trouble, if there is
// any.
bool led_lit(Light light, Trouble trouble, uint32_t ms);

// A push button whose contacts bounce.
class Button {
  public:
    bool pressed(bool down, uint32_t ms);  // true once for every press

  private:
    static const uint8_t kSettleMs = 30;
    uint16_t changed_ms_ = 0;
    bool raw_ = false;
    bool down_ = false;
};
