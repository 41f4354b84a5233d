// Clocks and sleeping. Every clock of the program follows the harness's time.
#include "shim.h"
#include <sched.h>
#include <sys/times.h>
#include <threads.h>

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

// A program takes no time, but one that measures its own time expects a clock that advances.
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

// Returns the time left if a signal came, else zero.
static int64_t sleep_until(int64_t deadline) {
    if (due(deadline) <= now_ns) question();
    while (due(deadline) > now_ns) {
        enum woken woken = block_until(deadline);
        if (woken == INTERRUPTED || woken == RESTART) return due(deadline) > now_ns ? due(deadline) - now_ns : 1;
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
