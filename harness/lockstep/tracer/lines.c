// Lines as the program sees them: what the shim creates in its own process is created in the program's process, by
// calls on its behalf, and the tracer takes a copy.
#include "tracer.h"
#include <stdio.h>
#include <sys/syscall.h>
#include <sys/un.h>

// Number, in the program, of the descriptor created last.
static int64_t made_fd;

int64_t line_open(struct tracee *of, const char *path, int flags) {
    if (serial_real(path)) return serial_open(path, flags) < 0 ? -errno : made_fd;
    char text[32];
    if (!can_file_text(path, text)) return LET_GO;
    put(of, of->process->scratch, "interface", sizeof "interface");
    // MFD_CLOEXEC is one.
    int64_t fd = CALL(of, SYS_memfd_create, of->process->scratch, flags & O_CLOEXEC ? 1 : 0);
    int copy = fd < 0 ? -1 : slot_take(of, (int)fd);
    if (copy < 0) return fd < 0 ? fd : -EMFILE;
    REAL(write)(copy, text, strlen(text));
    lseek(copy, 0, SEEK_SET);
    slot_drop(of->process, (unsigned)fd);
    return fd;
}

int serial_connect(int number, int flags, int *way) {
    struct tracee *of = present();
    struct sockaddr_un to = {.sun_family = AF_UNIX};
    if (snprintf(to.sun_path, sizeof to.sun_path, "%s%d", link_path(), number) >= (int)sizeof to.sun_path) return -1;
    uint64_t closes = flags & O_CLOEXEC ? SOCK_CLOEXEC : 0;
    int64_t fd = CALL(of, SYS_socket, AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | closes);
    if (fd < 0 || !put(of, of->process->scratch, &to, sizeof to)) return -1;
    int copy = slot_take(of, (int)fd);
    if (copy < 0 || CALL(of, SYS_connect, (uint64_t)fd, of->process->scratch, sizeof to) < 0) return -1;
    made_fd = fd;
    *way = REAL(fcntl)(copy, F_DUPFD_CLOEXEC, 3);
    return *way < 0 ? -1 : copy;
}

// Puts the pty in place of the socket in one descriptor of the program, or the socket again, which is kept meanwhile.
static void redirect(struct tracee *of, int fd, struct slot *slot, const struct serial *serial) {
    uint64_t flags = CALL(of, SYS_fcntl, (uint64_t)fd, F_GETFD) & FD_CLOEXEC ? O_CLOEXEC : 0;
    if (!serial->is_cooked) {
        if (slot->kept <= 0) return;
        CALL(of, SYS_dup3, (uint64_t)slot->kept, (uint64_t)fd, flags);
        CALL(of, SYS_close, (uint64_t)slot->kept);
        slot->kept = 0;
        return;
    }
    const char *path = serial_path(serial->number);
    put(of, of->process->scratch, path, strlen(path) + 1);
    int64_t tty = CALL(of, SYS_openat, (uint64_t)AT_FDCWD, of->process->scratch,
                       O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (tty < 0) return;
    slot->kept = (int)CALL(of, SYS_fcntl, (uint64_t)fd, F_DUPFD_CLOEXEC, 900);
    CALL(of, SYS_dup3, (uint64_t)tty, (uint64_t)fd, flags);
    CALL(of, SYS_close, (uint64_t)tty);
}

void serial_redirect(int copy, const struct serial *serial) {
    struct tracee *of = present();
    REAL(dup3)(serial->is_cooked ? serial->tty : serial->way, copy, O_CLOEXEC);
    for (int fd = 0; fd < DESCRIPTORS_MAX; fd++)
        if (of->process->slots[fd].ours == copy) redirect(of, fd, &of->process->slots[fd], serial);
}

int can_make_pair(int flags, int *hidden) {
    struct tracee *of = present();
    uint64_t scratch = of->process->scratch;
    int pair[2];
    uint64_t type = SOCK_SEQPACKET | (flags & (SOCK_NONBLOCK | SOCK_CLOEXEC));
    int64_t result = CALL(of, SYS_socketpair, AF_UNIX, type, 0, scratch);
    if (result < 0 || !get(of, scratch, pair, sizeof pair)) return errno = EMFILE, -1;
    *hidden = (int)REAL(syscall)(SYS_pidfd_getfd, of->process->pid_fd, pair[1], 0);
    CALL(of, SYS_close, (uint64_t)pair[1]);
    int copy = slot_take(of, pair[0]);
    if (*hidden < 0 || copy < 0) return errno = EMFILE, -1;
    REAL(fcntl)(*hidden, F_SETFL, O_NONBLOCK);
    made_fd = pair[0];
    return copy;
}

int64_t can_socket_open(int type, int protocol) { return can_open(type, protocol) < 0 ? -errno : made_fd; }

// Parent and child share one socket, as in the kernel.
void can_after_fork(void) {}
