// Interfaces between the parts of the tracer. The tracer runs a program without the C library, and everything that this
// program starts, in the harness's virtual time: it stops their system calls and answers those that involve time.
// Lines, CAN sockets, timers and the order of turns are the shim's own sources; see docs/virtual-time.md.
#ifndef LOCKSTEP_TRACER_H
#define LOCKSTEP_TRACER_H

#include "../shim/can.h"
#include <sys/user.h>
#include <ucontext.h>

#define SIGNALS 65
// Signal handlers and signal sets in the kernel's layout.
struct action {
    uint64_t handler, flags, restorer, mask;
};
#define KERNEL_SIGSET_BYTES 8

// A descriptor of a process, and the tracer's copy of it; zero for none.
struct slot {
    int ours;
    // For a serial line: where the process keeps the socket while the pty is in its place.
    int kept;
};

struct process {
    struct process *next, *parent;
    int pid, pid_fd, threads;
    bool has_ended, is_ending;
    // Address of the scratch room of the clock page in its memory.
    uint64_t scratch;
    // Distinguishes equal addresses of different memories.
    uint64_t memory;
    struct action actions[SIGNALS];
    struct slot slots[DESCRIPTORS_MAX];
    struct virtual_timer alarm;
    struct signal_timer *timers;
};

// Position of a thread: before a system call, after one, or elsewhere.
enum stand { STANDS_ELSEWHERE, STANDS_BEFORE, STANDS_AFTER };

struct tracee {
    // Must be first: the part that turns.c uses.
    struct thread thread;
    struct process *process;
    int tid;
    enum stand stand;
    bool has_regs, is_dirty;
    // Signals blocked while it waits, if a call has its own mask.
    bool is_masked;
    uint64_t mask;
    // The signals that have come allow a restart of the call (SA_RESTART).
    bool restarts;
    // Its mask before calls were made on its behalf.
    bool is_shielded;
    uint64_t shielded;
    // Current registers, and those before calls were made on its behalf.
    struct user_regs_struct regs, before;
    uint64_t clear_tid, clone_flags, clone_clears;
    ucontext_t context;
    void *stack;
};

// The page that the program's clock reads: clock_page.c.
#define CLOCKS 12
struct clock_page {
    int64_t now_ns;
    int64_t questions_left;
    int64_t bases[CLOCKS];
    // Room in the memory of every process for arguments and results of calls on its behalf.
    char scratch[];
};
extern struct clock_page *clock_page;
void clock_page_make(void);
void clock_page_set(void);
void clock_page_enter(struct tracee *of);

// threads.c
extern struct process *processes;
extern int process_count;
struct tracee *thread_begin(struct process *process, int tid);
struct process *process_begin(struct process *parent, int pid, bool shares_memory);
uint64_t memory_made(void);
void sweep(void);
struct process *process_of(int pid);
struct tracee *tracee_of(int tid);
void leave(void) __attribute__((noreturn));
void thread_ended(struct tracee *of, int status);
static inline struct tracee *present(void) { return (struct tracee *)self; }
const void *key_of(const struct process *process, uint64_t address);

// stops.c
int go(struct tracee *of, int how, int signal);
void live(void);
void await_end(struct process *process);
void die(struct tracee *of, int status) __attribute__((noreturn));

// calls.c: a handler of a system call returns the result, or one of these.
#define LET_GO INT64_MIN
// The call is restarted after the handler of a signal.
#define AGAIN (INT64_MIN + 1)
// The call has been made, and the kernel's result stands.
#define KEPT (INT64_MIN + 2)
typedef int64_t handler(struct tracee *of, uint64_t *a);
struct call {
    int number;
    handler *handler;
};
extern const struct call calls_of_time[], calls_of_timers[], calls_of_waiting[], calls_of_files[], calls_of_bytes[],
    calls_of_sockets[], calls_of_processes[];
bool is_of_interest(int number);
void call_stopped(struct tracee *of);
int64_t result_of(int64_t result);
int64_t restarted(struct tracee *of, int64_t result);

// remote.c: memory of the program, and calls on its behalf.
bool get(struct tracee *of, uint64_t from, void *to, size_t size);
bool put(struct tracee *of, uint64_t to, const void *from, size_t size);
bool get_text(struct tracee *of, uint64_t from, char *to, size_t size);
int64_t make_call(struct tracee *of, int number, const uint64_t *arguments);
#define CALL(of, number, ...) make_call(of, number, (uint64_t[6]){__VA_ARGS__})
void settle_regs(struct tracee *of);
struct user_regs_struct *regs_of(struct tracee *of);

// slots.c: descriptors of the program, and ours.
int ours(struct tracee *of, int64_t fd);
struct descriptor *object_of(struct tracee *of, int64_t fd);
int slot_take(struct tracee *of, int fd);
void slot_drop(struct process *process, unsigned fd);
void slot_copied(struct process *process, int from, int to);
void slots_fork(struct process *from, struct process *to);
void slots_exec(struct tracee *of);
void slots_end(struct process *process);

// lines.c: opening a line in the program.
int64_t line_open(struct tracee *of, const char *path, int flags);
int64_t can_socket_open(int type, int protocol);

// signals.c
void signal_sent(struct process *process);
void signal_process(struct process *process, int signal);
uint64_t pending_of(struct tracee *of, uint64_t mask);
void signals_pass_on(void);
void signals_taken(struct tracee *of);

// calls_timers.c
void timers_of_program_end(struct process *process);

// main.c
void fail(const char *what) __attribute__((noreturn));

#endif
