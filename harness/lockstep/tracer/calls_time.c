// Clocks and sleeping.
#include "tracer.h"
#include <sys/syscall.h>
#include <sys/times.h>

static int64_t ask_clock(struct tracee *of, uint64_t *a) {
    clockid_t clock = (clockid_t)a[0];
    // Clocks of devices and of other processes are not simulated.
    if (clock >= CLOCKS) return -EINVAL;
    question();
    struct timespec at = timespec_of(clock_ns(clock));
    return put(of, a[1], &at, sizeof at) ? 0 : -EFAULT;
}

static int64_t ask_day(struct tracee *of, uint64_t *a) {
    question();
    struct timeval at = timeval_of(clock_ns(CLOCK_REALTIME));
    struct timezone zone = {0};
    if (a[0] && !put(of, a[0], &at, sizeof at)) return -EFAULT;
    return a[1] && !put(of, a[1], &zone, sizeof zone) ? -EFAULT : 0;
}

static int64_t ask_seconds(struct tracee *of, uint64_t *a) {
    question();
    time_t seconds = clock_ns(CLOCK_REALTIME) / SECOND;
    return a[0] && !put(of, a[0], &seconds, sizeof seconds) ? -EFAULT : seconds;
}

static int64_t ask_times(struct tracee *of, uint64_t *a) {
    question();
    clock_t ticks = now_ns / (SECOND / sysconf(_SC_CLK_TCK));
    struct tms taken = {.tms_utime = ticks};
    return a[0] && !put(of, a[0], &taken, sizeof taken) ? -EFAULT : ticks;
}

static bool is_span(const struct timespec *span) {
    return span->tv_sec >= 0 && span->tv_nsec >= 0 && span->tv_nsec < SECOND;
}

static int64_t sleep_until(struct tracee *of, int64_t deadline, uint64_t left) {
    if (due(deadline) <= now_ns) question();
    while (due(deadline) > now_ns) {
        if (block_until(deadline) != INTERRUPTED) continue;
        struct timespec rest = timespec_of(due(deadline) > now_ns ? due(deadline) - now_ns : 1);
        return left && !put(of, left, &rest, sizeof rest) ? -EFAULT : -EINTR;
    }
    return 0;
}

static int64_t sleep_span(struct tracee *of, uint64_t *a) {
    struct timespec span;
    if (!get(of, a[0], &span, sizeof span)) return -EFAULT;
    return is_span(&span) ? sleep_until(of, deadline_after(nanos(&span)), a[1]) : -EINVAL;
}

static int64_t sleep_by_clock(struct tracee *of, uint64_t *a) {
    struct timespec span;
    if (!get(of, a[2], &span, sizeof span)) return -EFAULT;
    if (!is_span(&span)) return -EINVAL;
    if (a[1] & TIMER_ABSTIME) return sleep_until(of, deadline_at((clockid_t)a[0], &span), 0);
    return sleep_until(of, deadline_after(nanos(&span)), a[3]);
}

const struct call calls_of_time[] = {
    {SYS_clock_gettime, ask_clock},
    {SYS_gettimeofday, ask_day},
    {SYS_time, ask_seconds},
    {SYS_times, ask_times},
    {SYS_nanosleep, sleep_span},
    {SYS_clock_nanosleep, sleep_by_clock},
    {0},
};
