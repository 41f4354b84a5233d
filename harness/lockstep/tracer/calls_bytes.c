// Reading, writing and messages: calls that would block wait in virtual time. On lines the tracer itself reads and
// writes; on everything else the program does, once it will not block.
#include "tracer.h"
#include <sys/stat.h>
#include <sys/syscall.h>

// Most bytes per transfer on a line.
#define LINE_PIECE 65536
#define PARTS_MAX 1024

// LET_GO if the call may proceed: it will not block, or must not wait.
static int64_t await(struct tracee *of, int64_t fd, short events, bool is_told_not_to) {
    int copy = ours(of, (int)fd);
    if (copy < 0 || is_ready(copy, events)) return LET_GO;
    if (is_told_not_to || is_nonblocking(copy)) {
        question();
        return LET_GO;
    }
    int result = wait_fd(copy, events, socket_deadline(copy, events));
    if (result == 0) return -EAGAIN;
    return result > 0 ? LET_GO : restarted(of, -errno);
}

// Source or destination of a message in the program, and a buffer in the tracer.
struct parts {
    struct iovec there[PARTS_MAX];
    size_t count, size;
    char *data;
};

static bool take_parts(struct tracee *of, uint64_t at, uint64_t count, struct parts *parts) {
    parts->count = count, parts->size = 0;
    if (count > PARTS_MAX || !get(of, at, parts->there, count * sizeof *parts->there)) return false;
    for (size_t i = 0; i < count; i++) {
        size_t room = LINE_PIECE - parts->size;
        if (parts->there[i].iov_len > room) parts->there[i].iov_len = room;
        parts->size += parts->there[i].iov_len;
    }
    parts->data = malloc(parts->size + 1);
    return parts->data;
}

static bool move_parts(struct tracee *of, const struct parts *parts, size_t size, bool gathers) {
    struct iovec here = {parts->data, size};
    if (size == 0) return true;
    ssize_t moved = gathers ? process_vm_readv(of->tid, &here, 1, parts->there, parts->count, 0)
                            : process_vm_writev(of->tid, &here, 1, parts->there, parts->count, 0);
    return moved == (ssize_t)size;
}

// The parts of a message besides its bytes.
struct beside {
    struct msghdr message;
    char name[128], control[1024];
};

static int64_t transfer_line(struct tracee *of, int64_t fd, struct parts *parts, struct beside *with, int flags,
                             bool is_read) {
    struct descriptor *found = object_of(of, (int)fd);
    int copy = ours(of, (int)fd);
    struct iovec part = {parts->data, parts->size};
    struct beside none = {0};
    struct msghdr *message = with ? &with->message : &none.message;
    message->msg_iov = &part, message->msg_iovlen = 1;
    int64_t result;
    if (!is_read && !move_parts(of, parts, parts->size, true)) return -EFAULT;
    if (found->kind == FD_SERIAL) result = serial_transfer(copy, found, &part, 1, is_read);
    else if (found->kind == FD_ROUTE) result = route_receive(copy, found, message, flags);
    else if (is_read) result = can_receive(copy, found, message, flags);
    else result = can_send(copy, found, message, flags);
    result = result_of(result);
    // With MSG_TRUNC it is the whole length of a message that does not fit.
    size_t given = result > 0 && (size_t)result > parts->size ? parts->size : (size_t)result;
    if (is_read && result > 0 && !move_parts(of, parts, given, false)) return -EFAULT;
    return restarted(of, result);
}

static bool is_line(struct tracee *of, int64_t fd) {
    struct descriptor *found = object_of(of, fd);
    return found && (found->kind == FD_SERIAL || found->kind == FD_CAN);
}

// Whether the tracer itself gives what is read.
static bool is_given(struct tracee *of, int64_t fd) { return is_line(of, fd) || route_answers(object_of(of, fd)); }

// A request for interfaces goes on to the kernel.
static void ask_route(struct tracee *of, int64_t fd, uint64_t at, uint64_t size) {
    struct descriptor *found = object_of(of, fd);
    char data[32];
    if (!found || found->kind != FD_ROUTE) return;
    if (size > sizeof data) size = sizeof data;
    if (get(of, at, data, size)) route_asks(found, data, size);
}

