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

// A child does not inherit timers, and cyclic frames of its descriptors belong to the parent.
void timers_after_fork(void) { timers = NULL; }
