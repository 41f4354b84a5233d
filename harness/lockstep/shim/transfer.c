// read, write and their variants, on any descriptor: calls that would block wait in virtual time.
#include "shim.h"
#include <sys/stat.h>
#include <sys/uio.h>

static enum fd_kind kind_of(int fd) {
    struct descriptor *of = descriptor(fd);
    return of ? of->kind : FD_PLAIN;
}

// A request for interfaces goes on to the kernel.
static void ask_route(int fd, const struct iovec *parts, size_t count) {
    if (kind_of(fd) == FD_ROUTE && count) route_asks(descriptor(fd), parts->iov_base, parts->iov_len);
}

static ssize_t take_route(int fd, void *data, size_t size, int flags) {
    struct iovec part = {data, size};
    return route_receive(fd, descriptor(fd), &(struct msghdr){.msg_iov = &part, .msg_iovlen = 1}, flags);
}

// True if the call may proceed: it will not block, or must not wait.
static bool await(int fd, short events, bool is_told_not_to) {
    if (!in_lockstep() || is_ready(fd, events)) return progressed = true;
    if (is_told_not_to || is_nonblocking(fd)) {
        question();
        return true;
    }
    int result;
    int64_t deadline = socket_deadline(fd, events);
    do result = wait_fd(fd, events, deadline);
    while (result < 0 && errno == ERESTART);
    if (result == 0) errno = EAGAIN;
    return result > 0;
}

EXPORT ssize_t read(int fd, void *data, size_t size) {
    struct descriptor *of = descriptor(fd);
    if (kind_of(fd) == FD_SERIAL) return serial_transfer(fd, of, &(struct iovec){data, size}, 1, true);
    if (kind_of(fd) == FD_CAN) return can_read(fd, of, data, size);
    if (route_answers(of)) return take_route(fd, data, size, 0);
    return await(fd, POLLIN, false) ? REAL(read)(fd, data, size) : -1;
}

EXPORT ssize_t __read_chk(int fd, void *data, size_t size, size_t room) {
    (void)room;
    return read(fd, data, size);
}

EXPORT ssize_t readv(int fd, const struct iovec *parts, int count) {
    struct descriptor *of = descriptor(fd);
    if (kind_of(fd) == FD_SERIAL) return serial_transfer(fd, of, parts, count, true);
    if (kind_of(fd) == FD_CAN) {
        struct msghdr message = {.msg_iov = (struct iovec *)parts, .msg_iovlen = (size_t)count};
        return can_receive(fd, of, &message, 0);
    }
    return await(fd, POLLIN, false) ? REAL(readv)(fd, parts, count) : -1;
}

static bool is_file(int fd) {
    struct stat state;
    return !fstat(fd, &state) && (S_ISREG(state.st_mode) || S_ISBLK(state.st_mode));
}

// A long write to something with limited room is split into pieces that fit.
static ssize_t write_pieces(int fd, const char *data, size_t size) {
    size_t done = 0;
    while (done < size) {
        if (!await(fd, POLLOUT, false)) return done ? (ssize_t)done : -1;
        size_t piece = size - done < PIPE_PIECE ? size - done : PIPE_PIECE;
        ssize_t some = REAL(write)(fd, data + done, piece);
        if (some < 0) return done ? (ssize_t)done : -1;
        done += (size_t)some;
    }
    return (ssize_t)done;
}

EXPORT ssize_t write(int fd, const void *data, size_t size) {
    struct descriptor *of = descriptor(fd);
    if (kind_of(fd) == FD_SERIAL) {
        return serial_transfer(fd, of, &(struct iovec){(void *)data, size}, 1, false);
    }
    if (kind_of(fd) == FD_CAN) return can_write(fd, of, data, size);
    ask_route(fd, &(struct iovec){(void *)data, size}, 1);
    if (size > PIPE_PIECE && in_lockstep() && !is_file(fd) && !is_nonblocking(fd)) return write_pieces(fd, data, size);
    return await(fd, POLLOUT, false) ? REAL(write)(fd, data, size) : -1;
}

EXPORT ssize_t writev(int fd, const struct iovec *parts, int count) {
    struct descriptor *of = descriptor(fd);
    if (kind_of(fd) == FD_SERIAL) return serial_transfer(fd, of, parts, count, false);
    if (kind_of(fd) == FD_CAN) {
        struct msghdr message = {.msg_iov = (struct iovec *)parts, .msg_iovlen = (size_t)count};
        return can_send(fd, of, &message, 0);
    }
    return await(fd, POLLOUT, false) ? REAL(writev)(fd, parts, count) : -1;
}

EXPORT ssize_t recv(int fd, void *data, size_t size, int flags) {
    return recvfrom(fd, data, size, flags, NULL, NULL);
}

EXPORT ssize_t __recv_chk(int fd, void *data, size_t size, size_t room, int flags) {
    (void)room;
    return recv(fd, data, size, flags);
}

