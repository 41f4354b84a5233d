// Whether the program waits for itself alone: each thread waits, without a deadline, for something that only another
// thread of the program can give. Then none of them ever goes on.
#include "shim.h"
#include <stdio.h>

// Memory that is shared with other processes can be changed by them.
static bool is_shared(pid_t process, uintptr_t address) {
    // Static: the stack of a thread may be small, and only one thread runs.
    static char text[8192];
    char path[32];
    size_t held = 0;
    ssize_t count;
    bool is_found = false, is_private = false;
    snprintf(path, sizeof path, "/proc/%d/maps", (int)process);
    int fd = REAL(openat)(AT_FDCWD, path, O_RDONLY | O_CLOEXEC);
    while (fd >= 0 && !is_found && (count = REAL(read)(fd, text + held, sizeof text - 1 - held)) > 0) {
        char *line = text, *end;
        held += (size_t)count;
        text[held] = 0;
        for (; !is_found && (end = strchr(line, '\n')); line = end + 1) {
            // 7f0000000000-7f0000001000 rw-p ...
            uintptr_t from = strtoul(line, &line, 16), to = strtoul(line + 1, &line, 16);
            is_found = from <= address && address < to;
            is_private = is_found && line[4] == 'p';
        }
        held -= (size_t)(line - text);
        memmove(text, line, held);
    }
    if (fd >= 0) REAL(close)(fd);
    return !is_private;
}

// Signals that come by what the program itself does; Python always has a handler for SIGINT.
static bool is_its_own(int signal) {
    switch (signal) {
    case SIGSEGV:
    case SIGBUS:
    case SIGFPE:
    case SIGILL:
    case SIGTRAP:
    case SIGABRT:
    case SIGSYS:
    case SIGPIPE:
    case SIGCHLD:
    case SIGINT: return true;
    // The C library's own, for threads.
    case 32:
    case 33: return true;
    default: return false;
    }
}

static bool may_be_signalled(const struct thread *thread) {
    for (int signal = 1; signal <= 64; signal++)
        if (!is_its_own(signal) && has_handler(thread, signal)) return true;
    return false;
}

bool is_stuck(unsigned *threads) {
    *threads = 0;
    if (timers_next() != NEVER) return false;
    for (const struct thread *thread = first; thread; thread = thread->next)
        if (!thread->finished && (thread->wait.deadline != NEVER || thread->wait.giver == ANYONE)) return false;
    for (const struct thread *thread = first; thread; thread = thread->next) {
        enum giver giver = thread->wait.giver;
        if (thread->finished) continue;
        if (giver != THREAD && may_be_signalled(thread)) return false;
        if (giver == CHILD) continue;
        if (is_shared(process_id_of(thread), address_of(thread))) return false;
        ++*threads;
    }
    return !*threads || !has_other_threads();
}
