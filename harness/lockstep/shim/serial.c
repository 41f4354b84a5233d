// Reads and writes serial ports according to termios, without really blocking.
#include "shim.h"
#include <sys/ioctl.h>

// Retry period of a writer on a full line: the harness empties the line while the program waits. A nonblocking writer
// waits too, as it would not be notified of room.
#define FULL_NS 1000000

static size_t bytes_of(const struct iovec *parts, int count) {
    size_t sum = 0;
    for (int i = 0; i < count; i++) sum += parts[i].iov_len;
    return sum;
}

// Number of available bytes, once `enough` have come or the line has been silent for VTIME since the last one; -1 after
// a signal.
static int await_burst(int fd, int enough, int64_t silence) {
    int there = 0, before = 0;
    int64_t deadline = NEVER;
    for (;;) {
        is_ready(fd, POLLIN);
        REAL(ioctl)(fd, FIONREAD, &there);
        if (there >= enough || (there > 0 && deadline <= now_ns)) return there;
        if (there > before) deadline = deadline_after(silence), before = there;
        // A pty is ready with one byte or with many: more shows only at the next instant.
        enum woken woken = block(&(struct wait){.kind = WAIT_RUN, .deadline = deadline});
        if (woken == INTERRUPTED) return -1;
    }
}

// Waits as termios says: until VMIN bytes are there, for at most VTIME, or for a silence of VTIME. True if a read makes
// sense.
static bool await_bytes(int fd, const struct serial *serial, size_t wanted) {
    if (serial->has_lines) return wait_fd(fd, POLLIN, NEVER) > 0 || errno == ERESTART;
    int64_t span = serial->tenths * (SECOND / 10);
    size_t enough = serial->bytes_min;
    if (enough > wanted) enough = wanted;
    if (enough == 0) return wait_fd(fd, POLLIN, deadline_after(span)) > 0;
    if (span == 0 && enough == 1) return wait_fd(fd, POLLIN, NEVER) > 0 || errno == ERESTART;
    return await_burst(fd, (int)enough, span ? span : NEVER) > 0;
}

// Lets time pass until the last byte that was written has left the port; false after a signal.
bool serial_drain(const struct serial *serial) {
    uint32_t number = (uint32_t)serial->number;
    while (in_lockstep()) {
        int64_t until;
        link_unsent(number, &until);
        if (until <= now_ns) break;
        if (block_until(until) == INTERRUPTED) return errno = EINTR, false;
    }
    return true;
}

// Reads or writes for the program; blocks in virtual time if the program expects that.
ssize_t serial_transfer(int fd, struct descriptor *of, const struct iovec *parts, int count, bool is_read) {
    struct serial *serial = of->object;
    bool waits = !serial->is_nonblocking && in_lockstep();
    size_t wanted = bytes_of(parts, count);
    ssize_t done = 0;
    while (is_read) {
        bool looks_first = waits && !serial->has_lines && serial->bytes_min > 1;
        if (looks_first && wanted && !await_bytes(fd, serial, wanted)) return errno = EINTR, -1;
        done = REAL(readv)(fd, parts, count);
        bool is_empty = done == 0 || (done < 0 && errno == EAGAIN);
        if (!is_empty || wanted == 0) {
            progressed = true;
            return done;
        }
        if (!waits) break;
        errno = 0;
        if (!await_bytes(fd, serial, wanted)) return errno == EINTR ? -1 : 0;
    }
    if (is_read) {
        question();
        return done;
    }
    sending();
    for (int part = 0; part < count; part++) {
        size_t written = 0;
        while (written < parts[part].iov_len) {
            const char *from = (const char *)parts[part].iov_base + written;
            ssize_t some = REAL(write)(serial->is_cooked ? fd : serial->out, from, parts[part].iov_len - written);
            if (some > 0) {
                written += (size_t)some, done += some;
            } else if (some < 0 && errno == EAGAIN && (waits || !serial->is_cooked)) {
                if (block_until(deadline_after(FULL_NS)) == INTERRUPTED) return done ? done : (errno = EINTR, -1);
            } else if (some < 0 && errno != EINTR) {
                return done ? done : -1;
            }
        }
    }
    // One write crosses the line as one.
    if (done > 0 && !serial->is_cooked && !link_is_busy) link_tell(TELL_WROTE, (uint32_t)serial->number, done);
    progressed = true;
    return done;
}
