// Signals of the program. The kernel keeps and delivers them; who waits is told here that one has come for it, at a moment
// that is the same in every run.
#include "tracer.h"
#include <stdio.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>

#define RESTARTS 0x10000000

static uint64_t bit(int signal) { return 1ULL << (signal - 1); }

static bool is_ignored(const struct process *process, int signal) {
    uint64_t handler = process->actions[signal].handler;
    bool is_harmless = signal == SIGCHLD || signal == SIGURG || signal == SIGWINCH || signal == SIGCONT;
    return handler == (uint64_t)SIG_IGN || (handler == (uint64_t)SIG_DFL && is_harmless);
}

static uint64_t mask_of(struct tracee *of) {
    uint64_t mask = of->mask;
    if (of->is_masked) return mask;
    if (of->is_shielded) return of->shielded;
    return ptrace(PTRACE_GETSIGMASK, of->tid, KERNEL_SIGSET_BYTES, &mask) ? 0 : mask;
}

// What has been sent to a thread alone, and to any thread of its process.
static void read_pending(const struct tracee *of, uint64_t *own, uint64_t *shared) {
    char path[64], text[4096];
    *own = *shared = 0;
    snprintf(path, sizeof path, "/proc/%d/status", of->tid);
    int fd = REAL(openat)(AT_FDCWD, path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return;
    ssize_t size = REAL(read)(fd, text, sizeof text - 1);
    REAL(close)(fd);
    text[size > 0 ? size : 0] = 0;
    const char *line = strstr(text, "\nSigPnd:");
    if (line) *own = strtoull(line + 8, NULL, 16);
    if ((line = strstr(text, "\nShdPnd:"))) *shared = strtoull(line + 8, NULL, 16);
}

static uint64_t that_matter(const struct process *process, uint64_t set) {
    for (int signal = 1; set && signal < SIGNALS; signal++)
        if ((set & bit(signal)) && is_ignored(process, signal)) set &= ~bit(signal);
    return set;
}

// Those that wait for a thread and are not held back by a mask.
uint64_t pending_of(struct tracee *of, uint64_t mask) {
    uint64_t own, shared;
    read_pending(of, &own, &shared);
    return that_matter(of->process, (own | shared) & ~mask);
}

// Something has been sent to a process: of its threads that wait, who is to handle it goes on. What was sent to the
// process is for the first that does not hold it back.
void signal_sent(struct process *process) {
    uint64_t given = 0;
    // Who takes signals by asking for them looks again.
    runs++;
    for (struct thread *thread = first; thread; thread = thread->next) {
        struct tracee *of = (struct tracee *)thread;
        if (of->process != process || thread->finished || thread->wait.kind == WAIT_NOTHING) continue;
        uint64_t own, shared;
        read_pending(of, &own, &shared);
        uint64_t due = that_matter(process, (own | (shared & ~given)) & ~mask_of(of));
        given |= due & shared;
        thread->signals |= due;
    }
}

// From a timer or the harness, to the first thread that does not hold it back.
void signal_process(struct process *process, int signal) {
    int to = 0;
    for (struct thread *thread = first; thread && !to; thread = thread->next) {
        struct tracee *of = (struct tracee *)thread;
        if (of->process == process && !thread->finished && !(mask_of(of) & bit(signal))) to = of->tid;
    }
    if (to) REAL(syscall)(SYS_tgkill, process->pid, to, signal);
    else kill(process->pid, signal);
    signal_sent(process);
}

// The harness has something to say to the eldest process.
void schedule_signal(int signal) {
    struct process *eldest = processes;
    while (eldest && eldest->has_ended) eldest = eldest->next;
    if (eldest) signal_process(eldest, signal);
}

// What others have sent to the tracer is meant for the program.
void signals_pass_on(void) {
    sigset_t all;
    int signal;
    sigfillset(&all);
    sigdelset(&all, SIGCHLD);
    while ((signal = sigtimedwait(&all, NULL, &(struct timespec){0})) > 0) schedule_signal(signal);
}

// The wait is over for these, whose handlers run when the thread goes on.
void signals_taken(struct tracee *of) {
    of->restarts = true;
    for (int signal = 1; signal < SIGNALS; signal++) {
        const struct action *action = &of->process->actions[signal];
        if ((of->thread.signals & bit(signal)) && !(action->flags & RESTARTS)) of->restarts = false;
    }
    of->thread.signals = 0;
}
