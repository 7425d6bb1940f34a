// Runs all tests of this folder. The argument is an empty FAT image; it stays as it is.
#include "check.h"
#include "fake_board.h"

static Test* first = nullptr;
int failures = 0;

Test::Test(const char* test_name, void (*test_body)())
    : name(test_name), body(test_body), next(first) {
    first = this;
}

int main(int count, char** arguments) {
    fake::image_path = count > 1 ? arguments[1] : nullptr;
    int failed = 0;
    for (Test* test = first; test; test = test->next) {
        fake::power_on();
        const int before = failures;
        test->body();
        if (fake::card.rude) ++failures, std::printf("the card was spoken to rudely\n");
        const bool passed = failures == before;
        failed += !passed;
        std::printf("%s:%s\n", test->name, passed ? "PASSED" : "FAILED");
    }
    return failed != 0;
}
