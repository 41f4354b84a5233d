// timerfd, timer_create, setitimer, alarm. The eventfd of a timerfd is the program's.
#include "tracer.h"
#include <sys/syscall.h>
#include <sys/timerfd.h>

struct signal_timer {
    struct virtual_timer timer;
    struct signal_timer *next;
    struct process *process;
    int number, signal, thread, overrun;
    uint64_t value;
    clockid_t clock;
};

static int64_t make_fd(struct tracee *of, uint64_t *a) {
    if (a[1] & ~(uint64_t)(TFD_NONBLOCK | TFD_CLOEXEC)) return -EINVAL;
    // The flags of both have the same values.
    int64_t fd = CALL(of, SYS_eventfd2, 0, a[1]);
    int copy = fd < 0 ? -1 : slot_take(of, (int)fd);
    if (copy < 0) return fd < 0 ? fd : -EMFILE;
    descriptor_set(copy, FD_TIMER, timer_fd_made(REAL(fcntl)(copy, F_DUPFD_CLOEXEC, 3), (clockid_t)a[0]));
    return fd;
}

static struct timer_fd *by_fd(struct tracee *of, uint64_t fd) {
    struct descriptor *found = object_of(of, (int)fd);
    return found && found->kind == FD_TIMER ? found->object : NULL;
}

static int64_t set_fd(struct tracee *of, uint64_t *a) {
    struct timer_fd *timer = by_fd(of, a[0]);
    struct itimerspec to, before;
    if (!timer) return -EINVAL;
    if (!get(of, a[2], &to, sizeof to)) return -EFAULT;
    before = timer_state(&timer->timer);
    timer_fd_set(timer, a[1] & TFD_TIMER_ABSTIME, &to);
    return a[3] && !put(of, a[3], &before, sizeof before) ? -EFAULT : 0;
}

static int64_t ask_fd(struct tracee *of, uint64_t *a) {
    struct timer_fd *timer = by_fd(of, a[0]);
    if (!timer) return -EINVAL;
    struct itimerspec state = timer_state(&timer->timer);
    return put(of, a[1], &state, sizeof state) ? 0 : -EFAULT;
}

static void fire_signal(struct virtual_timer *timer, uint64_t count) {
    struct signal_timer *of = (struct signal_timer *)timer;
    of->overrun = (int)(count - 1);
    if (!of->signal) return;
    siginfo_t info = {.si_signo = of->signal, .si_code = SI_TIMER};
    info.si_timerid = of->number, info.si_overrun = of->overrun;
    info.si_value.sival_ptr = (void *)of->value;
    int pid = of->process->pid;
    if (of->thread) REAL(syscall)(SYS_rt_tgsigqueueinfo, pid, of->thread, of->signal, &info);
    else REAL(syscall)(SYS_rt_sigqueueinfo, pid, of->signal, &info);
    signal_sent(of->process);
}

static struct signal_timer *by_number(struct tracee *of, uint64_t number) {
    for (struct signal_timer *timer = of->process->timers; timer; timer = timer->next)
        if (timer->number == (int)number) return timer;
    return NULL;
}

static int64_t make(struct tracee *of, uint64_t *a) {
    // The kernel's layout: a value, a signal, the kind of notification, and its target.
    struct {
        uint64_t value;
        int signal, how, thread;
    } event = {.signal = SIGALRM, .how = SIGEV_SIGNAL};
    if (a[1] && !get(of, a[1], &event, sizeof event)) return -EFAULT;
    static int numbers;
    int number = numbers++;
    if (!put(of, a[2], &number, sizeof number)) return -EFAULT;
    struct signal_timer *made = calloc(1, sizeof *made);
    if (!made) return -EAGAIN;
    made->number = number, made->clock = (clockid_t)a[0], made->process = of->process;
    made->signal = event.how == SIGEV_NONE ? 0 : event.signal;
    made->thread = event.how == SIGEV_THREAD_ID ? event.thread : 0;
    made->value = a[1] ? event.value : (uint64_t)number;
    made->timer.fire = fire_signal;
    timer_add(&made->timer);
    made->next = of->process->timers;
    of->process->timers = made;
    return 0;
}

