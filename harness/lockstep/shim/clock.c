// What time it is, and sleeping. Every clock of the program goes by the harness's.
#include "shim.h"
#include <sched.h>
#include <sys/times.h>
#include <threads.h>

// The monotonic clock does not begin at zero, as it does on no machine: programs subtract from it.
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

int64_t clock_ns(clockid_t clock) { return base_of(clock) + now_ns; }

int64_t deadline_after(int64_t span_ns) {
    if (span_ns <= 0) return now_ns;
    return span_ns > NEVER - now_ns ? NEVER : now_ns + span_ns;
}

int64_t deadline_at(clockid_t clock, const struct timespec *at) {
    int64_t ns = nanos(at), base = base_of(clock);
    if (ns == NEVER) return NEVER;
    return ns - base;
}

// A condition variable has a clock that cannot be asked for. What is decades away from the one is meant by the other.
int64_t deadline_guessed(const struct timespec *at) {
    bool is_monotonic = at->tv_sec < realtime_base_ns / SECOND / 2;
    return deadline_at(is_monotonic ? CLOCK_MONOTONIC : CLOCK_REALTIME, at);
}

EXPORT int clock_gettime(clockid_t clock, struct timespec *at) {
    if (!is_managed()) return REAL(clock_gettime)(clock, at);
    if (!at) return errno = EFAULT, -1;
    question();
    *at = timespec_of(clock_ns(clock));
    return 0;
}

EXPORT int gettimeofday(struct timeval *restrict at, void *restrict zone) {
    if (!is_managed()) return REAL(gettimeofday)(at, zone);
    question();
    if (at) *at = timeval_of(clock_ns(CLOCK_REALTIME));
    if (zone) memset(zone, 0, sizeof(struct timezone));
    return 0;
}

EXPORT time_t time(time_t *at) {
    if (!is_managed()) return REAL(time)(at);
    question();
    time_t seconds = clock_ns(CLOCK_REALTIME) / SECOND;
    if (at) *at = seconds;
    return seconds;
}

EXPORT int timespec_get(struct timespec *at, int base) {
    if (!is_managed() || base != TIME_UTC) return REAL(timespec_get)(at, base);
    return clock_gettime(CLOCK_REALTIME, at) ? 0 : base;
}

// A program takes no time, but those that measure what they take want a clock that goes on.
EXPORT clock_t clock(void) {
    if (!is_managed()) return REAL(clock)();
    question();
    return now_ns / (SECOND / CLOCKS_PER_SEC);
}

EXPORT clock_t times(struct tms *taken) {
    if (!is_managed()) return REAL(times)(taken);
    question();
    clock_t ticks = now_ns / (SECOND / sysconf(_SC_CLK_TCK));
    if (taken) *taken = (struct tms){.tms_utime = ticks};
    return ticks;
}

// Returns what is left when a signal came, else zero.
static int64_t sleep_until(int64_t deadline) {
    if (deadline <= now_ns) question();
    while (deadline > now_ns) {
        enum woken woken = block_until(deadline);
        if (woken == INTERRUPTED || woken == RESTART) return deadline > now_ns ? deadline - now_ns : 1;
    }
    return 0;
}

EXPORT int clock_nanosleep(clockid_t clock, int flags, const struct timespec *span, struct timespec *left) {
    if (!in_lockstep()) return REAL(clock_nanosleep)(clock, flags, span, left);
    if (span->tv_nsec < 0 || span->tv_nsec >= SECOND || span->tv_sec < 0) return EINVAL;
    bool is_absolute = flags & TIMER_ABSTIME;
    int64_t deadline = is_absolute ? deadline_at(clock, span) : deadline_after(nanos(span));
    int64_t rest = sleep_until(deadline);
    if (rest && left && !is_absolute) *left = timespec_of(rest);
    return rest ? EINTR : 0;
}

EXPORT int nanosleep(const struct timespec *span, struct timespec *left) {
    if (!in_lockstep()) return REAL(nanosleep)(span, left);
    int result = clock_nanosleep(CLOCK_MONOTONIC, 0, span, left);
    if (result) errno = result;
    return result ? -1 : 0;
}

EXPORT int usleep(useconds_t span) {
    if (!in_lockstep()) return REAL(usleep)(span);
    if (sleep_until(deadline_after(span * 1000LL))) return errno = EINTR, -1;
    return 0;
}

EXPORT unsigned sleep(unsigned seconds) {
    if (!in_lockstep()) return REAL(sleep)(seconds);
    int64_t left = sleep_until(deadline_after(seconds * SECOND));
    return (unsigned)((left + SECOND - 1) / SECOND);
}

EXPORT int thrd_sleep(const struct timespec *span, struct timespec *left) {
    if (!in_lockstep()) return REAL(thrd_sleep)(span, left);
    return clock_nanosleep(CLOCK_MONOTONIC, 0, span, left) ? -1 : 0;
}

EXPORT int sched_yield(void) {
    if (!in_lockstep()) return REAL(sched_yield)();
    question();
    give_way();
    return 0;
}

EXPORT void thrd_yield(void) { sched_yield(); }
