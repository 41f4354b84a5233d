// Signals of the program. The kernel keeps and delivers them; here a waiting thread is told that one has come for it,
// at a time that is the same in every run.
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

// Signals pending for a thread alone, and for any thread of its process.
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

// Pending signals of a thread that a mask does not block.
uint64_t pending_of(struct tracee *of, uint64_t mask) {
    uint64_t own, shared;
    read_pending(of, &own, &shared);
    return that_matter(of->process, (own | shared) & ~mask);
}

// Signals have been sent to a process: the waiting thread that is to handle them goes on. A signal to the process is
// for the first thread that does not block it.
void signal_sent(struct process *process) {
    uint64_t given = 0;
    // Threads that take signals by a call look again.
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

// Sends a signal of a timer or of the harness to the first thread that does not block it.
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

// The harness sends a signal to the eldest process.
void schedule_signal(int signal) {
    struct process *eldest = processes;
    while (eldest && eldest->has_ended) eldest = eldest->next;
    if (eldest) signal_process(eldest, signal);
}

// Signals that others have sent to the tracer are meant for the program.
void signals_pass_on(void) {
    sigset_t all;
    int signal;
    sigfillset(&all);
    sigdelset(&all, SIGCHLD);
    while ((signal = sigtimedwait(&all, NULL, &(struct timespec){0})) > 0) schedule_signal(signal);
}

// Ends the wait for signals whose handlers run when the thread goes on.
void signals_taken(struct tracee *of) {
    of->restarts = true;
    for (int signal = 1; signal < SIGNALS; signal++) {
        const struct action *action = &of->process->actions[signal];
        if ((of->thread.signals & bit(signal)) && !(action->flags & RESTARTS)) of->restarts = false;
    }
    of->thread.signals = 0;
}
