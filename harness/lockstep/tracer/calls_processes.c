// Threads and processes: created, ended, awaited, signalled; and random numbers, made the same in each run.
#include "tracer.h"
#include <sched.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>

static int64_t make(struct tracee *of, uint64_t flags, uint64_t clear_tid) {
    of->clone_flags = flags;
    of->clone_clears = flags & CLONE_CHILD_CLEARTID ? clear_tid : 0;
    if (flags & CLONE_THREAD) return LET_GO;
    // The harness knows only this process.
    return link_request(REQUEST_FORK, process_count - 1) ? LET_GO : -EAGAIN;
}

static int64_t make_clone(struct tracee *of, uint64_t *a) {
    // An untraced process would be outside virtual time.
    return a[0] & CLONE_UNTRACED ? -EPERM : make(of, a[0], a[3]);
}

static int64_t make_clone_how(struct tracee *of, uint64_t *a) {
    // Flags, the address for the process id, and the word that is cleared.
    uint64_t how[3];
    if (a[1] < sizeof how || !get(of, a[0], how, sizeof how)) return -EINVAL;
    return how[0] & CLONE_UNTRACED ? -EPERM : make(of, how[0], how[2]);
}

static int64_t make_fork(struct tracee *of, uint64_t *a) {
    (void)a;
    return make(of, 0, 0);
}

static int64_t make_vfork(struct tracee *of, uint64_t *a) {
    (void)a;
    return make(of, CLONE_VFORK | CLONE_VM, 0);
}

static int64_t name_word(struct tracee *of, uint64_t *a) {
    of->clear_tid = a[0];
    return LET_GO;
}

// The end of a process's first thread is reported after all others: it is not awaited here.
static int64_t end_thread(struct tracee *of, uint64_t *a) {
    (void)a;
    if (of->tid != of->process->pid || of->process->threads < 2) return LET_GO;
    uint32_t zero = 0;
    if (of->clear_tid && put(of, of->clear_tid, &zero, sizeof zero))
        wake(key_of(of->process, of->clear_tid), 1, UINT32_MAX);
    of->thread.finished = true;
    of->process->threads--;
    ptrace(PTRACE_CONT, of->tid, 0, 0);
    leave();
}

static int64_t end_process(struct tracee *of, uint64_t *a) {
    (void)a;
    of->process->is_ending = true;
    return LET_GO;
}

static int64_t wait_child(struct tracee *of, uint64_t *a) {
    for (;;) {
        int64_t result = CALL(of, SYS_wait4, a[0], a[1], a[2] | WNOHANG, a[3]);
        if (result == 0 && (a[2] & WNOHANG)) question();
        if (result != 0 || (a[2] & WNOHANG)) return result;
        if (block(&(struct wait){.kind = WAIT_RUN, .giver = CHILD, .deadline = NEVER}) == INTERRUPTED) return restarted(of, -EINTR);
    }
}

static int64_t wait_one(struct tracee *of, uint64_t *a) {
    uint64_t info = a[2] ? a[2] : of->process->scratch;
    for (;;) {
        siginfo_t found = {0};
        if (!put(of, info, &found, sizeof found)) return -EFAULT;
        int64_t result = CALL(of, SYS_waitid, a[0], a[1], info, a[3] | WNOHANG, a[4]);
        get(of, info, &found, sizeof found);
        if (result == 0 && !found.si_pid && (a[3] & WNOHANG)) question();
        if (result || found.si_pid || (a[3] & WNOHANG)) return result;
        if (block(&(struct wait){.kind = WAIT_RUN, .giver = CHILD, .deadline = NEVER}) == INTERRUPTED) return restarted(of, -EINTR);
    }
}

static int64_t sent(int64_t result, int64_t pid, int signal) {
    if (result < 0 || signal == 0) return result;
    for (struct process *process = processes, *next; process; process = next) {
        next = process->next;
        if (process->has_ended || (pid > 0 && process->pid != pid)) continue;
        if (pid > 0 && signal == SIGKILL) await_end(process);
        else signal_sent(process);
    }
    return result;
}

static int64_t signal_other(struct tracee *of, uint64_t *a) {
    return sent(CALL(of, SYS_kill, a[0], a[1]), (int)a[0], (int)a[1]);
}

static int64_t signal_thread(struct tracee *of, uint64_t *a) {
    struct tracee *to = tracee_of((int)a[0]);
    return sent(CALL(of, SYS_tkill, a[0], a[1]), to ? to->process->pid : 0, (int)a[1]);
}

static int64_t signal_thread_of(struct tracee *of, uint64_t *a) {
    return sent(CALL(of, SYS_tgkill, a[0], a[1], a[2]), (int)a[0], (int)a[2]);
}

static int64_t signal_with_value(struct tracee *of, uint64_t *a) {
    return sent(CALL(of, SYS_rt_sigqueueinfo, a[0], a[1], a[2]), (int)a[0], (int)a[1]);
}

static int64_t signal_thread_with_value(struct tracee *of, uint64_t *a) {
    return sent(CALL(of, SYS_rt_tgsigqueueinfo, a[0], a[1], a[2], a[3]), (int)a[0], (int)a[2]);
}

static int64_t set_action(struct tracee *of, uint64_t *a) {
    struct action action;
    if (a[0] > 0 && a[0] < SIGNALS && a[1] && get(of, a[1], &action, sizeof action))
        of->process->actions[a[0]] = action;
    return LET_GO;
}

// Random numbers that are the same in every run: SplitMix64 from a fixed start.
static int64_t draw(struct tracee *of, uint64_t *a) {
    static uint64_t state = 0x10c57e9;
    uint64_t lots[32], done = 0, size = a[1] < 65536 ? a[1] : 65536;
    while (done < size) {
        for (size_t i = 0; i < 32; i++) {
            uint64_t z = state += 0x9e3779b97f4a7c15;
            z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
            z = (z ^ z >> 27) * 0x94d049bb133111eb;
            lots[i] = z ^ z >> 31;
        }
        uint64_t piece = size - done < sizeof lots ? size - done : sizeof lots;
        if (!put(of, a[0] + done, lots, piece)) return -EFAULT;
        done += piece;
    }
    return (int64_t)size;
}

// Refuses calls that would escape virtual time.
static int64_t refuse(struct tracee *of, uint64_t *a) {
    (void)of, (void)a;
    return -ENOSYS;
}

const struct call calls_of_processes[] = {
    {SYS_clone, make_clone},
    {435, make_clone_how},
    {SYS_fork, make_fork},
    {SYS_vfork, make_vfork},
    {SYS_set_tid_address, name_word},
    {SYS_exit, end_thread},
    {SYS_exit_group, end_process},
    {SYS_wait4, wait_child},
    {SYS_waitid, wait_one},
    {SYS_kill, signal_other},
    {SYS_tkill, signal_thread},
    {SYS_tgkill, signal_thread_of},
    {SYS_rt_sigqueueinfo, signal_with_value},
    {SYS_rt_tgsigqueueinfo, signal_thread_with_value},
    {SYS_rt_sigaction, set_action},
    {SYS_getrandom, draw},
    {SYS_ptrace, refuse},
    // io_uring_setup
    {425, refuse},
    {0},
};
