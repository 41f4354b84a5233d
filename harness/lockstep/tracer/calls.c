// The system calls at which the program stops, and their handlers.
#include "tracer.h"
#include <sys/ptrace.h>
#include <linux/ptrace.h>
#include <sys/syscall.h>

static handler *handlers[512];

static void list(const struct call *calls) {
    for (; calls->handler; calls++) handlers[calls->number] = calls->handler;
}

static void list_all(void) {
    list(calls_of_time), list(calls_of_timers), list(calls_of_waiting), list(calls_of_files), list(calls_of_bytes);
    list(calls_of_sockets), list(calls_of_processes);
}

bool is_of_interest(int number) {
    if (!handlers[SYS_read]) list_all();
    return number >= 0 && number < 512 && handlers[number];
}

// The result in the kernel's form: a number, or a negative error code.
int64_t result_of(int64_t result) { return result < 0 ? -errno : result; }

// A call that a signal has ended is restarted after its handler, if the program requested that.
int64_t restarted(struct tracee *of, int64_t result) { return result == -EINTR && of->restarts ? AGAIN : result; }

// Reading the call and setting its result costs half as much as transferring all registers.
static void give(struct tracee *of, int64_t result) {
    ptrace(PTRACE_POKEUSER, of->tid, offsetof(struct user_regs_struct, orig_rax), -1L);
    ptrace(PTRACE_POKEUSER, of->tid, offsetof(struct user_regs_struct, rax), result);
}

void call_stopped(struct tracee *of) {
    struct ptrace_syscall_info info = {0};
    ptrace(PTRACE_GET_SYSCALL_INFO, of->tid, sizeof info, &info);
    uint64_t call = info.seccomp.nr, a[6];
    if (info.op != PTRACE_SYSCALL_INFO_SECCOMP || !is_of_interest((int)call)) return;
    memcpy(a, info.seccomp.args, sizeof a);
    of->stand = STANDS_BEFORE;
    int64_t result = handlers[call](of, a);
    of->is_masked = false;
    if (result == LET_GO) return;
    if (of->stand == STANDS_BEFORE && result != AGAIN) return give(of, result);
    struct user_regs_struct made = *regs_of(of);
    if (of->stand == STANDS_AFTER) of->regs = of->before;
    of->regs.rax = (uint64_t)result;
    of->regs.orig_rax = (uint64_t)-1;
    if (result == AGAIN) of->regs.rip -= 2, of->regs.rax = call;
    if (result == KEPT) of->regs.rax = made.rax, of->regs.orig_rax = made.orig_rax;
    of->is_dirty = true;
    if (of->is_shielded) ptrace(PTRACE_SETSIGMASK, of->tid, KERNEL_SIGSET_BYTES, &of->shielded);
    of->is_shielded = false;
}
