// Memory and registers of the program, and calls on its behalf.
#include "tracer.h"
#include <sys/ptrace.h>
#include <sys/wait.h>

bool get(struct tracee *of, uint64_t from, void *to, size_t size) {
    struct iovec here = {to, size}, there = {(void *)from, size};
    return size == 0 || process_vm_readv(of->tid, &here, 1, &there, 1, 0) == (ssize_t)size;
}

bool put(struct tracee *of, uint64_t to, const void *from, size_t size) {
    struct iovec here = {(void *)from, size}, there = {(void *)to, size};
    return size == 0 || process_vm_writev(of->tid, &here, 1, &there, 1, 0) == (ssize_t)size;
}

// Reads a text up to its zero; false if it is longer than the room. Does not read past a page that may be the last.
bool get_text(struct tracee *of, uint64_t from, char *to, size_t size) {
    for (size_t done = 0; done < size;) {
        size_t piece = 4096 - (from + done) % 4096;
        if (piece > size - done) piece = size - done;
        if (piece > 256) piece = 256;
        if (!get(of, from + done, to + done, piece)) return false;
        if (memchr(to + done, 0, piece)) return true;
        done += piece;
    }
    return false;
}

struct user_regs_struct *regs_of(struct tracee *of) {
    if (!of->has_regs && ptrace(PTRACE_GETREGS, of->tid, 0, &of->regs)) memset(&of->regs, 0, sizeof of->regs);
    of->has_regs = true;
    return &of->regs;
}

void settle_regs(struct tracee *of) {
    if (of->is_dirty) ptrace(PTRACE_SETREGS, of->tid, 0, &of->regs);
    of->is_dirty = false;
}

// Holds back signals while calls are made on its behalf.
static void shield(struct tracee *of) {
    uint64_t all = UINT64_MAX;
    if (of->is_shielded) return;
    ptrace(PTRACE_GETSIGMASK, of->tid, KERNEL_SIGSET_BYTES, &of->shielded);
    ptrace(PTRACE_SETSIGMASK, of->tid, KERNEL_SIGSET_BYTES, &all);
    of->is_shielded = true;
}

// Makes a call on behalf of a thread that is at one of its own; returns the kernel's result.
int64_t make_call(struct tracee *of, int number, const uint64_t *a) {
    struct user_regs_struct *regs = regs_of(of);
    bool has_entered = of->stand == STANDS_BEFORE;
    if (has_entered) {
        of->before = *regs;
        regs->orig_rax = (uint64_t)number;
    } else {
        shield(of);
        regs->rip -= 2;
        regs->rax = (uint64_t)number;
        regs->orig_rax = (uint64_t)-1;
    }
    regs->rdi = a[0], regs->rsi = a[1], regs->rdx = a[2], regs->r10 = a[3], regs->r8 = a[4], regs->r9 = a[5];
    of->is_dirty = true;
    for (;;) {
        int status = go(of, PTRACE_SYSCALL, 0);
        if (!WIFSTOPPED(status)) die(of, status);
        // Stops before the call, possibly at the filter, and after it.
        if (status >> 8 != (SIGTRAP | 0x80)) continue;
        if (has_entered) break;
        has_entered = true;
    }
    of->stand = STANDS_AFTER;
    return (int64_t)regs_of(of)->rax;
}
