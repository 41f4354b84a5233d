// Waiting for descriptors: poll, select, epoll. The real call only polls; the harness does the waiting.
#include "shim.h"
#include <sys/epoll.h>
#include <sys/select.h>

// These calls are never restarted after a signal, whatever the program requested.
static int never_restarted(int result) {
    if (result < 0 && errno == ERESTART) errno = EINTR;
    return result;
}

EXPORT int poll(struct pollfd *fds, nfds_t count, int ms) {
    if (!in_lockstep()) return REAL(poll)(fds, count, ms);
    return never_restarted(wait_fds(fds, count, deadline_ms(ms)));
}

EXPORT int __poll_chk(struct pollfd *fds, nfds_t count, int ms, size_t size) {
    (void)size;
    return poll(fds, count, ms);
}

// With a signal mask the kernel and the waiting thread itself must check: a signal may be due under the mask.
static int wait_masked(int64_t deadline, int (*look)(void *), void *with) {
    for (;;) {
        int result = look(with);
        if (result || deadline <= now_ns) {
            progressed = true;
            if (result == 0) question();
            return result;
        }
        enum woken woken = block(&(struct wait){.kind = WAIT_RUN, .deadline = deadline});
        if (woken == INTERRUPTED || woken == RESTART) return errno = EINTR, -1;
    }
}

struct masked_poll {
    struct pollfd *fds;
    nfds_t count;
    const sigset_t *mask;
};
static int look_poll(void *with) {
    struct masked_poll *of = with;
    return REAL(ppoll)(of->fds, of->count, &(struct timespec){0}, of->mask);
}

EXPORT int ppoll(struct pollfd *fds, nfds_t count, const struct timespec *span, const sigset_t *mask) {
    if (!in_lockstep()) return REAL(ppoll)(fds, count, span, mask);
    if (!mask) return never_restarted(wait_fds(fds, count, deadline_of(span)));
    return wait_masked(deadline_of(span), look_poll, &(struct masked_poll){fds, count, mask});
}

EXPORT int sigsuspend(const sigset_t *mask) {
    if (!in_lockstep()) return REAL(sigsuspend)(mask);
    return wait_masked(NEVER, look_poll, &(struct masked_poll){NULL, 0, mask});
}

EXPORT int pause(void) {
    if (!in_lockstep()) return REAL(pause)();
    sigset_t mask;
    pthread_sigmask(SIG_SETMASK, NULL, &mask);
    return sigsuspend(&mask);
}

EXPORT int sigtimedwait(const sigset_t *set, siginfo_t *info, const struct timespec *span) {
    if (!in_lockstep()) return REAL(sigtimedwait)(set, info, span);
    int64_t deadline = deadline_of(span);
    for (;;) {
        int result = REAL(sigtimedwait)(set, info, &(struct timespec){0});
        if (result >= 0 || errno != EAGAIN || deadline <= now_ns) return progressed = true, result;
        block(&(struct wait){.kind = WAIT_RUN, .deadline = deadline});
    }
}

EXPORT int sigwaitinfo(const sigset_t *set, siginfo_t *info) {
    if (!in_lockstep()) return REAL(sigwaitinfo)(set, info);
    return sigtimedwait(set, info, NULL);
}

EXPORT int sigwait(const sigset_t *set, int *signal) {
    if (!in_lockstep()) return REAL(sigwait)(set, signal);
    int result = sigtimedwait(set, NULL, NULL);
    if (result < 0) return errno;
    *signal = result;
    return 0;
}

struct sets {
    int count;
    fd_set *read, *write, *except;
    const sigset_t *mask;
};

// Polls the kernel, and leaves the sets unchanged if nothing is ready.
static int look_select(void *with) {
    struct sets *of = with;
    size_t size = ((size_t)of->count + 63) / 64 * 8;
    char copies[3][size + 8];
    fd_set *sets[3] = {of->read, of->write, of->except}, *asked[3];
    for (int i = 0; i < 3; i++) {
        asked[i] = sets[i] ? (fd_set *)copies[i] : NULL;
        if (sets[i]) memcpy(copies[i], sets[i], size);
    }
    int result = REAL(pselect)(of->count, asked[0], asked[1], asked[2], &(struct timespec){0}, of->mask);
    for (int i = 0; i < 3 && result > 0; i++)
        if (sets[i]) memcpy(sets[i], copies[i], size);
    return result;
}

