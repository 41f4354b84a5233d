// Starts a program under the filter, and serves it until all of it has ended.
#include "tracer.h"
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stdio.h>
#include <sys/personality.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#define CALLS_MAX 512
// Base of x32 system call numbers, none of which is supported.
#define X32 0x40000000

void fail(const char *what) {
    dprintf(2, "lockstep: failed to %s: %s\n", what, strerror(errno));
    REAL(_exit)(120);
    __builtin_unreachable();
}

// Only calls that take or query time, or that create something which does, stop the program.
static void set_filter(void) {
    struct sock_filter code[CALLS_MAX + 8];
    unsigned short used = 0;
    code[used++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, arch));
    code[used++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0);
    code[used++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS);
    code[used++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr));
    code[used++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, X32, 0, 1);
    code[used++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS);
    for (unsigned number = 0; number < CALLS_MAX; number++) {
        if (!is_of_interest((int)number)) continue;
        code[used++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, 1);
        code[used++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRACE);
    }
    code[used++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    struct sock_fprog program = {.len = used, .filter = code};
    // Without it a filter needs privileges; with it set-uid programs run without theirs.
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)) fail("give up new privileges");
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program)) fail("set the filter of system calls");
}

static sigset_t mask_of_program;

// Other programs know the program by the tracer's process id. Signals sent to it wait until the whole program waits.
static void hold_signals(void) {
    sigset_t held;
    sigfillset(&held);
    sigdelset(&held, SIGCHLD);
    sigprocmask(SIG_SETMASK, &held, &mask_of_program);
}

// The child: the first word is its path, the second its name.
static void become(char **words) {
    extern char **environ;
    unsetenv("HIL_LOCKSTEP");
    // Signals of the program to its own group must not reach the tracer.
    setpgid(0, 0);
    if (ptrace(PTRACE_TRACEME, 0, 0, 0)) fail("be traced");
    raise(SIGSTOP);
    // Makes addresses, and anything derived from them, the same in every run.
    personality(ADDR_NO_RANDOMIZE);
    prctl(PR_SET_TSC, PR_TSC_SIGSEGV);
    char **arguments = words + 1;
    const char *path = words[0];
    sigprocmask(SIG_SETMASK, &mask_of_program, NULL);
    set_filter();
    execve(path, arguments, environ);
    // Must not read a clock: the clock page does not exist yet.
    static const char text[] = "lockstep: the program cannot be started\n";
    REAL(syscall)(SYS_pwrite64, 2, text, sizeof text - 1, 0);
    REAL(_exit)(127);
}

void stdio_talks(void) {}
void tracer_declare(const char *path) { (void)path; }

int main(int count, char **words) {
    if (count < 3 || !is_managed()) {
        fprintf(stderr, "lockstep: the tracer is started by the harness\n");
        return 2;
    }
    clock_page_make();
    hold_signals();
    int pid = fork();
    if (pid < 0) fail("start a process");
    if (pid == 0) become(words + 1);
    struct rlimit files;
    getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max < DESCRIPTORS_MAX ? files.rlim_max : DESCRIPTORS_MAX;
    setrlimit(RLIMIT_NOFILE, &files);
    int status;
    while (waitpid(pid, &status, __WALL) < 0 && errno == EINTR) {}
    unsigned long options = PTRACE_O_EXITKILL | PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACESECCOMP | PTRACE_O_TRACECLONE
        | PTRACE_O_TRACEFORK | PTRACE_O_TRACEVFORK | PTRACE_O_TRACEEXEC;
    if (!WIFSTOPPED(status) || ptrace(PTRACE_SETOPTIONS, pid, 0, options)) fail("trace the program");
    current = self = &thread_begin(process_begin(NULL, pid, false), pid)->thread;
    self->woken = false;
    self->wait.kind = WAIT_NOTHING;
    setcontext(&present()->context);
    return 1;
}
