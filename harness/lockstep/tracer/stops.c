// Where a thread of the program stops, and how that is handled.
#include "tracer.h"
#include <sys/ptrace.h>
#include <sys/wait.h>

// Threads whose first stop came before the report of their creation.
#define EARLY_MAX 64
static int early[EARLY_MAX], early_count;

static void heard_of(int tid, int status) {
    struct tracee *of = tracee_of(tid);
    if (WIFSTOPPED(status)) {
        if (!of && early_count < EARLY_MAX) early[early_count++] = tid;
    } else if (of) {
        thread_ended(of, status);
    }
}

static bool is_event(int status, int event) { return status >> 8 == (SIGTRAP | event << 8); }

// Lets one thread run until it stops, and returns where. No other thread runs meanwhile; some may end.
int go(struct tracee *of, int how, int signal) {
    settle_regs(of);
    of->has_regs = false;
    of->stand = STANDS_ELSEWHERE;
    progressed = true;
    unsigned asked = of->thread.questions;
    int64_t left = asked < spin_questions ? spin_questions - asked : 0;
    clock_page->now_ns = now_ns;
    clock_page_set();
    clock_page->questions_left = left;
    ptrace(how, of->tid, 0, signal);
    for (;;) {
        int status, tid = waitpid(-1, &status, __WALL);
        if (tid < 0 && errno == EINTR) continue;
        if (tid < 0) fail("wait for the program");
        if (is_event(status, PTRACE_EVENT_EXEC) && tid == of->process->pid && tid != of->tid) {
            // It replaces the first thread, whose end is not reported.
            struct tracee *eldest = tracee_of(tid);
            if (eldest) eldest->thread.finished = true, eldest->tid = 0, of->process->threads--;
            of->tid = tid;
        }
        if (tid == of->tid) {
            int64_t rest = clock_page->questions_left;
            if (left > 0) of->thread.questions = spin_questions - (unsigned)(rest > 0 ? rest : 0);
            return status;
        }
        heard_of(tid, status);
    }
}

// Waits until a killed process is gone.
void await_end(struct process *process) {
    int pid = process->pid;
    for (struct process *still; (still = process_of(pid)) && !still->has_ended;) {
        int status, tid = waitpid(-1, &status, __WALL);
        if (tid < 0 && errno != EINTR) return;
        if (tid > 0) heard_of(tid, status);
    }
}

static void await_first_stop(int tid) {
    for (int i = 0; i < early_count; i++) {
        if (early[i] != tid) continue;
        early[i] = early[--early_count];
        return;
    }
    int status;
    while (waitpid(tid, &status, __WALL) < 0 && errno == EINTR) {}
}

// Takes a new thread or process, which is at its first instruction.
static void has_made(struct tracee *of, int event) {
    unsigned long made;
    if (ptrace(PTRACE_GETEVENTMSG, of->tid, 0, &made)) return;
    await_first_stop((int)made);
    bool is_thread = of->clone_flags & CLONE_THREAD;
    struct process *process = of->process;
    if (!is_thread) process = process_begin(of->process, (int)made, of->clone_flags & CLONE_VM);
    struct tracee *thread = thread_begin(process, (int)made);
    thread->clear_tid = of->clone_clears;
    if (event != PTRACE_EVENT_VFORK) return;
    // Until the child has replaced itself or ended.
    block(&(struct wait){.kind = WAIT_ADDRESS, .deadline = NEVER, .address = process, .bitset = UINT32_MAX});
}

static void has_replaced_itself(struct tracee *of) {
    struct process *process = of->process;
    int status;
    do status = go(of, PTRACE_SYSCALL, 0);
    while (WIFSTOPPED(status) && status >> 8 != (SIGTRAP | 0x80));
    for (int signal = 1; signal < SIGNALS; signal++)
        // SIG_IGN stays.
        if (process->actions[signal].handler != 1) process->actions[signal] = (struct action){0};
    process->memory = memory_made();
    of->clear_tid = 0;
    slots_exec(of);
    clock_page_enter(of);
    wake(process, UINT32_MAX, UINT32_MAX);
}

// The processor's counter follows bench time, one step per nanosecond. True if the program was reading it.
static bool reads_counter(struct tracee *of) {
    unsigned char code[3];
    struct user_regs_struct *regs = regs_of(of);
    if (!get(of, regs->rip, code, sizeof code) || code[0] != 0x0f) return false;
    bool has_processor = code[1] == 0x01 && code[2] == 0xf9;
    if (code[1] != 0x31 && !has_processor) return false;
    question();
    uint64_t count = (uint64_t)clock_ns(CLOCK_MONOTONIC);
    regs = regs_of(of);
    regs->rax = (uint32_t)count, regs->rdx = count >> 32;
    if (has_processor) regs->rcx = 0;
    regs->rip += has_processor ? 3 : 2;
    of->is_dirty = true;
    return true;
}

// Life of a thread, from its first turn to its end.
void live(void) {
    struct tracee *of = present();
    int signal = 0;
    for (;;) {
        int status = go(of, PTRACE_CONT, signal);
        signal = 0;
        if (!WIFSTOPPED(status)) die(of, status);
        if (is_event(status, PTRACE_EVENT_SECCOMP)) call_stopped(of);
        else if (is_event(status, PTRACE_EVENT_EXEC)) has_replaced_itself(of);
        else if (is_event(status, PTRACE_EVENT_CLONE)) has_made(of, PTRACE_EVENT_CLONE);
        else if (is_event(status, PTRACE_EVENT_FORK)) has_made(of, PTRACE_EVENT_FORK);
        else if (is_event(status, PTRACE_EVENT_VFORK)) has_made(of, PTRACE_EVENT_VFORK);
        else if (status >> 8 == (SIGTRAP | 0x80)) continue;
        else if (WSTOPSIG(status) != SIGSEGV || !reads_counter(of)) signal = WSTOPSIG(status);
    }
}

// A thread has ended, and perhaps its whole process.
void die(struct tracee *of, int status) {
    struct process *process = of->process;
    thread_ended(of, status);
    if (WIFSIGNALED(status) || process->is_ending) await_end(process);
    leave();
}