EXPORT ssize_t recvfrom(int fd, void *restrict data, size_t size, int flags, struct sockaddr *restrict from,
                        socklen_t *restrict from_size) {
    bool is_list = route_answers(descriptor(fd));
    if (kind_of(fd) == FD_CAN || is_list) {
        struct iovec part = {data, size};
        struct msghdr message = {
            .msg_iov = &part, .msg_iovlen = 1, .msg_name = from, .msg_namelen = from_size ? *from_size : 0};
        ssize_t count = (is_list ? route_receive : can_receive)(fd, descriptor(fd), &message, flags);
        if (from_size) *from_size = message.msg_namelen;
        return count;
    }
    if (!await(fd, POLLIN, flags & MSG_DONTWAIT)) return -1;
    return REAL(recvfrom)(fd, data, size, flags, from, from_size);
}

EXPORT ssize_t __recvfrom_chk(int fd, void *restrict data, size_t size, size_t room, int flags,
                              struct sockaddr *restrict from, socklen_t *restrict from_size) {
    (void)room;
    return recvfrom(fd, data, size, flags, from, from_size);
}

EXPORT ssize_t recvmsg(int fd, struct msghdr *message, int flags) {
    if (kind_of(fd) == FD_CAN) return can_receive(fd, descriptor(fd), message, flags);
    if (route_answers(descriptor(fd))) return route_receive(fd, descriptor(fd), message, flags);
    return await(fd, POLLIN, flags & MSG_DONTWAIT) ? REAL(recvmsg)(fd, message, flags) : -1;
}

// On a CAN socket, one message after the other. The time limit ends the call between two messages, as in the kernel.
EXPORT int recvmmsg(int fd, struct mmsghdr *messages, unsigned count, int flags, struct timespec *limit) {
    if (kind_of(fd) != FD_CAN) {
        return await(fd, POLLIN, flags & MSG_DONTWAIT) ? REAL(recvmmsg)(fd, messages, count, flags, limit) : -1;
    }
    int64_t until = limit ? clock_ns(CLOCK_MONOTONIC) + nanos(limit) : INT64_MAX;
    unsigned done = 0;
    while (done < count) {
        int how = flags & ~MSG_WAITFORONE;
        if (done && flags & MSG_WAITFORONE) how |= MSG_DONTWAIT;
        ssize_t size = can_receive(fd, descriptor(fd), &messages[done].msg_hdr, how);
        if (size < 0) break;
        messages[done++].msg_len = (unsigned)size;
        if (clock_ns(CLOCK_MONOTONIC) >= until) break;
    }
    return done || !count ? (int)done : -1;
}

EXPORT int sendmmsg(int fd, struct mmsghdr *messages, unsigned count, int flags) {
    if (kind_of(fd) != FD_CAN) {
        return await(fd, POLLOUT, flags & MSG_DONTWAIT) ? REAL(sendmmsg)(fd, messages, count, flags) : -1;
    }
    unsigned done = 0;
    while (done < count) {
        ssize_t size = can_send(fd, descriptor(fd), &messages[done].msg_hdr, flags);
        if (size < 0) break;
        messages[done++].msg_len = (unsigned)size;
    }
    return done || !count ? (int)done : -1;
}

EXPORT ssize_t sendmsg(int fd, const struct msghdr *message, int flags) {
    if (kind_of(fd) == FD_CAN) return can_send(fd, descriptor(fd), message, flags);
    ask_route(fd, message->msg_iov, message->msg_iovlen);
    return await(fd, POLLOUT, flags & MSG_DONTWAIT) ? REAL(sendmsg)(fd, message, flags) : -1;
}

EXPORT ssize_t sendto(int fd, const void *data, size_t size, int flags, const struct sockaddr *to, socklen_t to_size) {
    if (kind_of(fd) == FD_CAN) {
        struct iovec part = {(void *)data, size};
        struct msghdr message = {
            .msg_iov = &part, .msg_iovlen = 1, .msg_name = (void *)to, .msg_namelen = to_size};
        return can_send(fd, descriptor(fd), &message, flags);
    }
    ask_route(fd, &(struct iovec){(void *)data, size}, 1);
    if (!await(fd, POLLOUT, flags & MSG_DONTWAIT)) return -1;
    return REAL(sendto)(fd, data, size, flags, to, to_size);
}

EXPORT ssize_t send(int fd, const void *data, size_t size, int flags) {
    if (kind_of(fd) == FD_CAN) return can_write(fd, descriptor(fd), data, size);
    ask_route(fd, &(struct iovec){(void *)data, size}, 1);
    return await(fd, POLLOUT, flags & MSG_DONTWAIT) ? REAL(send)(fd, data, size, flags) : -1;
}

EXPORT int accept4(int fd, struct sockaddr *from, socklen_t *size, int flags) {
    return await(fd, POLLIN, false) ? REAL(accept4)(fd, from, size, flags) : -1;
}

EXPORT int accept(int fd, struct sockaddr *from, socklen_t *size) { return accept4(fd, from, size, 0); }
