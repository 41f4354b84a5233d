// One thread runs at a time. When it waits, the next ready thread in order of creation gets the turn; if none is ready,
// the harness is asked for the next time.
#include "shim.h"
#include <linux/futex.h>
#include <sys/stat.h>
#include <sys/syscall.h>

__thread struct thread *self __attribute__((tls_model("initial-exec")));
bool progressed, has_children;
static pthread_key_t exit_key;
static pthread_t leader;

static void thread_exits(void *thread);

// Really waits, unseen by our own `syscall`.
void futex_wait(int *word, int value) {
    REAL(syscall)(SYS_futex, word, FUTEX_WAIT_PRIVATE, value, NULL, NULL, 0);
}
void futex_wake(int *word) { REAL(syscall)(SYS_futex, word, FUTEX_WAKE_PRIVATE, 1, NULL, NULL, 0); }

// A signal handler that interrupts a message to the harness runs outside the lockstep.
bool in_lockstep(void) { return is_managed() && self && current == self && !link_is_busy; }

void schedule_begin(void) {
    pthread_key_create(&exit_key, thread_exits);
    first = current = self = calloc(1, sizeof *self);
    self->handle = leader = pthread_self();
    pthread_setspecific(exit_key, self);
}

// Only the forking thread lives on.
void schedule_after_fork(void) {
    first = current = self;
    leader = pthread_self();
    self->next = NULL;
    self->signals = 0;
}

// Whether a pending signal has a handler that runs under this mask, and how it ends a call.
static enum woken handled_now(const sigset_t *mask) {
    sigset_t pending;
    enum woken result = WOKEN;
    sigpending(&pending);
    for (int signal = 1; signal < 64; signal++) {
        struct sigaction action;
        if (!sigismember(&pending, signal) || sigismember(mask, signal) || sigaction(signal, NULL, &action)) continue;
        if (action.sa_handler == SIG_IGN || action.sa_handler == SIG_DFL) continue;
        if (!(action.sa_flags & SA_RESTART)) return INTERRUPTED;
        result = RESTART;
    }
    return result;
}

bool has_handler(const struct thread *thread, int signal) {
    struct sigaction action;
    (void)thread;
    return !sigaction(signal, NULL, &action) && action.sa_handler != SIG_IGN && action.sa_handler != SIG_DFL;
}

pid_t process_id_of(const struct thread *thread) { return (void)thread, getpid(); }
uintptr_t address_of(const struct thread *thread) { return (uintptr_t)thread->wait.address; }

// Whether there are threads outside of the schedule, as the C library makes for asynchronous input and output.
bool has_other_threads(void) {
    static bool has;
    nlink_t known = 2;
    bool leads = false;
    for (struct thread *thread = first; thread; thread = thread->next) {
        known += !thread->finished;
        leads |= !thread->finished && pthread_equal(thread->handle, leader);
    }
    // The first thread of a process remains until the last has ended.
    known += !leads;
    // A thread that is ending asks for those that are left.
    known += self->finished && !pthread_equal(self->handle, leader);
    // A thread that has ended needs some time to disappear.
    for (int tries = 0; !has && tries < 1000; tries++) {
        struct stat folder;
        if (!stat("/proc/self/task", &folder) && folder.st_nlink <= known) return false;
        REAL(usleep)(1000);
    }
    return has = true;
}

static void ask_for_time(void) {
    sigset_t before;
    bool holds = has_children;
    // The end of a child is a signal at a random real time. It is deferred to this place.
    if (holds) {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before);
    }
    run_to_deadline();
    if (holds) {
        self->handled = handled_now(&before);
        pthread_sigmask(SIG_SETMASK, &before, NULL);
    }
}

static void hand_over(struct thread *to) {
    current = to;
    __atomic_store_n(&to->go, 1, __ATOMIC_SEQ_CST);
    futex_wake(&to->go);
}

static void await_turn(void) {
    while (!__atomic_exchange_n(&self->go, 0, __ATOMIC_SEQ_CST)) futex_wait(&self->go, 0);
}

