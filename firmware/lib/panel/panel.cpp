#include "panel.h"

bool led_lit(Light light, Trouble trouble, uint32_t ms) {
    if (light == Light::Recording) return true;
    if (light == Light::Losing) return ms % 200 < 100;
    if (!trouble) return ms % 2000 < 50;
    const uint16_t flash_ms = 400;
    const uint32_t at =
        ms % (flash_ms * (trouble + 3u));  // a pause of three flashes between groups
    return at < flash_ms * static_cast<uint32_t>(trouble) && at % flash_ms < flash_ms / 2;
}

bool Button::pressed(bool down, uint32_t ms) {
    if (down != raw_) {
        raw_ = down;
        changed_ms_ = static_cast<uint16_t>(ms);
    }
    if (raw_ == down_ || static_cast<uint16_t>(ms - changed_ms_) < kSettleMs) return false;
    down_ = raw_;
    return down_;
}
