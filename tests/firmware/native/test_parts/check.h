#pragma once
// A test is a function that CHECKs; all of them run, and every CHECK that fails says where.
#include <cstdio>

struct Test {
    Test(const char* name, void (*body)());
    const char* name;
    void (*body)();
    Test* next;
};

extern int failures;

#define TEST(name)                            \
    static void name();                       \
    static Test register_##name(#name, name); \
    static void name()

#define CHECK(condition)                                                        \
    do {                                                                        \
        if (!(condition)) {                                                     \
            ++failures;                                                         \
            std::printf("%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
        }                                                                       \
    } while (0)
