// The order of turns: threads in order of creation, what they wait for, and which of those that wait at an address is
// woken first.
#include "shim.h"

struct thread *first, *current;
uint64_t orders;
unsigned runs;

static bool can_go_on(struct thread *thread) {
    const struct wait *wait = &thread->wait;
    if (thread->finished) return false;
    if (thread->woken || thread->signals || thread->handled || due(wait->deadline) <= now_ns) return true;
    int value = 0;
    switch (wait->kind) {
    case WAIT_FDS: return REAL(poll)(wait->fds, wait->count, 0) != 0;
    case WAIT_SEMAPHORE: return sem_getvalue((sem_t *)wait->address, &value) || value > 0;
    case WAIT_RUN: return thread->run_seen != runs;
    default: return false;
    }
}

// The next thread: after the current one, which itself comes last.
struct thread *next_thread(void) {
    struct thread *thread = current;
    do {
        thread = thread->next ? thread->next : first;
        if (can_go_on(thread)) return thread;
    } while (thread != current);
    return NULL;
}

static struct thread *longest_waiting(const void *address, uint32_t bitset) {
    struct thread *found = NULL;
    for (struct thread *thread = first; thread; thread = thread->next) {
        const struct wait *wait = &thread->wait;
        bool is_waiting = !thread->finished && !thread->woken && wait->kind == WAIT_ADDRESS
            && wait->address == address && (wait->bitset & bitset);
        if (is_waiting && (!found || thread->order < found->order)) found = thread;
    }
    return found;
}

// Wakes up to `count` threads that wait at an address, the longest waiting first.
unsigned wake(const void *address, unsigned count, uint32_t bitset) {
    unsigned woken = 0;
    struct thread *thread;
    while (woken < count && (thread = longest_waiting(address, bitset))) thread->woken = true, woken++;
    return woken;
}

unsigned requeue(const void *from, const void *to, unsigned count) {
    unsigned moved = 0;
    struct thread *thread;
    while (from != to && moved < count && (thread = longest_waiting(from, UINT32_MAX)))
        thread->wait.address = to, moved++;
    return moved;
}

void run_to_deadline(void) {
    int64_t deadline = NEVER;
    for (struct thread *thread = first; thread; thread = thread->next)
        if (!thread->finished && due(thread->wait.deadline) < deadline) deadline = due(thread->wait.deadline);
    unsigned threads;
    bool stuck = is_stuck(&threads);
    link_run(deadline, stuck, threads);
    runs++;
}

void give_way(void) {
    if (!in_lockstep()) return;
    self->wait.deadline = INT64_MIN;
    struct thread *next = next_thread();
    if (!next || next == self) return;
    block_until(now_ns);
}

// A query without waiting. Endless queries would stop time, so after a number of them it moves.
void question(void) {
    if (!in_lockstep() || ++self->questions <= spin_questions) return;
    unsigned kept = self->questions;
    block_until(deadline_after(spin_step_ns));
    self->questions = kept;
}

// A send without waiting, counted separately: an endless sender finds no line that takes everything at once.
void sending(void) {
    if (!in_lockstep() || ++self->sendings <= spin_questions) return;
    unsigned kept = self->sendings;
    block_until(deadline_after(spin_step_ns));
    self->sendings = kept;
}