static int64_t set(struct tracee *of, uint64_t *a) {
    struct signal_timer *timer = by_number(of, a[0]);
    struct itimerspec to, before;
    if (!timer) return -EINVAL;
    if (!get(of, a[2], &to, sizeof to)) return -EFAULT;
    before = timer_state(&timer->timer);
    timer_arm(&timer->timer, timer->clock, a[1] & TIMER_ABSTIME, &to);
    return a[3] && !put(of, a[3], &before, sizeof before) ? -EFAULT : 0;
}

static int64_t ask(struct tracee *of, uint64_t *a) {
    struct signal_timer *timer = by_number(of, a[0]);
    if (!timer) return -EINVAL;
    struct itimerspec state = timer_state(&timer->timer);
    return put(of, a[1], &state, sizeof state) ? 0 : -EFAULT;
}

static int64_t ask_overrun(struct tracee *of, uint64_t *a) {
    struct signal_timer *timer = by_number(of, a[0]);
    return timer ? timer->overrun : -EINVAL;
}

static void forget(struct signal_timer *timer) {
    struct signal_timer **place = &timer->process->timers;
    while (*place != timer) place = &(*place)->next;
    *place = timer->next;
    timer_remove(&timer->timer);
    free(timer);
}

static int64_t delete(struct tracee *of, uint64_t *a) {
    struct signal_timer *timer = by_number(of, a[0]);
    if (timer) forget(timer);
    return timer ? 0 : -EINVAL;
}

static void fire_alarm(struct virtual_timer *timer, uint64_t count) {
    (void)count;
    signal_process((struct process *)((char *)timer - offsetof(struct process, alarm)), SIGALRM);
}

static struct itimerval set_alarm(struct process *process, int64_t span, int64_t interval) {
    struct virtual_timer *timer = &process->alarm;
    struct itimerspec was = timer_state(timer);
    if (!timer->fire) timer->fire = fire_alarm, timer_add(timer);
    timer_set(timer, span ? deadline_after(span) : NEVER, interval);
    return (struct itimerval){.it_value = timeval_of(nanos(&was.it_value)),
                              .it_interval = timeval_of(nanos(&was.it_interval))};
}

// A program takes no processor time, so timers of processor time never fire.
static int64_t set_interval(struct tracee *of, uint64_t *a) {
    struct itimerval to = {0}, before = {0};
    if (a[1] && !get(of, a[1], &to, sizeof to)) return -EFAULT;
    if (a[0] == ITIMER_REAL)
        before = set_alarm(of->process, to.it_value.tv_sec * SECOND + to.it_value.tv_usec * 1000,
                           to.it_interval.tv_sec * SECOND + to.it_interval.tv_usec * 1000);
    return a[2] && !put(of, a[2], &before, sizeof before) ? -EFAULT : 0;
}

static int64_t ask_interval(struct tracee *of, uint64_t *a) {
    struct itimerspec is = a[0] == ITIMER_REAL ? timer_state(&of->process->alarm) : (struct itimerspec){0};
    struct itimerval state = {.it_value = timeval_of(nanos(&is.it_value)),
                              .it_interval = timeval_of(nanos(&is.it_interval))};
    return put(of, a[1], &state, sizeof state) ? 0 : -EFAULT;
}

static int64_t set_seconds(struct tracee *of, uint64_t *a) {
    struct itimerval before = set_alarm(of->process, (unsigned)a[0] * SECOND, 0);
    return before.it_value.tv_sec + (before.it_value.tv_usec > 0);
}

void timers_of_program_end(struct process *process) {
    while (process->timers) forget(process->timers);
    if (process->alarm.fire) timer_remove(&process->alarm);
}

const struct call calls_of_timers[] = {
    {SYS_timerfd_create, make_fd}, {SYS_timerfd_settime, set_fd},
    {SYS_timerfd_gettime, ask_fd}, {SYS_timer_create, make},
    {SYS_timer_settime, set},      {SYS_timer_gettime, ask},
    {SYS_timer_getoverrun, ask_overrun}, {SYS_timer_delete, delete},
    {SYS_setitimer, set_interval}, {SYS_getitimer, ask_interval},
    {SYS_alarm, set_seconds},      {0},
};
