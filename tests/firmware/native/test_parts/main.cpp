// Runs all tests of this folder, or those named, in that order and until one fails or takes the
// processor for more than 4 s:
//
//     parts [IMAGE [TEST ...]]
//
// IMAGE is an empty FAT file system; it stays as it is.
#include <sys/time.h>

#include <chrono>
#include <cstring>

#include "check.h"
#include "fake_board.h"

static Test* first = nullptr;
int failures = 0;

Test::Test(const char* test_name, void (*test_body)())
    : name(test_name), body(test_body), next(first) {
    first = this;
}

static bool passes(const Test& test) {
    using Clock = std::chrono::steady_clock;
    fake::power_on();
    const int before = failures;
    const Clock::time_point start = Clock::now();
    test.body();
    if (fake::card.rude) ++failures, std::printf("the card was spoken to rudely\n");
    const bool passed = failures == before;
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start);
    std::printf("%s took %lld us\n", test.name, static_cast<long long>(us.count()));
    std::printf("%s:%s\n", test.name, passed ? "PASSED" : "FAILED");
    std::fflush(stdout);
    return passed;
}

int main(int count, char** arguments) {
    fake::image_path = count > 1 ? arguments[1] : nullptr;
    bool all = true;
    if (count < 3) {
        for (Test* test = first; test; test = test->next) all = passes(*test) && all;
    }
    for (int k = 2; k < count && all; ++k) {
        const itimerval patience = {{0, 0}, {4, 0}};
        setitimer(ITIMER_PROF, &patience, nullptr);
        Test* test = first;
        while (test && std::strcmp(test->name, arguments[k])) test = test->next;
        all = test && passes(*test);
    }
    return !all;
}
