// Threads and processes of the program. Each thread has a context in the tracer in which its calls are handled: a
// handler that has to wait passes the turn on, and continues at the thread's next turn.
#include "tracer.h"
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#define STACK_BYTES (256 * 1024)

__thread struct thread *self;
bool progressed, has_children;
struct process *processes;
int process_count;
static int first_pid, first_status;
static bool has_gone;
// Stacks of ended threads.
static void *stacks;

bool in_lockstep(void) { return true; }
void schedule_begin(void) {}
void schedule_after_fork(void) {}

const void *key_of(const struct process *process, uint64_t address) {
    return (const void *)(process->memory << 48 ^ address);
}

struct process *process_of(int pid) {
    for (struct process *process = processes; process; process = process->next)
        if (process->pid == pid) return process;
    return NULL;
}

struct tracee *tracee_of(int tid) {
    for (struct thread *thread = first; thread; thread = thread->next)
        if (((struct tracee *)thread)->tid == tid && !thread->finished) return (struct tracee *)thread;
    return NULL;
}

uint64_t memory_made(void) {
    static uint64_t memories;
    return ++memories;
}

struct process *process_begin(struct process *parent, int pid, bool shares_memory) {
    struct process *made = calloc(1, sizeof *made), **end = &processes;
    if (!made) fail("remember a process");
    made->pid = pid;
    made->pid_fd = (int)REAL(syscall)(SYS_pidfd_open, pid, 0);
    if (made->pid_fd < 0) fail("open a process");
    made->memory = shares_memory ? parent->memory : memory_made();
    made->parent = parent;
    if (parent) {
        made->scratch = parent->scratch;
        memcpy(made->actions, parent->actions, sizeof made->actions);
        slots_fork(parent, made);
    } else {
        first_pid = pid;
    }
    while (*end) end = &(*end)->next;
    *end = made;
    process_count++;
    return made;
}

struct tracee *thread_begin(struct process *process, int tid) {
    struct tracee *made = calloc(1, sizeof *made);
    struct thread **end = &first;
    if (!made) fail("remember a thread");
    made->process = process, made->tid = tid;
    made->thread.woken = true;
    made->thread.wait = (struct wait){.kind = WAIT_ADDRESS, .deadline = NEVER};
    made->stack = stacks;
    if (stacks) stacks = *(void **)stacks;
    else made->stack = mmap(NULL, STACK_BYTES, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (made->stack == MAP_FAILED) fail("make room for a thread");
    getcontext(&made->context);
    made->context.uc_stack = (stack_t){.ss_sp = made->stack, .ss_size = STACK_BYTES};
    makecontext(&made->context, live, 0);
    while (*end) end = &(*end)->next;
    *end = &made->thread;
    process->threads++;
    return made;
}

static void process_ended(struct process *process, int status) {
    if (process->has_ended) return;
    process->has_ended = true;
    process_count--;
    if (process->pid == first_pid) first_status = status;
    for (struct thread *thread = first; thread; thread = thread->next)
        if (((struct tracee *)thread)->process == process) thread->finished = true;
    slots_end(process);
    timers_of_program_end(process);
    REAL(close)(process->pid_fd);
    for (struct process *child = processes; child; child = child->next)
        if (child->parent == process) child->parent = NULL;
    // A parent that waits for the end of a child looks again.
    runs++;
    wake(process, UINT32_MAX, UINT32_MAX);
    if (process->parent) signal_sent(process->parent);
}

void thread_ended(struct tracee *of, int status) {
    struct process *process = of->process;
    if (of->thread.finished) return;
    of->thread.finished = has_gone = progressed = true;
    process->threads--;
    // The kernel has cleared the word.
    if (of->clear_tid) wake(key_of(process, of->clear_tid), 1, UINT32_MAX);
    // The end of the first thread is reported after that of the last.
    if (of->tid != process->pid && process->threads == 0 && !process->has_ended) {
        while (waitpid(process->pid, &status, __WALL) < 0 && errno == EINTR) {}
        process_ended(process, status);
    }
    if (of->tid == process->pid) process_ended(process, status);
}

// Frees everything that has ended, except the calling thread.
void sweep(void) {
    if (!has_gone) return;
    has_gone = false;
    for (struct thread **place = &first; *place;) {
        struct tracee *of = (struct tracee *)*place;
        if (!of->thread.finished || &of->thread == self) {
            place = &(*place)->next;
            continue;
        }
        *place = of->thread.next;
        *(void **)of->stack = stacks;
        stacks = of->stack;
        free(of);
    }
    for (struct process **place = &processes; *place;) {
        struct process *process = *place;
        if (process->has_ended) *place = process->next, free(process);
        else place = &process->next;
    }
}

bool has_handler(const struct thread *thread, int signal) {
    uint64_t handler = ((const struct tracee *)thread)->process->actions[signal].handler;
    return handler != (uint64_t)SIG_DFL && handler != (uint64_t)SIG_IGN;
}

// No thread escapes the tracer.
bool has_other_threads(void) { return false; }

pid_t process_id_of(const struct thread *thread) { return ((const struct tracee *)thread)->process->pid; }

uintptr_t address_of(const struct thread *thread) {
    return (uintptr_t)key_of(((const struct tracee *)thread)->process, (uint64_t)thread->wait.address);
}

static void ask_for_time(void) {
    run_to_deadline();
    signals_pass_on();
}

static struct tracee *await_next(void) {
    struct thread *next;
    while (!(next = next_thread())) ask_for_time();
    return (struct tracee *)next;
}

enum woken block(const struct wait *wait) {
    int kept = errno;
    struct tracee *of = present();
    self->wait = *wait;
    self->woken = false;
    self->questions = self->sendings = 0;
    self->run_seen = runs;
    self->order = ++orders;
    if (of->is_masked) self->signals = pending_of(of, of->mask);
    struct tracee *next = of;
    if (!first->next && (wait->kind == WAIT_FDS || wait->kind == WAIT_RUN)) {
        // The only thread polls by itself, and has just done so.
        if (due(wait->deadline) > now_ns && !self->signals) ask_for_time();
    } else {
        next = await_next();
    }
    if (next != of) {
        current = self = &next->thread;
        swapcontext(&of->context, &next->context);
        sweep();
    }
    errno = kept;
    self->wait.kind = WAIT_NOTHING;
    if (self->signals) {
        signals_taken(of);
        return INTERRUPTED;
    }
    if (self->woken) return WOKEN;
    return due(wait->deadline) <= now_ns ? TIMED_OUT : LOOK_AGAIN;
}

enum woken block_until(int64_t deadline) { return block(&(struct wait){.kind = WAIT_TIME, .deadline = deadline}); }

// The whole program has ended: the tracer ends like its first process.
static void end(void) {
    if (WIFSIGNALED(first_status)) {
        setrlimit(RLIMIT_CORE, &(struct rlimit){0});
        sigset_t none;
        sigemptyset(&none);
        signal(WTERMSIG(first_status), SIG_DFL);
        sigprocmask(SIG_SETMASK, &none, NULL);
        raise(WTERMSIG(first_status));
    }
    REAL(_exit)(WEXITSTATUS(first_status));
}

void leave(void) {
    bool any = false;
    for (struct thread *thread = first; thread; thread = thread->next) any |= !thread->finished;
    if (!any) end();
    struct tracee *next = await_next();
    current = self = &next->thread;
    setcontext(&next->context);
    __builtin_unreachable();
}
