// Life of a CAN socket: created, bound, configured. The shim's own functions handle it, on the tracer's copy.
#include "tracer.h"
#include <sys/syscall.h>

// Room for the maximum number of filters.
#define OPTION_MAX (FILTERS_MAX * sizeof(struct can_filter))

static int can_copy(struct tracee *of, uint64_t fd) {
    struct descriptor *found = object_of(of, (int)fd);
    return found && found->kind == FD_CAN ? ours(of, (int)fd) : -1;
}

static int64_t make_socket(struct tracee *of, uint64_t *a) {
    if ((int)a[0] == AF_CAN) return can_socket_open((int)a[1], (int)a[2]);
    if (!is_route((int)a[0], (int)a[2])) return LET_GO;
    int64_t fd = CALL(of, SYS_socket, a[0], a[1], a[2]);
    int copy = fd < 0 ? -1 : slot_take(of, (int)fd);
    if (copy >= 0) route_open(copy);
    return fd;
}

static int64_t name(struct tracee *of, const uint64_t *a, int (*how)(int, const struct sockaddr *, socklen_t)) {
    struct sockaddr_storage address;
    int copy = can_copy(of, a[0]);
    if (copy < 0) return LET_GO;
    if (a[2] > sizeof address) return -EINVAL;
    if (!get(of, a[1], &address, a[2])) return -EFAULT;
    return result_of(how(copy, (struct sockaddr *)&address, (socklen_t)a[2]));
}

static int64_t bind_socket(struct tracee *of, uint64_t *a) { return name(of, a, bind); }
static int64_t connect_socket(struct tracee *of, uint64_t *a) { return name(of, a, connect); }

static int64_t own_name(struct tracee *of, uint64_t *a) {
    struct sockaddr_storage address = {0};
    socklen_t room, size = sizeof address;
    int copy = can_copy(of, a[0]);
    if (copy < 0) return LET_GO;
    if (!get(of, a[2], &room, sizeof room)) return -EFAULT;
    if (getsockname(copy, (struct sockaddr *)&address, &size)) return -errno;
    return put(of, a[1], &address, room < size ? room : size) && put(of, a[2], &size, sizeof size) ? 0 : -EFAULT;
}

static int64_t set_option(struct tracee *of, uint64_t *a) {
    char value[OPTION_MAX];
    int copy = can_copy(of, a[0]);
    if (copy < 0) return LET_GO;
    if (a[4] > sizeof value) return -EINVAL;
    if (a[3] && !get(of, a[3], value, a[4])) return -EFAULT;
    return result_of(setsockopt(copy, (int)a[1], (int)a[2], a[3] ? value : NULL, (socklen_t)a[4]));
}

static int64_t ask_option(struct tracee *of, uint64_t *a) {
    char value[OPTION_MAX];
    socklen_t size;
    int copy = can_copy(of, a[0]);
    if (copy < 0) return LET_GO;
    if (!get(of, a[4], &size, sizeof size)) return -EFAULT;
    if (size > sizeof value) size = sizeof value;
    if (getsockopt(copy, (int)a[1], (int)a[2], value, &size)) return -errno;
    return put(of, a[3], value, size) && put(of, a[4], &size, sizeof size) ? 0 : -EFAULT;
}

const struct call calls_of_sockets[] = {
    {SYS_socket, make_socket},    {SYS_bind, bind_socket},      {SYS_connect, connect_socket},
    {SYS_getsockname, own_name},  {SYS_setsockopt, set_option}, {SYS_getsockopt, ask_option},
    {0},
};
