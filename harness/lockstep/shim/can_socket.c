// Life of a CAN socket: created, bound, configured, read, closed.
#include "can.h"
#include <net/if.h>
#include <stdio.h>

struct can_socket *can_sockets;

static struct can_socket *of(int fd) {
    struct descriptor *found = descriptor(fd);
    return found && found->kind == FD_CAN ? found->object : NULL;
}

int can_open(int type, int protocol) {
    int plain = type & ~(SOCK_NONBLOCK | SOCK_CLOEXEC);
    bool is_raw = plain == SOCK_RAW && protocol == CAN_RAW;
    if (!is_raw && !(plain == SOCK_DGRAM && protocol == CAN_BCM)) return errno = EPROTONOSUPPORT, -1;
    struct can_socket *made = calloc(1, sizeof *made);
    if (!made) return errno = ENOMEM, -1;
    int fd = can_make_pair(type, &made->hidden);
    if (fd < 0) return free(made), -1;
    made->type = plain;
    made->is_broadcast_manager = !is_raw;
    made->has_loopback = true;
    made->filters = calloc(1, sizeof *made->filters);
    made->filter_count = made->filters ? 1 : 0;
    struct can_socket **end = &can_sockets;
    while (*end) end = &(*end)->next;
    *end = made;
    descriptor_set(fd, FD_CAN, made);
    return fd;
}

void can_retain(struct can_socket *can) { can->users++; }

void can_release(struct can_socket *can) {
    if (--can->users > 0) return;
    struct can_socket **place = &can_sockets;
    while (*place && *place != can) place = &(*place)->next;
    if (*place) *place = can->next;
    bcm_release(can);
    unguard(can->hidden);
    free(can->filters);
    free(can);
}

EXPORT int socket(int family, int type, int protocol) {
    if (is_managed() && family == AF_CAN) return can_open(type, protocol);
    int fd = REAL(socket)(family, type, protocol);
    if (fd >= 0) descriptor_closed(fd);
    if (fd >= 0 && is_managed() && is_route(family, protocol)) route_open(fd);
    return fd;
}

EXPORT int bind(int fd, const struct sockaddr *address, socklen_t size) {
    struct can_socket *can = of(fd);
    if (!can) return REAL(bind)(fd, address, size);
    const struct sockaddr_can *to = (const struct sockaddr_can *)address;
    if (size < offsetof(struct sockaddr_can, can_addr) || to->can_family != AF_CAN) return errno = EINVAL, -1;
    if (to->can_ifindex && !can_name(to->can_ifindex)) return errno = ENODEV, -1;
    can->interface = to->can_ifindex;
    can->is_bound = true;
    return 0;
}

EXPORT int connect(int fd, const struct sockaddr *address, socklen_t size) {
    struct can_socket *can = of(fd);
    if (!can) return REAL(connect)(fd, address, size);
    return can->is_broadcast_manager ? bind(fd, address, size) : (errno = EOPNOTSUPP, -1);
}

EXPORT int getsockname(int fd, struct sockaddr *restrict address, socklen_t *restrict size) {
    struct can_socket *can = of(fd);
    if (!can) return REAL(getsockname)(fd, address, size);
    struct sockaddr_can own = {.can_family = AF_CAN, .can_ifindex = can->interface};
    memcpy(address, &own, *size < sizeof own ? *size : sizeof own);
    *size = sizeof own;
    return 0;
}

static int set_filters(struct can_socket *can, const void *value, socklen_t size) {
    size_t count = size / sizeof *can->filters;
    if (size % sizeof *can->filters || count > FILTERS_MAX) return errno = EINVAL, -1;
    struct can_filter *copy = malloc(size + 1);
    if (!copy) return errno = ENOMEM, -1;
    if (size) memcpy(copy, value, size);
    free(can->filters);
    can->filters = copy;
    can->filter_count = count;
    return 0;
}

static int set_raw(struct can_socket *can, int option, const void *value, socklen_t size) {
    if (can->is_broadcast_manager) return errno = ENOPROTOOPT, -1;
    if (option == CAN_RAW_FILTER) return set_filters(can, value, size);
    if (size != sizeof(int) || !value) return errno = EINVAL, -1;
    int flag = *(const int *)value;
    switch (option) {
    case CAN_RAW_ERR_FILTER: can->error_mask = (uint32_t)flag & CAN_ERR_MASK; return 0;
    case CAN_RAW_LOOPBACK: can->has_loopback = flag; return 0;
    case CAN_RAW_RECV_OWN_MSGS: can->hears_itself = flag; return 0;
    case CAN_RAW_FD_FRAMES: can->takes_fd_frames = flag; return 0;
    case CAN_RAW_JOIN_FILTERS: can->joins_filters = flag; return 0;
    default: return errno = ENOPROTOOPT, -1;
    }
}

