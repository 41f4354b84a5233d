// Descriptors of the program: the tracer has a copy, under its own number, of each one that the program waits for.
// Special descriptors (a serial line, a CAN socket) are known by that number. A copy is closed before the program
// closes its own: an end of a pipe held by the tracer would never close.
#include "tracer.h"
#include <sys/stat.h>
#include <sys/syscall.h>

static struct slot *slot_of(struct process *process, int64_t fd) {
    return fd >= 0 && fd < DESCRIPTORS_MAX ? &process->slots[fd] : NULL;
}

// The tracer's copy of a descriptor; negative if it does not exist or is out of reach.
int ours(struct tracee *of, int64_t fd) {
    struct slot *slot = slot_of(of->process, fd);
    if (!slot) return -1;
    if (slot->ours > 0) return slot->ours;
    return slot_take(of, (int)fd);
}

int slot_take(struct tracee *of, int fd) {
    struct slot *slot = slot_of(of->process, fd);
    if (!slot) return -1;
    int copy = (int)REAL(syscall)(SYS_pidfd_getfd, of->process->pid_fd, fd, 0);
    if (copy < 0) return -1;
    slot_drop(of->process, (unsigned)fd);
    slot->ours = copy;
    return copy;
}

// The object behind a special descriptor; NULL for any other descriptor.
struct descriptor *object_of(struct tracee *of, int64_t fd) {
    struct slot *slot = slot_of(of->process, fd);
    struct descriptor *found = slot && slot->ours > 0 ? descriptor(slot->ours) : NULL;
    return found && found->kind != FD_PLAIN ? found : NULL;
}

void slot_drop(struct process *process, unsigned fd) {
    struct slot *slot = slot_of(process, fd);
    if (!slot || slot->ours <= 0) return;
    descriptor_closed(slot->ours);
    REAL(close)(slot->ours);
    *slot = (struct slot){0};
}

static void copy_object(const struct slot *from, struct slot *to) {
    struct descriptor *found = descriptor(from->ours);
    if (from->ours <= 0 || !found || found->kind == FD_PLAIN) return;
    to->ours = REAL(fcntl)(from->ours, F_DUPFD_CLOEXEC, 3);
    to->kept = from->kept;
    descriptor_copied(from->ours, to->ours);
}

void slot_copied(struct process *process, int from, int to) {
    if (from == to) return;
    struct slot *source = slot_of(process, from), *target = slot_of(process, to);
    slot_drop(process, (unsigned)to);
    if (source && target) copy_object(source, target);
}

void slots_fork(struct process *from, struct process *to) {
    for (int fd = 0; fd < DESCRIPTORS_MAX; fd++) copy_object(&from->slots[fd], &to->slots[fd]);
}

// Some of them were closed on exec.
void slots_exec(struct tracee *of) {
    for (unsigned fd = 0; fd < DESCRIPTORS_MAX; fd++) {
        if (of->process->slots[fd].ours <= 0) continue;
        struct stat was, is;
        int still = -1;
        if (object_of(of, fd)) still = (int)REAL(syscall)(SYS_pidfd_getfd, of->process->pid_fd, fd, 0);
        bool is_same = still >= 0 && !REAL(fstat)(still, &is) && !REAL(fstat)(of->process->slots[fd].ours, &was)
            && was.st_dev == is.st_dev && was.st_ino == is.st_ino;
        if (still >= 0) REAL(close)(still);
        if (!is_same) slot_drop(of->process, fd);
    }
}

void slots_end(struct process *process) {
    for (unsigned fd = 0; fd < DESCRIPTORS_MAX; fd++) slot_drop(process, fd);
}
