// CAN sockets without kernel support: each is one end of a pair of local sockets, of which the shim holds the other.
// Whole frames with their time lie in between, so that poll and epoll work as usual.
#ifndef LOCKSTEP_CAN_H
#define LOCKSTEP_CAN_H

#include "shim.h"
#include <linux/can/bcm.h>
#include <linux/can/raw.h>

// Missing in kernel headers before 5.14.
#ifndef CANFD_FDF
#define CANFD_FDF 0x04
#endif

// The kernel's limit (CAN_RAW_FILTER_MAX).
#define FILTERS_MAX 512

// Contents of the pair. The frame comes first: a program that bypasses the shim still finds it.
struct kept_frame {
    struct canfd_frame frame;
    int64_t at_ns;
    int32_t interface;
    int32_t flags;
};

struct can_socket {
    struct can_socket *next;
    int hidden, users, type;
    bool is_broadcast_manager, is_bound, is_shut;
    int interface;
    struct can_filter *filters;
    size_t filter_count;
    bool joins_filters, has_loopback, hears_itself, takes_fd_frames;
    bool has_time, has_time_ns, counts_overflow;
    uint32_t error_mask, dropped;
    struct operation *operations;
};

static inline bool is_fd(const struct canfd_frame *frame) { return frame->flags & CANFD_FDF; }
static inline size_t frame_size(const struct canfd_frame *frame) { return is_fd(frame) ? CANFD_MTU : CAN_MTU; }

extern struct can_socket *can_sockets;
int can_make_pair(int flags, int *hidden);
void can_put(struct can_socket *can, const void *data, size_t size);
int can_transmit(struct can_socket *can, int interface, const struct canfd_frame *frame);
ssize_t bcm_take(struct can_socket *can, int interface, const void *data, size_t size);
void bcm_hear(struct can_socket *can, int interface, const struct canfd_frame *frame);
void bcm_release(struct can_socket *can);

#endif
