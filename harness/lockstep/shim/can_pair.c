// The pair of local sockets behind a CAN socket, in the program's own process.
#include "can.h"

static struct can_socket *of(int fd) {
    struct descriptor *found = descriptor(fd);
    return found && found->kind == FD_CAN ? found->object : NULL;
}

int can_make_pair(int flags, int *hidden) {
    int pair[2];
    if (REAL(socketpair)(AF_UNIX, SOCK_SEQPACKET | (flags & (SOCK_NONBLOCK | SOCK_CLOEXEC)), 0, pair)) return -1;
    *hidden = guard(pair[1]);
    REAL(fcntl)(*hidden, F_SETFL, O_NONBLOCK);
    return pair[0];
}

// From now on parent and child share the socket: what one receives, the other receives too.
void can_after_fork(void) {
    for (struct can_socket *can = can_sockets; can; can = can->next) {
        can->operations = NULL;
        unguard(can->hidden);
        for (int fd = 0, made = -1; fd < DESCRIPTORS_MAX; fd++) {
            if (of(fd) != can) continue;
            int flags = REAL(fcntl)(fd, F_GETFL), close_on_exec = REAL(fcntl)(fd, F_GETFD);
            if (made < 0) made = can_make_pair(flags & O_NONBLOCK ? SOCK_NONBLOCK : 0, &can->hidden);
            else made = REAL(dup)(made);
            if (made < 0) break;
            REAL(dup3)(made, fd, close_on_exec & FD_CLOEXEC ? O_CLOEXEC : 0);
            REAL(close)(made);
            made = fd;
        }
    }
}
