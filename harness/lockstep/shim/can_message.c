// Frames in and out of a CAN socket, by read and write and by messages with address, times and flags.
#include "can.h"

static struct iovec part_of(void *data, size_t size) { return (struct iovec){data, size}; }

static size_t scatter(const struct msghdr *message, const void *data, size_t size) {
    size_t done = 0;
    for (size_t i = 0; i < message->msg_iovlen && done < size; i++) {
        size_t some = message->msg_iov[i].iov_len < size - done ? message->msg_iov[i].iov_len : size - done;
        memcpy(message->msg_iov[i].iov_base, (const char *)data + done, some);
        done += some;
    }
    return done;
}

static size_t gather(const struct msghdr *message, void *data, size_t room) {
    size_t done = 0;
    for (size_t i = 0; i < message->msg_iovlen; i++) {
        size_t some = message->msg_iov[i].iov_len;
        if (done + some <= room) memcpy((char *)data + done, message->msg_iov[i].iov_base, some);
        done += some;
    }
    return done;
}

// Adds a control message to a frame; without room, it is left out and marked.
static void add_control(struct msghdr *message, size_t room, int type, const void *data, size_t size) {
    if (message->msg_controllen + CMSG_SPACE(size) > room || !message->msg_control) {
        message->msg_flags |= MSG_CTRUNC;
        return;
    }
    struct cmsghdr *control = (struct cmsghdr *)((char *)message->msg_control + message->msg_controllen);
    control->cmsg_level = SOL_SOCKET;
    control->cmsg_type = type;
    control->cmsg_len = CMSG_LEN(size);
    memcpy(CMSG_DATA(control), data, size);
    message->msg_controllen += CMSG_SPACE(size);
}

static void add_controls(struct can_socket *can, struct msghdr *message, int64_t at_ns) {
    size_t room = message->msg_controllen;
    message->msg_controllen = 0;
    if (can->has_time_ns) {
        struct timespec at = timespec_of(at_ns);
        add_control(message, room, SO_TIMESTAMPNS, &at, sizeof at);
    } else if (can->has_time) {
        struct timeval at = timeval_of(at_ns);
        add_control(message, room, SO_TIMESTAMP, &at, sizeof at);
    }
    if (can->counts_overflow && can->dropped)
        add_control(message, room, SO_RXQ_OVFL, &can->dropped, sizeof can->dropped);
}

// Takes the next item from the pair, after waiting for one if the program blocks.
static ssize_t take(int fd, void *data, size_t room, int flags) {
    struct timeval span = {0};
    socklen_t size = sizeof span;
    int64_t deadline = NEVER;
    bool waits = in_lockstep() && !(flags & MSG_DONTWAIT) && !is_nonblocking(fd);
    if (waits && !REAL(getsockopt)(fd, SOL_SOCKET, SO_RCVTIMEO, &span, &size) && (span.tv_sec || span.tv_usec))
        deadline = deadline_after(span.tv_sec * SECOND + span.tv_usec * 1000);
    for (;;) {
        ssize_t count = REAL(recv)(fd, data, room, MSG_DONTWAIT | (flags & MSG_PEEK));
        if (count >= 0 || errno != EAGAIN) return progressed = true, count;
        if (!waits) {
            question();
            return errno = EAGAIN, -1;
        }
        int ready = wait_fd(fd, POLLIN, deadline);
        if (ready == 0) return errno = EAGAIN, -1;
        if (ready < 0 && errno != ERESTART) return -1;
    }
}

static ssize_t receive_raw(struct can_socket *can, int fd, struct msghdr *message, int flags) {
    struct kept_frame kept;
    ssize_t count = take(fd, &kept, sizeof kept, flags);
    if (count < (ssize_t)sizeof kept) return count < 0 ? -1 : 0;
    size_t size = frame_size(&kept.frame);
    size_t given = scatter(message, &kept.frame, size);
    message->msg_flags = kept.flags | (given < size ? MSG_TRUNC : 0);
    struct sockaddr_can from = {.can_family = AF_CAN, .can_ifindex = kept.interface};
    if (message->msg_name)
        memcpy(message->msg_name, &from, message->msg_namelen < sizeof from ? message->msg_namelen : sizeof from);
    message->msg_namelen = message->msg_name ? sizeof from : 0;
    add_controls(can, message, kept.at_ns);
    return (ssize_t)given;
}

// Receives a message of the broadcast manager: a head with its frames.
static ssize_t receive_manager(int fd, struct msghdr *message, int flags) {
    char data[sizeof(struct bcm_msg_head) + CANFD_MTU];
    ssize_t count = take(fd, data, sizeof data, flags);
    if (count < 0) return -1;
    size_t given = scatter(message, data, (size_t)count);
    message->msg_flags = given < (size_t)count ? MSG_TRUNC : 0;
    message->msg_namelen = 0;
    message->msg_controllen = 0;
    return (ssize_t)given;
}

ssize_t can_receive(int fd, struct descriptor *of, struct msghdr *message, int flags) {
    struct can_socket *can = of->object;
    return can->is_broadcast_manager ? receive_manager(fd, message, flags) : receive_raw(can, fd, message, flags);
}

static ssize_t send_raw(struct can_socket *can, int interface, const struct msghdr *message) {
    struct canfd_frame frame = {0};
    size_t size = gather(message, &frame, sizeof frame);
    bool has_fd_size = size == CANFD_MTU && can->takes_fd_frames;
    if (size != CAN_MTU && !has_fd_size) return errno = EINVAL, -1;
    if (frame.len > (has_fd_size ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) return errno = EINVAL, -1;
    frame.flags = has_fd_size ? frame.flags | CANFD_FDF : 0;
    if (can_transmit(can, interface, &frame)) return -1;
    sending();
    return (ssize_t)size;
}

ssize_t can_send(int fd, struct descriptor *of, const struct msghdr *message, int flags) {
    (void)fd, (void)flags;
    struct can_socket *can = of->object;
    const struct sockaddr_can *to = message->msg_name;
    int interface = to && message->msg_namelen >= offsetof(struct sockaddr_can, can_addr) ? to->can_ifindex
                                                                                         : can->interface;
    if (!can->is_broadcast_manager) return send_raw(can, interface, message);
    size_t size = gather(message, NULL, 0);
    char *data = malloc(size + 1);
    if (!data) return errno = ENOMEM, -1;
    gather(message, data, size);
    ssize_t taken = bcm_take(can, interface, data, size);
    int kept = errno;
    free(data);
    errno = kept;
    return taken;
}

ssize_t can_read(int fd, struct descriptor *of, void *data, size_t size) {
    struct iovec part = part_of(data, size);
    return can_receive(fd, of, &(struct msghdr){.msg_iov = &part, .msg_iovlen = 1}, 0);
}

ssize_t can_write(int fd, struct descriptor *of, const void *data, size_t size) {
    struct iovec part = part_of((void *)data, size);
    return can_send(fd, of, &(struct msghdr){.msg_iov = &part, .msg_iovlen = 1}, 0);
}