static int64_t transfer_parts(struct tracee *of, const uint64_t *a, bool is_read) {
    bool is_here = is_read ? is_given(of, (int)a[0]) : is_line(of, (int)a[0]);
    if (!is_here) return await(of, (int)a[0], is_read ? POLLIN : POLLOUT, false);
    struct parts *parts = malloc(sizeof *parts);
    int64_t result = -EFAULT;
    if (parts && take_parts(of, a[1], a[2], parts)) {
        result = transfer_line(of, (int)a[0], parts, NULL, 0, is_read);
        free(parts->data);
    }
    free(parts);
    return result;
}

static int64_t transfer(struct tracee *of, const uint64_t *a, struct beside *with, int flags, bool is_read) {
    struct parts parts = {.count = 1, .size = a[2] < LINE_PIECE ? a[2] : LINE_PIECE};
    parts.there[0] = (struct iovec){(void *)a[1], parts.size};
    parts.data = malloc(parts.size + 1);
    int64_t result = parts.data ? transfer_line(of, (int)a[0], &parts, with, flags, is_read) : -ENOMEM;
    free(parts.data);
    return result;
}

static int64_t read_bytes(struct tracee *of, uint64_t *a) {
    return is_given(of, (int)a[0]) ? transfer(of, a, NULL, 0, true) : await(of, (int)a[0], POLLIN, false);
}

static bool is_file(int fd) {
    struct stat state;
    return !REAL(fstat)(fd, &state) && (S_ISREG(state.st_mode) || S_ISBLK(state.st_mode));
}

// A long write to something with limited room is split into pieces that fit.
static int64_t write_pieces(struct tracee *of, const uint64_t *a) {
    uint64_t done = 0;
    while (done < a[2]) {
        int64_t may = await(of, (int)a[0], POLLOUT, false);
        if (may != LET_GO) return done ? (int64_t)done : may;
        uint64_t piece = a[2] - done < PIPE_PIECE ? a[2] - done : PIPE_PIECE;
        int64_t some = CALL(of, SYS_write, a[0], a[1] + done, piece);
        if (some < 0) return done ? (int64_t)done : some;
        done += (uint64_t)some;
    }
    return (int64_t)done;
}

static int64_t write_bytes(struct tracee *of, uint64_t *a) {
    if (is_line(of, (int)a[0])) return transfer(of, a, NULL, 0, false);
    ask_route(of, (int)a[0], a[1], a[2]);
    int copy = ours(of, (int)a[0]);
    if (a[2] > PIPE_PIECE && copy >= 0 && !is_file(copy) && !is_nonblocking(copy)) return write_pieces(of, a);
    return await(of, (int)a[0], POLLOUT, false);
}

static int64_t read_parts(struct tracee *of, uint64_t *a) { return transfer_parts(of, a, true); }
static int64_t write_parts(struct tracee *of, uint64_t *a) { return transfer_parts(of, a, false); }

static int64_t receive_from(struct tracee *of, uint64_t *a) {
    if (!is_given(of, (int)a[0])) return await(of, (int)a[0], POLLIN, a[3] & MSG_DONTWAIT);
    struct beside with = {0};
    socklen_t size = 0;
    if (a[4] && a[5] && !get(of, a[5], &size, sizeof size)) return -EFAULT;
    if (size > sizeof with.name) size = sizeof with.name;
    if (a[4]) with.message.msg_name = with.name, with.message.msg_namelen = size;
    int64_t result = transfer(of, a, &with, (int)a[3], true);
    if (result < 0 || !a[4]) return result;
    socklen_t there = with.message.msg_namelen;
    put(of, a[4], with.name, size < there ? size : there);
    if (a[5]) put(of, a[5], &there, sizeof there);
    return result;
}

