// Timers of the program and cyclic frames. They are checked whenever time moves.
#include "shim.h"

static struct virtual_timer *timers;

void timer_add(struct virtual_timer *timer) {
    struct virtual_timer **end = &timers;
    while (*end) end = &(*end)->next;
    timer->next = NULL;
    timer->deadline = NEVER;
    *end = timer;
}

void timer_remove(struct virtual_timer *timer) {
    for (struct virtual_timer **place = &timers; *place; place = &(*place)->next) {
        if (*place != timer) continue;
        *place = timer->next;
        return;
    }
}

void timer_set(struct virtual_timer *timer, int64_t deadline, int64_t interval) {
    timer->deadline = deadline;
    timer->interval = interval;
}

// The earliest timer; of two at the same time the older one.
static struct virtual_timer *earliest(void) {
    struct virtual_timer *found = timers;
    for (struct virtual_timer *timer = timers; timer; timer = timer->next)
        if (due(timer->deadline) < due(found->deadline)) found = timer;
    return found;
}

int64_t timers_next(void) { return timers ? due(earliest()->deadline) : NEVER; }

void timers_run(void) {
    struct virtual_timer *timer;
    while (timers && due((timer = earliest())->deadline) <= now_ns) {
        uint64_t count = 1;
        if (timer->interval > 0) {
            count += (uint64_t)((now_ns - due(timer->deadline)) / timer->interval);
            timer->deadline += (int64_t)count * timer->interval;
        } else {
            timer->deadline = NEVER;
        }
        timer->fire(timer, count);
    }
}

struct itimerspec timer_state(const struct virtual_timer *timer) {
    bool is_set = timer->fire && timer->deadline != NEVER;
    return (struct itimerspec){.it_value = timespec_of(is_set ? due(timer->deadline) - now_ns : 0),
                               .it_interval = timespec_of(timer->interval)};
}

void timer_arm(struct virtual_timer *timer, clockid_t clock, bool is_absolute, const struct itimerspec *to) {
    int64_t span = nanos(&to->it_value);
    int64_t deadline = is_absolute ? deadline_at(clock, &to->it_value) : deadline_after(span);
    timer_set(timer, span == 0 ? NEVER : deadline, nanos(&to->it_interval));
    timers_run();
}

static void fire_fd(struct virtual_timer *timer, uint64_t count) {
    REAL(write)(((struct timer_fd *)timer)->fd, &count, sizeof count);
}

struct timer_fd *timer_fd_made(int fd, clockid_t clock) {
    struct timer_fd *made = calloc(1, sizeof *made);
    *made = (struct timer_fd){.timer.fire = fire_fd, .fd = fd, .clock = clock};
    timer_add(&made->timer);
    return made;
}

void timer_fd_release(struct timer_fd *of) {
    if (--of->users > 0) return;
    timer_remove(&of->timer);
    unguard(of->fd);
    free(of);
}

void timer_fd_set(struct timer_fd *of, bool is_absolute, const struct itimerspec *to) {
    uint64_t old;
    if (is_ready(of->fd, POLLIN)) REAL(read)(of->fd, &old, sizeof old);
    timer_arm(&of->timer, of->clock, is_absolute, to);
}

// A child does not inherit timers, and cyclic frames of its descriptors belong to the parent.
void timers_after_fork(void) { timers = NULL; }