// A thread raises due signals itself where it waits: the same place in every run.
static enum woken raise_signals(void) {
    enum woken result = RESTART;
    uint64_t due = self->signals;
    self->signals = 0;
    for (int signal = 1; signal < 64; signal++) {
        if (!(due >> signal & 1)) continue;
        sigset_t blocked;
        struct sigaction action;
        pthread_sigmask(SIG_SETMASK, NULL, &blocked);
        bool is_blocked = sigismember(&blocked, signal);
        if (!sigaction(signal, NULL, &action) && !(action.sa_flags & SA_RESTART) && !is_blocked)
            result = INTERRUPTED;
        // A blocked signal may be taken by `sigwait` in another thread, or by a signalfd.
        if (is_blocked) kill(getpid(), signal);
        else raise(signal);
    }
    return result;
}

enum woken block(const struct wait *wait) {
    int kept = errno;
    self->wait = *wait;
    self->woken = false;
    self->questions = self->sendings = 0;
    self->run_seen = runs;
    self->order = ++orders;
    bool is_alone = !first->next;
    if (is_alone && (wait->kind == WAIT_FDS || wait->kind == WAIT_RUN)) {
        // The only thread polls by itself, and has just done so.
        if (due(wait->deadline) > now_ns) ask_for_time();
    } else {
        struct thread *next;
        while (!(next = next_thread())) ask_for_time();
        if (next != self) {
            hand_over(next);
            await_turn();
        }
    }
    self->wait.kind = WAIT_NOTHING;
    bool looks = wait->kind == WAIT_FDS || wait->kind == WAIT_RUN;
    if (!looks) progressed = true;
    errno = kept;
    if (self->signals) {
        progressed = true;
        enum woken result = raise_signals();
        errno = kept;
        return result;
    }
    if (self->handled) {
        progressed = true;
        enum woken result = self->handled;
        self->handled = WOKEN;
        return result;
    }
    if (self->woken) return WOKEN;
    return due(wait->deadline) <= now_ns ? TIMED_OUT : LOOK_AGAIN;
}

enum woken block_until(int64_t deadline) {
    return block(&(struct wait){.kind = WAIT_TIME, .deadline = deadline});
}

void schedule_signal(int signal) {
    struct thread *thread = first;
    struct sigaction action;
    if (!sigaction(signal, NULL, &action) && action.sa_handler == SIG_IGN) return;
    while (thread->finished && thread->next) thread = thread->next;
    if (signal > 0 && signal < 64) thread->signals |= 1ULL << signal;
}

struct thread *thread_made(void *(*body)(void *), void *argument) {
    struct thread *thread = calloc(1, sizeof *thread), *last = first;
    if (!thread) return NULL;
    thread->body = body, thread->argument = argument;
    thread->woken = true;
    thread->wait = (struct wait){.kind = WAIT_ADDRESS, .deadline = NEVER};
    while (last->next) last = last->next;
    return last->next = thread;
}

// The system failed to create the thread.
void thread_unmade(struct thread *thread) { thread_forget(thread); }

void *thread_entry(void *made) {
    self = made;
    self->handle = pthread_self();
    pthread_setspecific(exit_key, self);
    await_turn();
    self->wait.kind = WAIT_NOTHING;
    self->woken = false;
    progressed = true;
    return self->body(self->argument);
}

// Runs after the program's own destructors of thread-local data: it asks to be called again until the last round.
static void thread_exits(void *thread) {
    struct thread *ending = thread;
    if (++ending->destructor_rounds < PTHREAD_DESTRUCTOR_ITERATIONS) {
        pthread_setspecific(exit_key, ending);
        return;
    }
    if (!in_lockstep()) return;
    ending->finished = true;
    progressed = true;
    wake(ending, UINT32_MAX, UINT32_MAX);
    struct thread *next;
    bool any = false;
    for (struct thread *other = first; other; other = other->next) any |= !other->finished;
    if (!any) return;
    while (!(next = next_thread())) ask_for_time();
    self = NULL;
    current = next;
    if (ending->detached) thread_forget(ending);
    hand_over(next);
}

struct thread *thread_of(pthread_t handle) {
    for (struct thread *thread = first; thread; thread = thread->next)
        if (pthread_equal(thread->handle, handle)) return thread;
    return NULL;
}

// The current thread stays in the list while it runs.
void thread_forget(struct thread *thread) {
    for (struct thread **place = &first; *place; place = &(*place)->next) {
        if (*place != thread) continue;
        *place = thread->next;
        free(thread);
        return;
    }
}