EXPORT int setsockopt(int fd, int level, int option, const void *value, socklen_t size) {
    struct can_socket *can = of(fd);
    if (!can) return REAL(setsockopt)(fd, level, option, value, size);
    if (level == SOL_CAN_RAW) return set_raw(can, option, value, size);
    if (level != SOL_SOCKET) return errno = ENOPROTOOPT, -1;
    bool flag = size >= sizeof(int) && *(const int *)value;
    switch (option) {
    case SO_TIMESTAMP: can->has_time = flag; return 0;
    case SO_TIMESTAMPNS: can->has_time_ns = flag; return 0;
    case SO_RXQ_OVFL: can->counts_overflow = flag; return 0;
    // Hardware timestamps would be those of the harness's clock, which the others already give.
    case SO_TIMESTAMPING: return errno = EOPNOTSUPP, -1;
    default: return REAL(setsockopt)(fd, level, option, value, size);
    }
}

static int answer(void *value, socklen_t *size, const void *from, size_t there) {
    if (*size < there) there = *size;
    memcpy(value, from, there);
    *size = (socklen_t)there;
    return 0;
}

EXPORT int getsockopt(int fd, int level, int option, void *restrict value, socklen_t *restrict size) {
    struct can_socket *can = of(fd);
    if (!can) return REAL(getsockopt)(fd, level, option, value, size);
    int flag;
    if (level == SOL_SOCKET) {
        switch (option) {
        case SO_DOMAIN: flag = AF_CAN; break;
        case SO_TYPE: flag = can->type; break;
        case SO_PROTOCOL: flag = can->is_broadcast_manager ? CAN_BCM : CAN_RAW; break;
        case SO_TIMESTAMP: flag = can->has_time; break;
        case SO_TIMESTAMPNS: flag = can->has_time_ns; break;
        case SO_RXQ_OVFL: flag = can->counts_overflow; break;
        default: return REAL(getsockopt)(fd, level, option, value, size);
        }
        return answer(value, size, &flag, sizeof flag);
    }
    if (level != SOL_CAN_RAW || can->is_broadcast_manager) return errno = ENOPROTOOPT, -1;
    switch (option) {
    case CAN_RAW_FILTER: return answer(value, size, can->filters, can->filter_count * sizeof *can->filters);
    case CAN_RAW_ERR_FILTER: flag = (int)can->error_mask; break;
    case CAN_RAW_LOOPBACK: flag = can->has_loopback; break;
    case CAN_RAW_RECV_OWN_MSGS: flag = can->hears_itself; break;
    case CAN_RAW_FD_FRAMES: flag = can->takes_fd_frames; break;
    case CAN_RAW_JOIN_FILTERS: flag = can->joins_filters; break;
    default: return errno = ENOPROTOOPT, -1;
    }
    return answer(value, size, &flag, sizeof flag);
}

static bool matches(const struct can_filter *filter, canid_t id) {
    bool inverted = filter->can_id & CAN_INV_FILTER;
    return ((id & filter->can_mask) == (filter->can_id & ~CAN_INV_FILTER & filter->can_mask)) != inverted;
}

static bool passes(const struct can_socket *can, canid_t id) {
    if (id & CAN_ERR_FLAG) return id & can->error_mask;
    size_t matched = 0;
    for (size_t i = 0; i < can->filter_count; i++) matched += matches(&can->filters[i], id);
    return can->joins_filters ? can->filter_count && matched == can->filter_count : matched > 0;
}

// A queue that is never read fills up; then frames are lost and counted, as in the kernel.
void can_put(struct can_socket *can, const void *data, size_t size) {
    if (REAL(send)(can->hidden, data, size, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) can->dropped++;
}

// Passes a frame to all sockets that receive it; `from` is the sending socket of this process.
void can_deliver(const struct sent_frame *sent, const struct can_socket *from) {
    int interface = (int)sent->interface;
    bool is_error = sent->frame.can_id & CAN_ERR_FLAG;
    if (is_error && !from && !sent->is_local) can_errs(interface, sent->frame.can_id);
    struct kept_frame kept = {.frame = sent->frame, .at_ns = clock_ns(CLOCK_REALTIME), .interface = interface};
    for (struct can_socket *can = can_sockets; can; can = can->next) {
        if (!can->is_bound || (can->interface && can->interface != interface)) continue;
        if (can->is_broadcast_manager) {
            if (!is_error) bcm_hear(can, interface, &sent->frame);
            continue;
        }
        if (can == from && !can->hears_itself) continue;
        if (!passes(can, sent->frame.can_id) || (is_fd(&sent->frame) && !can->takes_fd_frames)) continue;
        kept.flags = (sent->is_local ? MSG_DONTROUTE : 0) | (can == from ? MSG_CONFIRM : 0);
        can_put(can, &kept, sizeof kept);
    }
}

int can_transmit(struct can_socket *can, int interface, const struct canfd_frame *frame) {
    if (!can_name(interface)) return errno = interface ? ENODEV : ENXIO, -1;
    if (is_fd(frame) && !can_takes_fd(interface)) return errno = EINVAL, -1;
    // An interface without carrier has no queue: what is sent is lost, and `write` succeeds.
    if (can_is_off(interface)) return progressed = true, 0;
    // Tells the harness whether other processes receive it.
    struct sent_frame sent = {(uint32_t)interface, can->has_loopback, *frame};
    link_send_frame(&sent);
    if (can->has_loopback) can_deliver(&sent, can);
    progressed = true;
    return 0;
}
