// Waiting for descriptors: the kernel is only polled; the harness does the waiting.
#include "shim.h"

bool is_ready(int fd, short events) {
    struct pollfd one = {.fd = fd, .events = events};
    int kept = errno;
    int count = REAL(poll)(&one, 1, 0);
    errno = kept;
    return count > 0;
}

bool is_nonblocking(int fd) {
    struct descriptor *of = descriptor(fd);
    if (of && of->kind == FD_SERIAL) return ((struct serial *)of->object)->is_nonblocking;
    int kept = errno, flags = REAL(fcntl)(fd, F_GETFL);
    errno = kept;
    return flags >= 0 && (flags & O_NONBLOCK);
}

// Like poll, until a deadline: the number of ready descriptors, zero after the deadline, or -1 with EINTR, or with
// ERESTART if the program requested restarts after its signal.
int wait_fds(struct pollfd *fds, nfds_t count, int64_t deadline) {
    for (;;) {
        int ready = REAL(poll)(fds, count, 0);
        if (ready || deadline <= now_ns) {
            progressed = true;
            if (ready == 0) question();
            return ready;
        }
        enum woken woken = block(&(struct wait){.kind = WAIT_FDS, .deadline = deadline, .fds = fds, .count = count});
        if (woken == INTERRUPTED) return errno = EINTR, -1;
        if (woken == RESTART) return errno = ERESTART, -1;
    }
}

int wait_fd(int fd, short events, int64_t deadline) {
    struct pollfd one = {.fd = fd, .events = events};
    return wait_fds(&one, 1, deadline);
}

// Time-out of a call on a socket, from SO_RCVTIMEO or SO_SNDTIMEO.
int64_t socket_deadline(int fd, short events) {
    struct timeval span = {0};
    socklen_t size = sizeof span;
    int kept = errno;
    int option = events == POLLIN ? SO_RCVTIMEO : SO_SNDTIMEO;
    int result = REAL(getsockopt)(fd, SOL_SOCKET, option, &span, &size);
    errno = kept;
    if (result || (span.tv_sec == 0 && span.tv_usec == 0)) return NEVER;
    return deadline_after(span.tv_sec * SECOND + span.tv_usec * 1000);
}

int64_t deadline_of(const struct timespec *span) {
    return span ? deadline_after(nanos(span)) : NEVER;
}

int64_t deadline_ms(int ms) { return ms < 0 ? NEVER : deadline_after(ms * 1000000LL); }
