// `syscall`: how Rust's standard library waits, and others that bypass the C library.
#include "shim.h"
#include <linux/futex.h>
#include <stdarg.h>
#include <sys/epoll.h>
#include <sys/syscall.h>

#define FUTEX_OPERATION(op) ((op) & ~(FUTEX_PRIVATE_FLAG | FUTEX_CLOCK_REALTIME))

static long await_word(const uint32_t *word, uint32_t value, int64_t deadline, uint32_t bitset) {
    if (__atomic_load_n(word, __ATOMIC_SEQ_CST) != value) {
        question();
        return errno = EAGAIN, -1;
    }
    switch (block(&(struct wait){.kind = WAIT_ADDRESS,
                                 .giver = THREAD_OR_HANDLER,
                                 .deadline = deadline,
                                 .address = word,
                                 .bitset = bitset})) {
    case TIMED_OUT: return errno = ETIMEDOUT, -1;
    case INTERRUPTED:
    case RESTART: return errno = EINTR, -1;
    default: return 0;
    }
}

static long futex(const long *a) {
    const uint32_t *word = (const uint32_t *)a[0];
    int operation = (int)a[1];
    uint32_t value = (uint32_t)a[2];
    const struct timespec *at = (const struct timespec *)a[3];
    clockid_t clock = operation & FUTEX_CLOCK_REALTIME ? CLOCK_REALTIME : CLOCK_MONOTONIC;
    switch (FUTEX_OPERATION(operation)) {
    case FUTEX_WAIT:
        return await_word(word, value, at ? deadline_after(nanos(at)) : NEVER, UINT32_MAX);
    case FUTEX_WAIT_BITSET:
        return await_word(word, value, at ? deadline_at(clock, at) : NEVER, (uint32_t)a[5]);
    case FUTEX_WAKE: return wake(word, value, UINT32_MAX);
    case FUTEX_WAKE_BITSET: return wake(word, value, (uint32_t)a[5]);
    case FUTEX_CMP_REQUEUE:
        if (*word != (uint32_t)a[5]) return errno = EAGAIN, -1;
        __attribute__((fallthrough));
    case FUTEX_REQUEUE: {
        unsigned woken = wake(word, value, UINT32_MAX);
        return woken + requeue(word, (const void *)a[4], (unsigned)a[3]);
    }
    default: return REAL(syscall)(SYS_futex, a[0], a[1], a[2], a[3], a[4], a[5]);
    }
}

EXPORT long syscall(long number, ...) {
    long a[6];
    va_list rest;
    va_start(rest, number);
    for (int i = 0; i < 6; i++) a[i] = va_arg(rest, long);
    va_end(rest);
    if (in_lockstep()) {
        switch (number) {
        case SYS_futex: return futex(a);
        case SYS_clock_gettime: return clock_gettime((clockid_t)a[0], (struct timespec *)a[1]);
        case SYS_clock_nanosleep: {
            int result =
                clock_nanosleep((clockid_t)a[0], (int)a[1], (const struct timespec *)a[2], (struct timespec *)a[3]);
            return result ? errno = result, -1 : 0;
        }
        case SYS_gettimeofday: return gettimeofday((struct timeval *)a[0], (void *)a[1]);
        case SYS_sched_yield: return sched_yield();
        case SYS_close: return close((int)a[0]);
        case SYS_read: return read((int)a[0], (void *)a[1], (size_t)a[2]);
        case SYS_write: return write((int)a[0], (const void *)a[1], (size_t)a[2]);
#ifdef SYS_epoll_pwait2
        case SYS_epoll_pwait2:
            return epoll_pwait2((int)a[0], (struct epoll_event *)a[1], (int)a[2], (const struct timespec *)a[3],
                                (const sigset_t *)a[4]);
#endif
#ifdef SYS_close_range
        case SYS_close_range: return close_range((unsigned)a[0], (unsigned)a[1], (int)a[2]);
#endif
        default: break;
        }
    }
    return REAL(syscall)(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
