// The calls that create, copy, close and control descriptors.
#include "shim.h"
#include <stdarg.h>
#include <stdio.h>
#include <sys/ioctl.h>

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
    // Closes the ranges around our own descriptors.
    while (from <= last) {
        unsigned next = next_guarded(from);
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

// A serial line never really blocks; the blocking mode that the program sees is kept here.
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

EXPORT int fcntl64(int fd, int command, ...) __attribute__((alias("fcntl")));

EXPORT int ioctl(int fd, unsigned long request, ...) {
    va_list rest;
    va_start(rest, request);
    void *argument = va_arg(rest, void *);
    va_end(rest);
    int result;
    if (is_managed() && can_interface_ioctl(request, argument, &result)) return result;
    return serial_of(fd) ? serial_control(fd, request, argument) : REAL(ioctl)(fd, request, argument);
}