static int64_t send_to(struct tracee *of, uint64_t *a) {
    ask_route(of, (int)a[0], a[1], a[2]);
    if (!is_line(of, (int)a[0])) return await(of, (int)a[0], POLLOUT, a[3] & MSG_DONTWAIT);
    struct beside with = {0};
    if (a[4] && (a[5] > sizeof with.name || !get(of, a[4], with.name, a[5]))) return -EFAULT;
    if (a[4]) with.message.msg_name = with.name, with.message.msg_namelen = (socklen_t)a[5];
    return transfer(of, a, &with, (int)a[3], false);
}

static int64_t message(struct tracee *of, const uint64_t *a, bool is_read) {
    int flags = (int)a[2];
    bool is_here = is_read ? is_given(of, (int)a[0]) : is_line(of, (int)a[0]);
    struct msghdr there;
    struct iovec asked;
    if (!is_here && !is_read && object_of(of, (int)a[0]) && get(of, a[1], &there, sizeof there)
        && get(of, (uint64_t)there.msg_iov, &asked, sizeof asked))
        ask_route(of, (int)a[0], (uint64_t)asked.iov_base, asked.iov_len);
    if (!is_here) return await(of, (int)a[0], is_read ? POLLIN : POLLOUT, flags & MSG_DONTWAIT);
    if (!get(of, a[1], &there, sizeof there)) return -EFAULT;
    struct parts *parts = malloc(sizeof *parts);
    if (!parts || !take_parts(of, (uint64_t)there.msg_iov, there.msg_iovlen, parts)) return free(parts), -EFAULT;
    struct beside with = {0};
    socklen_t names = there.msg_namelen < sizeof with.name ? there.msg_namelen : sizeof with.name;
    size_t controls = there.msg_controllen < sizeof with.control ? there.msg_controllen : sizeof with.control;
    if (there.msg_name) with.message.msg_name = with.name, with.message.msg_namelen = names;
    if (there.msg_control) with.message.msg_control = with.control, with.message.msg_controllen = controls;
    int64_t result = -EFAULT;
    if (is_read || !there.msg_name || get(of, (uint64_t)there.msg_name, with.name, names))
        result = transfer_line(of, (int)a[0], parts, &with, flags, is_read);
    if (is_read && result >= 0) {
        socklen_t given = with.message.msg_namelen;
        if (there.msg_name) put(of, (uint64_t)there.msg_name, with.name, names < given ? names : given);
        if (there.msg_control) put(of, (uint64_t)there.msg_control, with.control, with.message.msg_controllen);
        there.msg_namelen = given, there.msg_controllen = with.message.msg_controllen;
        there.msg_flags = with.message.msg_flags;
        put(of, a[1], &there, sizeof there);
    }
    free(parts->data), free(parts);
    return result;
}

static int64_t receive_message(struct tracee *of, uint64_t *a) { return message(of, a, true); }
static int64_t send_message(struct tracee *of, uint64_t *a) { return message(of, a, false); }

// Many messages at once: on lines the program gets the error of a kernel without this call, and falls back to single
// calls.
static int64_t receive_many(struct tracee *of, uint64_t *a) {
    return is_line(of, (int)a[0]) ? -ENOSYS : await(of, (int)a[0], POLLIN, a[3] & MSG_DONTWAIT);
}

static int64_t send_many(struct tracee *of, uint64_t *a) {
    return is_line(of, (int)a[0]) ? -ENOSYS : await(of, (int)a[0], POLLOUT, a[3] & MSG_DONTWAIT);
}

static int64_t accept_one(struct tracee *of, uint64_t *a) { return await(of, (int)a[0], POLLIN, false); }

const struct call calls_of_bytes[] = {
    {SYS_read, read_bytes},       {SYS_write, write_bytes},       {SYS_readv, read_parts},
    {SYS_writev, write_parts},    {SYS_recvfrom, receive_from},   {SYS_sendto, send_to},
    {SYS_recvmsg, receive_message}, {SYS_sendmsg, send_message}, {SYS_recvmmsg, receive_many},
    {SYS_sendmmsg, send_many},    {SYS_accept, accept_one},       {SYS_accept4, accept_one},
    {0},
};