static void clear_sets(struct sets *of) {
    size_t size = ((size_t)of->count + 63) / 64 * 8;
    if (of->read) memset(of->read, 0, size);
    if (of->write) memset(of->write, 0, size);
    if (of->except) memset(of->except, 0, size);
}

static bool is_in(int fd, fd_set *set) { return set && ((__fd_mask *)set)[fd / __NFDBITS] >> fd % __NFDBITS & 1; }

static int wait_select(struct sets *of, int64_t deadline) {
    if (of->count < 0 || of->count > DESCRIPTORS_MAX) return errno = EINVAL, -1;
    int result;
    if (of->mask) {
        result = wait_masked(deadline, look_select, of);
    } else {
        struct pollfd fds[of->count + 1];
        nfds_t used = 0;
        for (int fd = 0; fd < of->count; fd++) {
            short events = (is_in(fd, of->read) ? POLLIN : 0) | (is_in(fd, of->write) ? POLLOUT : 0)
                | (is_in(fd, of->except) ? POLLPRI : 0);
            if (events) fds[used++] = (struct pollfd){.fd = fd, .events = events};
        }
        do {
            result = wait_fds(fds, used, deadline);
            if (result > 0) result = look_select(of);
        } while (result == 0 && deadline > now_ns);
    }
    if (result == 0) clear_sets(of);
    return never_restarted(result);
}

EXPORT int select(int count, fd_set *restrict read, fd_set *restrict write, fd_set *restrict except,
                  struct timeval *restrict span) {
    if (!in_lockstep()) return REAL(select)(count, read, write, except, span);
    int64_t deadline = span ? deadline_after(span->tv_sec * SECOND + span->tv_usec * 1000) : NEVER;
    int result = wait_select(&(struct sets){count, read, write, except, NULL}, deadline);
    // Linux returns the time left.
    if (span) *span = timeval_of(deadline > now_ns ? deadline - now_ns : 0);
    return result;
}

EXPORT int pselect(int count, fd_set *restrict read, fd_set *restrict write, fd_set *restrict except,
                   const struct timespec *restrict span, const sigset_t *restrict mask) {
    if (!in_lockstep()) return REAL(pselect)(count, read, write, except, span, mask);
    return wait_select(&(struct sets){count, read, write, except, mask}, deadline_of(span));
}

struct epoll {
    int fd, max;
    struct epoll_event *events;
    const sigset_t *mask;
};
static int look_epoll(void *with) {
    struct epoll *of = with;
    return REAL(epoll_pwait)(of->fd, of->events, of->max, 0, of->mask);
}

static int wait_epoll(struct epoll *of, int64_t deadline) {
    if (of->mask) return wait_masked(deadline, look_epoll, of);
    for (;;) {
        int result = look_epoll(of);
        if (result || deadline <= now_ns) {
            progressed = true;
            if (result == 0) question();
            return result;
        }
        // Another thread may only check for data: taking it would lose it.
        struct pollfd one = {.fd = of->fd, .events = POLLIN};
        enum woken woken = block(&(struct wait){.kind = WAIT_FDS, .deadline = deadline, .fds = &one, .count = 1});
        if (woken == INTERRUPTED || woken == RESTART) return errno = EINTR, -1;
    }
}

EXPORT int epoll_wait(int fd, struct epoll_event *events, int max, int ms) {
    if (!in_lockstep()) return REAL(epoll_wait)(fd, events, max, ms);
    return wait_epoll(&(struct epoll){fd, max, events, NULL}, deadline_ms(ms));
}

EXPORT int epoll_pwait(int fd, struct epoll_event *events, int max, int ms, const sigset_t *mask) {
    if (!in_lockstep()) return REAL(epoll_pwait)(fd, events, max, ms, mask);
    return wait_epoll(&(struct epoll){fd, max, events, mask}, deadline_ms(ms));
}

EXPORT int epoll_pwait2(int fd, struct epoll_event *events, int max, const struct timespec *span,
                        const sigset_t *mask) {
    if (!in_lockstep()) return errno = ENOSYS, -1;
    return wait_epoll(&(struct epoll){fd, max, events, mask}, deadline_of(span));
}
