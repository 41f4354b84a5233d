// Which descriptors of the program are more than they look, and which are the shim's own. Its own stand at high
// numbers, and a program that closes all that it does not know (as daemons do) does not close them.
#include "shim.h"
#include <stdarg.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/resource.h>

void timer_fd_retain(void *object);
void timer_fd_release(void *object);

static struct descriptor table[DESCRIPTORS_MAX];
#define GUARDS_MAX 256
static int guards[GUARDS_MAX];
static int guard_count;

struct descriptor *descriptor(int fd) { return fd >= 0 && fd < DESCRIPTORS_MAX ? &table[fd] : NULL; }

bool is_guarded(int fd) {
    for (int i = 0; i < guard_count; i++)
        if (guards[i] == fd) return true;
    return false;
}

// Moves a descriptor out of the way and keeps it from being closed.
int guard(int fd) {
    struct rlimit limit = {.rlim_cur = 256};
    getrlimit(RLIMIT_NOFILE, &limit);
    int lowest = limit.rlim_cur > 1024 ? 900 : (int)limit.rlim_cur * 3 / 4;
    int moved = REAL(fcntl)(fd, F_DUPFD_CLOEXEC, lowest);
    if (moved < 0) return fd;
    if (is_guarded(fd)) unguard(fd);
    else REAL(close)(fd);
    if (guard_count < GUARDS_MAX) guards[guard_count++] = moved;
    return moved;
}

void unguard(int fd) {
    for (int i = 0; i < guard_count; i++)
        if (guards[i] == fd) guards[i--] = guards[--guard_count];
    REAL(close)(fd);
}

static void retain(const struct descriptor *of) {
    if (of->kind == FD_SERIAL) ((struct serial *)of->object)->users++;
    if (of->kind == FD_CAN) can_retain(of->object);
    if (of->kind == FD_TIMER) timer_fd_retain(of->object);
}

void descriptor_closed(int fd) {
    struct descriptor *of = descriptor(fd);
    if (!of || of->kind == FD_PLAIN) return;
    struct descriptor was = *of;
    *of = (struct descriptor){0};
    if (was.kind == FD_SERIAL) serial_release(was.object);
    if (was.kind == FD_CAN) can_release(was.object);
    if (was.kind == FD_TIMER) timer_fd_release(was.object);
}

void descriptor_set(int fd, enum fd_kind kind, void *object) {
    descriptor_closed(fd);
    if (fd < 0 || fd >= DESCRIPTORS_MAX) return;
    table[fd] = (struct descriptor){.kind = kind, .object = object};
    retain(&table[fd]);
}

void descriptor_copied(int from, int to) {
    if (from == to || to < 0) return;
    struct descriptor *of = descriptor(from);
    if (of && of->kind != FD_PLAIN) descriptor_set(to, of->kind, of->object);
    else descriptor_closed(to);
}

EXPORT int close(int fd) {
    if (is_guarded(fd)) return errno = EBADF, -1;
    descriptor_closed(fd);
    return REAL(close)(fd);
}

#ifdef __GLIBC__
#if __GLIBC_PREREQ(2, 34)
EXPORT int close_range(unsigned first, unsigned last, int flags) {
    bool only_later = flags & CLOSE_RANGE_CLOEXEC;
    unsigned from = first;
    // Around our own, one piece after the other.
    while (from <= last) {
        unsigned next = UINT32_MAX;
        for (int i = 0; i < guard_count; i++)
            if ((unsigned)guards[i] >= from && (unsigned)guards[i] < next) next = (unsigned)guards[i];
        unsigned end = next <= last ? next - 1 : last;
        for (unsigned fd = from; !only_later && fd <= end && fd < DESCRIPTORS_MAX; fd++) descriptor_closed((int)fd);
        if (next != from && from <= end && REAL(close_range)(from, end, flags)) return -1;
        if (next > last || next == UINT32_MAX) break;
        from = next + 1;
    }
    return 0;
}

EXPORT void closefrom(int first) { close_range(first < 0 ? 0 : (unsigned)first, UINT32_MAX, 0); }
#endif
#endif

EXPORT int dup(int fd) {
    int made = REAL(dup)(fd);
    descriptor_copied(fd, made);
    return made;
}

EXPORT int dup2(int fd, int to) {
    if (is_guarded(to)) link_guard(to);
    int made = REAL(dup2)(fd, to);
    descriptor_copied(fd, made);
    return made;
}

EXPORT int dup3(int fd, int to, int flags) {
    if (is_guarded(to)) link_guard(to);
    int made = REAL(dup3)(fd, to, flags);
    descriptor_copied(fd, made);
    return made;
}

// A serial line never blocks for real; whether the program thinks that it does is kept here.
static int flags_of_serial(struct serial *serial, int real, int command, long argument) {
    if (command == F_GETFL) return serial->is_nonblocking ? real : real & ~O_NONBLOCK;
    serial->is_nonblocking = argument & O_NONBLOCK;
    return 0;
}

static int control(int fd, int command, long argument) {
    struct descriptor *of = descriptor(fd);
    bool is_serial = of && (of->kind == FD_SERIAL);
    if (is_guarded(fd)) return errno = EBADF, -1;
    if (is_serial && command == F_SETFL) {
        if (REAL(fcntl)(fd, F_SETFL, argument | O_NONBLOCK)) return -1;
        return flags_of_serial(of->object, 0, command, argument);
    }
    int result = REAL(fcntl)(fd, command, argument);
    if (result < 0) return result;
    if (is_serial && command == F_GETFL) return flags_of_serial(of->object, result, command, 0);
    if (command == F_DUPFD || command == F_DUPFD_CLOEXEC) descriptor_copied(fd, result);
    return result;
}

EXPORT int fcntl(int fd, int command, ...) {
    va_list rest;
    va_start(rest, command);
    long argument = va_arg(rest, long);
    va_end(rest);
    return control(fd, command, argument);
}

EXPORT int fcntl64(int fd, int command, ...) {
    va_list rest;
    va_start(rest, command);
    long argument = va_arg(rest, long);
    va_end(rest);
    return control(fd, command, argument);
}

EXPORT int ioctl(int fd, unsigned long request, ...) {
    va_list rest;
    va_start(rest, request);
    void *argument = va_arg(rest, void *);
    va_end(rest);
    int result;
    if (is_managed() && can_interface_ioctl(request, argument, &result)) return result;
    return serial_of(fd) ? serial_control(fd, request, argument) : REAL(ioctl)(fd, request, argument);
}
