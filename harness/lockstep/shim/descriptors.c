// Descriptors of the program with a special meaning, and those of the shim itself. The latter have high numbers, and a
// program that closes all unknown descriptors (as daemons do) does not close them.
#include "shim.h"
#include <sys/resource.h>

static struct descriptor table[DESCRIPTORS_MAX];
#define GUARDS_MAX 256
static int guards[GUARDS_MAX];
static int guard_count;

struct descriptor *descriptor(int fd) { return fd >= 0 && fd < DESCRIPTORS_MAX ? &table[fd] : NULL; }

bool is_guarded(int fd) {
    for (int i = 0; i < guard_count; i++)
        if (guards[i] == fd) return true;
    return false;
}

// Our first descriptor at or above a number; the highest number if we have no such descriptor.
unsigned next_guarded(unsigned from) {
    unsigned next = UINT32_MAX;
    for (int i = 0; i < guard_count; i++)
        if ((unsigned)guards[i] >= from && (unsigned)guards[i] < next) next = (unsigned)guards[i];
    return next;
}

// Moves a descriptor out of the way and protects it from being closed.
int guard(int fd) {
    struct rlimit limit = {.rlim_cur = 256};
    getrlimit(RLIMIT_NOFILE, &limit);
    int lowest = limit.rlim_cur > 1024 ? 900 : (int)limit.rlim_cur * 3 / 4;
    int moved = REAL(fcntl)(fd, F_DUPFD_CLOEXEC, lowest);
    if (moved < 0) return fd;
    if (is_guarded(fd)) unguard(fd);
    else REAL(close)(fd);
    if (guard_count < GUARDS_MAX) guards[guard_count++] = moved;
    return moved;
}

void unguard(int fd) {
    for (int i = 0; i < guard_count; i++)
        if (guards[i] == fd) guards[i--] = guards[--guard_count];
    REAL(close)(fd);
}

static void retain(const struct descriptor *of) {
    if (of->kind == FD_SERIAL) ((struct serial *)of->object)->users++;
    if (of->kind == FD_CAN) can_retain(of->object);
    if (of->kind == FD_ROUTE) route_retain(of->object);
    if (of->kind == FD_TIMER) ((struct timer_fd *)of->object)->users++;
}

void descriptor_closed(int fd) {
    struct descriptor *of = descriptor(fd);
    if (!of || of->kind == FD_PLAIN) return;
    struct descriptor was = *of;
    *of = (struct descriptor){0};
    if (was.kind == FD_SERIAL) serial_release(was.object);
    if (was.kind == FD_CAN) can_release(was.object);
    if (was.kind == FD_ROUTE) route_release(was.object);
    if (was.kind == FD_TIMER) timer_fd_release(was.object);
}

void descriptor_set(int fd, enum fd_kind kind, void *object) {
    descriptor_closed(fd);
    if (fd < 0 || fd >= DESCRIPTORS_MAX) return;
    table[fd] = (struct descriptor){.kind = kind, .object = object};
    retain(&table[fd]);
}

void descriptor_copied(int from, int to) {
    if (from == to || to < 0) return;
    struct descriptor *of = descriptor(from);
    if (of && of->kind != FD_PLAIN) descriptor_set(to, of->kind, of->object);
    else descriptor_closed(to);
}
