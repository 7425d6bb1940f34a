#include <initializer_list>

#include "check.h"
#include "panel.h"

namespace {

int flashes(Light light, Trouble trouble, uint32_t from_ms, uint32_t to_ms) {
    int count = 0;
    bool was = false;
    for (uint32_t ms = from_ms; ms < to_ms; ++ms) {
        const bool is = led_lit(light, trouble, ms);
        count += is && !was;
        was = is;
    }
    return count;
}

}  // namespace

TEST(trouble_flashes_its_number) {
    for (Trouble trouble :
         {kNoCard, kNoFileSystem, kNoRoom, kWriteProtected, kCardError, kConfigError}) {
        const uint32_t group_ms = 400u * (trouble + 3u);
        CHECK(flashes(Light::Ready, trouble, 0, group_ms) == trouble);
        CHECK(flashes(Light::Ready, trouble, 0, 3 * group_ms) == 3 * trouble);
    }
}

TEST(light_of_a_session) {
    CHECK(flashes(Light::Ready, kNoTrouble, 0, 10000) == 5);
    CHECK(led_lit(Light::Ready, kNoTrouble, 49) && !led_lit(Light::Ready, kNoTrouble, 50));
    CHECK(flashes(Light::Losing, kNoTrouble, 0, 10000) == 50);
    for (uint32_t ms = 0; ms < 5000; ++ms) CHECK(led_lit(Light::Recording, kNoCard, ms));
}

TEST(a_bouncing_button_is_one_press) {
    Button button;
    int presses = 0;
    for (uint32_t ms = 0xFFFFFF00; ms != 1000; ++ms) {  // the clock passes 32 bits on the way
        const uint32_t since = ms - 0xFFFFFF00;
        const bool bouncing = since < 320 ? since % 3 == 0 : since % 4 < 2;
        const bool down = since < 300                                    ? false
                          : since < 310 || (since >= 600 && since < 610) ? bouncing
                                                                         : since < 600;
        presses += button.pressed(down, ms);
    }
    CHECK(presses == 1);
}

TEST(a_spike_is_no_press) {
    Button button;
    bool pressed = false;
    for (uint32_t ms = 0; ms < 200; ++ms)
        pressed = pressed || button.pressed(ms > 100 && ms < 120, ms);
    CHECK(!pressed);
}
