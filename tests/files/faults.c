/* A disk that fails, for any program: LD_PRELOAD this. Below the folder FAULT_FOLDER every call that
   changes the disk is counted; from `fault_arm` on, the n-th one fails:

   once     that call fails, the next ones work (a disk that was full, and then is not)
   forever  that call and all after it fail (a disk that has gone)
   cut      the program ends there without another instruction (a power cut, a kill -9)

   A write that fails may have taken half of what it was given. After SQLite's test VFS:
   https://www.sqlite.org/testing.html, "I/O Error Testing" and "Crash Testing". */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum { OFF, ONCE, FOREVER, CUT };
static int mode = OFF;
static long left, calls;

void fault_arm(int how, long n) { mode = how; left = n; calls = 0; }
long fault_calls(void) { return calls; }

static int inside(const char *path) {
    const char *folder = getenv("FAULT_FOLDER");
    return folder && path && strncmp(path, folder, strlen(folder)) == 0;
}

static int inside_file(int file) {
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t size = readlink(link, path, sizeof path - 1);
    if (size < 0) return 0;
    path[size] = 0;
    return inside(path);
}

static int fails(void) {
    calls++;
    if (mode == OFF || left-- > 0) return 0;
    if (mode == CUT) _exit(137);
    if (mode == ONCE) mode = OFF;
    errno = ENOSPC;
    return 1;
}

#define REAL(type, name, ...) \
    static type (*real)(__VA_ARGS__); \
    if (!real) real = (type(*)(__VA_ARGS__))dlsym(RTLD_NEXT, #name)

ssize_t write(int file, const void *data, size_t size) {
    REAL(ssize_t, write, int, const void *, size_t);
    if (size && inside_file(file)) {
        if (mode != OFF && left <= 0) real(file, data, size / 2);
        if (fails()) return -1;
    }
    return real(file, data, size);
}

int fsync(int file) {
    REAL(int, fsync, int);
    return inside_file(file) && fails() ? -1 : real(file);
}

int rename(const char *from, const char *to) {
    REAL(int, rename, const char *, const char *);
    return inside(to) && fails() ? -1 : real(from, to);
}

int unlink(const char *path) {
    REAL(int, unlink, const char *);
    return inside(path) && fails() ? -1 : real(path);
}

int rmdir(const char *path) {
    REAL(int, rmdir, const char *);
    return inside(path) && fails() ? -1 : real(path);
}

int mkdir(const char *path, mode_t bits) {
    REAL(int, mkdir, const char *, mode_t);
    return inside(path) && fails() ? -1 : real(path, bits);
}

static int opening(int (*real)(const char *, int, ...), const char *path, int flags, mode_t bits) {
    if (flags & (O_CREAT | O_TRUNC) && inside(path) && fails()) return -1;
    return real(path, flags, bits);
}

#define OPEN(name) \
    int name(const char *path, int flags, ...) { \
        REAL(int, name, const char *, int, ...); \
        va_list more; \
        va_start(more, flags); \
        mode_t bits = flags & O_CREAT ? va_arg(more, mode_t) : 0; \
        va_end(more); \
        return opening(real, path, flags, bits); \
    }
OPEN(open)
OPEN(open64)
