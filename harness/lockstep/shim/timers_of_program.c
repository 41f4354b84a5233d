// timerfd, timer_create, setitimer, alarm.
#include "shim.h"
#include <sys/eventfd.h>
#include <sys/timerfd.h>

EXPORT int timerfd_create(int clock, int flags) {
    if (!is_managed()) return REAL(timerfd_create)(clock, flags);
    int own = ((flags & TFD_NONBLOCK) ? EFD_NONBLOCK : 0) | ((flags & TFD_CLOEXEC) ? EFD_CLOEXEC : 0);
    int fd = eventfd(0, own);
    if (fd < 0) return fd;
    // Our own copy: the program may close its descriptor and keep a duplicate.
    descriptor_set(fd, FD_TIMER, timer_fd_made(guard(REAL(fcntl)(fd, F_DUPFD_CLOEXEC, 3)), clock));
    return fd;
}

EXPORT int timerfd_settime(int fd, int flags, const struct itimerspec *to, struct itimerspec *before) {
    struct descriptor *found = descriptor(fd);
    if (!found || found->kind != FD_TIMER) return REAL(timerfd_settime)(fd, flags, to, before);
    struct timer_fd *of = found->object;
    if (before) *before = timer_state(&of->timer);
    timer_fd_set(of, flags & TFD_TIMER_ABSTIME, to);
    return 0;
}

EXPORT int timerfd_gettime(int fd, struct itimerspec *state) {
    struct descriptor *found = descriptor(fd);
    if (!found || found->kind != FD_TIMER) return REAL(timerfd_gettime)(fd, state);
    *state = timer_state(&((struct timer_fd *)found->object)->timer);
    return 0;
}

// Timers with signals, by number: a program's `timer_t` is the number plus one.
#define TIMERS_MAX 64
static struct signal_timer {
    struct virtual_timer timer;
    bool is_used;
    int signal, overrun;
    clockid_t clock;
} signal_timers[TIMERS_MAX], alarm_timer = {.signal = SIGALRM};

static void fire_signal(struct virtual_timer *timer, uint64_t count) {
    struct signal_timer *of = (struct signal_timer *)timer;
    of->overrun = (int)(count - 1);
    if (of->signal) schedule_signal(of->signal);
}

static struct signal_timer *by_number(timer_t number) {
    uintptr_t index = (uintptr_t)number;
    return index >= 1 && index <= TIMERS_MAX && signal_timers[index - 1].is_used ? &signal_timers[index - 1] : NULL;
}

EXPORT int timer_create(clockid_t clock, struct sigevent *event, timer_t *made) {
    if (!is_managed()) return REAL(timer_create)(clock, event, made);
    int how = event ? event->sigev_notify : SIGEV_SIGNAL;
    if (how == SIGEV_THREAD) return errno = ENOTSUP, -1;
    for (uintptr_t i = 0; i < TIMERS_MAX; i++) {
        struct signal_timer *of = &signal_timers[i];
        if (of->is_used) continue;
        int signal = how == SIGEV_NONE ? 0 : event ? event->sigev_signo : SIGALRM;
        *of = (struct signal_timer){.is_used = true, .signal = signal, .clock = clock};
        of->timer.fire = fire_signal;
        timer_add(&of->timer);
        *made = (timer_t)(i + 1);
        return 0;
    }
    return errno = EAGAIN, -1;
}

EXPORT int timer_delete(timer_t number) {
    if (!is_managed()) return REAL(timer_delete)(number);
    struct signal_timer *of = by_number(number);
    if (!of) return errno = EINVAL, -1;
    timer_remove(&of->timer);
    of->is_used = false;
    return 0;
}

EXPORT int timer_settime(timer_t number, int flags, const struct itimerspec *to, struct itimerspec *before) {
    if (!is_managed()) return REAL(timer_settime)(number, flags, to, before);
    struct signal_timer *of = by_number(number);
    if (!of || !to) return errno = EINVAL, -1;
    if (before) *before = timer_state(&of->timer);
    timer_arm(&of->timer, of->clock, flags & TIMER_ABSTIME, to);
    return 0;
}

EXPORT int timer_gettime(timer_t number, struct itimerspec *state) {
    if (!is_managed()) return REAL(timer_gettime)(number, state);
    struct signal_timer *of = by_number(number);
    if (!of) return errno = EINVAL, -1;
    *state = timer_state(&of->timer);
    return 0;
}

EXPORT int timer_getoverrun(timer_t number) {
    if (!is_managed()) return REAL(timer_getoverrun)(number);
    struct signal_timer *of = by_number(number);
    return of ? of->overrun : (errno = EINVAL, -1);
}

// The real-time timer and both processor-time timers are the same here: a program takes no processor time.
EXPORT int setitimer(__itimer_which_t which, const struct itimerval *restrict to, struct itimerval *restrict before) {
    if (!is_managed()) return REAL(setitimer)(which, to, before);
    if (which != ITIMER_REAL) return 0;
    struct virtual_timer *timer = &alarm_timer.timer;
    if (!timer->fire) timer->fire = fire_signal, timer_add(timer);
    struct itimerspec old = timer_state(timer);
    if (before) {
        before->it_value = timeval_of(nanos(&old.it_value));
        before->it_interval = timeval_of(nanos(&old.it_interval));
    }
    if (!to) return 0;
    int64_t span = to->it_value.tv_sec * SECOND + to->it_value.tv_usec * 1000;
    int64_t interval = to->it_interval.tv_sec * SECOND + to->it_interval.tv_usec * 1000;
    timer_set(timer, span ? deadline_after(span) : NEVER, interval);
    return 0;
}

EXPORT unsigned alarm(unsigned seconds) {
    if (!is_managed()) return REAL(alarm)(seconds);
    struct itimerval to = {.it_value.tv_sec = seconds}, before = {0};
    setitimer(ITIMER_REAL, &to, &before);
    return (unsigned)before.it_value.tv_sec + (before.it_value.tv_usec > 0);
}

EXPORT useconds_t ualarm(useconds_t span, useconds_t interval) {
    if (!is_managed()) return REAL(ualarm)(span, interval);
    struct itimerval before = {0}, to = {.it_value = timeval_of(span * 1000LL),
                                         .it_interval = timeval_of(interval * 1000LL)};
    setitimer(ITIMER_REAL, &to, &before);
    return (useconds_t)(before.it_value.tv_sec * 1000000 + before.it_value.tv_usec);
}
