// Times and spans: the origin of a program's clocks, and the end of a wait.
#include "shim.h"

// The monotonic clock does not start at zero, nor does it on a real machine: programs subtract from it.
#define MONOTONIC_BASE (10000 * SECOND)

int64_t nanos(const struct timespec *span) {
    int64_t ns;
    if (__builtin_mul_overflow((int64_t)span->tv_sec, SECOND, &ns)
        || __builtin_add_overflow(ns, (int64_t)span->tv_nsec, &ns))
        return span->tv_sec < 0 ? 0 : NEVER;
    return ns;
}

struct timespec timespec_of(int64_t ns) {
    return (struct timespec){.tv_sec = ns / SECOND, .tv_nsec = ns % SECOND};
}

struct timeval timeval_of(int64_t ns) {
    return (struct timeval){.tv_sec = ns / SECOND, .tv_usec = ns % SECOND / 1000};
}

static int64_t base_of(clockid_t clock) {
    switch (clock) {
    case CLOCK_REALTIME:
    case CLOCK_REALTIME_COARSE:
    case CLOCK_REALTIME_ALARM:
    case CLOCK_TAI: return realtime_base_ns;
    case CLOCK_MONOTONIC:
    case CLOCK_MONOTONIC_RAW:
    case CLOCK_MONOTONIC_COARSE:
    case CLOCK_BOOTTIME:
    case CLOCK_BOOTTIME_ALARM: return MONOTONIC_BASE;
    default: return 0;
    }
}

// A deadline of the wall clock, which may be set while it is awaited, is negative: nanoseconds since 1970 from here on.
#define WALL_CLOCK (INT64_MIN + 1)

// When a deadline comes by the clocks as they are now.
int64_t due(int64_t deadline) {
    if (deadline >= 0 || deadline < WALL_CLOCK) return deadline;
    int64_t at = deadline - WALL_CLOCK;
    return at > realtime_base_ns ? at - realtime_base_ns : 0;
}

int64_t clock_ns(clockid_t clock) { return base_of(clock) + now_ns; }

int64_t deadline_after(int64_t span_ns) {
    if (span_ns <= 0) return now_ns;
    return span_ns > NEVER - now_ns ? NEVER : now_ns + span_ns;
}

int64_t deadline_at(clockid_t clock, const struct timespec *at) {
    int64_t ns = nanos(at), base = base_of(clock);
    if (ns == NEVER) return NEVER;
    if (ns < 0) ns = 0;
    if (base == realtime_base_ns) return WALL_CLOCK + ns;
    return ns > base ? ns - base : 0;
}

// The clock of a condition variable cannot be queried. A time decades away from one clock belongs to the other.
int64_t deadline_guessed(const struct timespec *at) {
    bool is_monotonic = at->tv_sec < realtime_base_ns / SECOND / 2;
    return deadline_at(is_monotonic ? CLOCK_MONOTONIC : CLOCK_REALTIME, at);
}
